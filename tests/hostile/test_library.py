"""Careless and hostile calls of the library: each ends in one line that names what is wrong, or in an answer, at once.

A row is a name, a call, and the beginning of the line: who is wrong, and how; None where there is an answer.
"""

import decimal
import math
import resource
import warnings
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.motion.span import MOST_TURNS
from firstcontact.scene.load import load_scene

INF, NAN, HUGE = math.inf, math.nan, 10**400
MOST_SECONDS, MOST_KILOBYTES = 10, 1 << 20  # of CPU; of memory beyond what was used before
TET, TF = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
P = fc.Polyhedron


def cube():
    return fc.examples.box((2, 2, 2)).named("cube")


def ball(radius=1):
    return fc.sphere(radius, name="ball")


def slide(vector=(0, 0, 6)):
    return fc.Translation(vector)


def turn(**angle):
    return fc.Rotation((0, 0, 1), **(angle or {"degrees": 90}))


def pair():
    return cube().moving(slide()), cube().translated((0.5, 0.5, 5))


def balls():
    return ball().moving(slide()), ball().translated((0, 0, 5))


def strip(**keys):
    return fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", name="strip", **keys)


def strips():
    return strip().moving(slide((0, 0, -6))), strip().translated((0, 0.25, 5))


def still():
    return strip(), strip().rotated((0, 0, 1), degrees=90).translated((0.5, 0, 0.25))


def verb(name, bodies, *span, **keys):
    return lambda: getattr(fc, name)(*bodies(), *span, **keys)


def short(value):
    """A value in the name of a row."""
    try:
        return repr(value)[:40].replace("\n", " ")
    except ValueError:
        return "thousands of digits"


ROWS = [
    ("poly none", lambda: P(None, None, name="lid"), "lid: no vertices"),
    ("poly empty", lambda: P([], [], name="lid"), "lid: no vertices"),
    ("poly str", lambda: P("abc", "def", name="lid"), "lid: vertices have shape (3, 1)"),
    ("poly int", lambda: P(5, [], name="lid"), "lid: no vertices"),
    ("poly strings", lambda: P([["a", "b", "c"]], [], name="lid"), "lid: vertex 0, coordinate 0 is 'a'"),
    ("poly 2d", lambda: P([[0, 0]], [], name="lid"), "lid: vertices have shape (1, 2)"),
    ("poly ragged", lambda: P([[0, 0, 0], [0, 0]], [], name="lid"), "lid: vertices have shape (2, 2)"),
    ("poly nan", lambda: P([[0, 0, NAN]], [], name="lid"), "lid: vertex 0, coordinate 2 is nan"),
    ("poly inf", lambda: P([[0, 0, INF]], [], name="lid"), "lid: vertex 0, coordinate 2 is inf"),
    ("poly huge int", lambda: P([[0, 0, HUGE]], [], name="lid"), "lid: vertex 0, coordinate 2 is inf"),
    ("poly huge str", lambda: P([[0, 0, "1e400"]], [], name="lid"), "lid: vertex 0, coordinate 2 is inf"),
    (
        "poly endless str",
        lambda: P([[0, 0, "1e999999999"]], [], name="lid"),
        "lid: vertex 0, coordinate 2 is '1e999999999'",
    ),
    (
        "poly endless decimal",
        lambda: P([[0, 0, decimal.Decimal("1e999999999")]], [], name="lid"),
        "lid: vertex 0, coordinate 2 is '1E+999999999",
    ),
    (
        "poly nan decimal",
        lambda: P([[0, 0, decimal.Decimal("NaN")]], [], name="lid"),
        "lid: vertex 0, coordinate 2 is 'NaN'",
    ),
    (
        "poly 5000 digits str",
        lambda: P([[0, 0, "1" * 5000]], [], name="lid"),
        "lid: vertex 0, coordinate 2 is a text of 500",
    ),
    (
        "poly 5000 digits after point",
        lambda: P([[0, 0, "0." + "1" * 5000]], [], name="lid"),
        "lid: vertex 0, coordinate 2 is a text of 500",
    ),
    ("poly complex", lambda: P([[0, 0, 1j]], [], name="lid"), "lid: vertex 0, coordinate 2 is 1j"),
    (
        "poly complex array",
        lambda: P(np.zeros((3, 3), complex), [[0, 1, 2]], name="lid"),
        "lid: vertex 0, coordinate 0 is np.complex128",
    ),
    ("poly object array", lambda: P(np.array([[None] * 3]), [], name="lid"), "lid: vertex 0, coordinate 0 is None"),
    ("poly bool", lambda: P([[True, None, 0]], [], name="lid"), "lid: vertex 0, coordinate 1 is None"),
    ("poly bytes", lambda: P([[b"1", 0, 0]], [], name="lid"), "lid: vertex 0, coordinate 0 is b'1'"),
    ("poly dict", lambda: P({"a": 1}, [], name="lid"), "lid: vertices have shape (1, 1)"),
    ("poly 3d array", lambda: P(np.zeros((2, 2, 3)), [], name="lid"), "lid: vertices have shape (2, 2, 3)"),
    ("face outside", lambda: P(TET, [[0, 1, 9]], name="lid"), "lid: face 0 is [0, 1, 9], but there are 4 ve"),
    ("face negative", lambda: P(TET, [[0, 1, -1]], name="lid"), "lid: face 0 is [0, 1, -1], but there are 4 v"),
    ("face huge int", lambda: P(TET, [[0, 1, HUGE]], name="lid"), "lid: faces hold object values"),
    ("face float", lambda: P(TET, [[0, 1, 1.5]], name="lid"), "lid: faces hold float64 values"),
    ("face nan", lambda: P(TET, [[0, 1, NAN]], name="lid"), "lid: faces hold float64 values"),
    ("face str", lambda: P(TET, [["a", "b", "c"]], name="lid"), "lid: faces hold <U1 values"),
    ("face None", lambda: P(TET, [None], name="lid"), "lid: face 0 is None"),
    ("face empty", lambda: P(TET, [[]], name="lid"), "lid: face 0 has a ring of 0 vertices"),
    ("face short", lambda: P(TET, [[0, 1]], name="lid"), "lid: face 0 has a ring of 2 vertices"),
    ("face repeats", lambda: P(TET, [[0, 0, 1]], name="lid"), None),
    ("face poly repeats", lambda: P(TET, [[0, 1, 0, 1]], name="lid"), "lid: face 0 is not a planar polygon"),
    ("face all same", lambda: P(TET, [[0, 0, 0, 0]], name="lid"), "lid: face 0 is not a planar polygon"),
    ("face nested deep", lambda: P(TET, [[[[0, 1, 2]]]], name="lid"), "lid: face 0 is [[[0, 1, 2]]]"),
    ("face ragged", lambda: P(TET, [[0, 1, 2], [0]], name="lid"), "lid: face 1 has a ring of 1 vertices"),
    ("face dict", lambda: P(TET, {"a": 1}, name="lid"), "lid: face 0 is 'a'"),
    ("face generator", lambda: P(TET, (f for f in TF), name="lid"), "lid: faces is <generator object <lambda>.<lo"),
    ("face mixed ring", lambda: P(TET, [[0, [1], 2]], name="lid"), "lid: face 0 is [0, [1], 2]"),
    (
        "face uint64",
        lambda: P(TET, np.array([[0, 1, 2**63]], np.uint64), name="lid"),
        "lid: face 0 is [0, 1, 9223372036854775808], ",
    ),
    (
        "face warped",
        lambda: P([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2, 3]], name="lid"),
        "lid: face 0 is not a planar polygon",
    ),
    (
        "face bowtie",
        lambda: P([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2, 3]], name="lid"),
        "lid: face 0 is not a planar polygon",
    ),
    ("edges str", lambda: P(TET, [], edges="ab", name="lid"), "lid: edges have shape ()"),
    ("edges outside", lambda: P(TET, [], edges=[[0, 9]], name="lid"), "lid: edge 0 is [0, 9], but there are 4 verti"),
    ("edges ragged", lambda: P(TET, [], edges=[[0, 1], [2]], name="lid"), "lid: edges are [[0, 1], [2]]"),
    ("edges float", lambda: P(TET, [], edges=[[0, 1.5]], name="lid"), "lid: edges have shape (1, 2)"),
    ("edges huge", lambda: P(TET, [], edges=[[0, HUGE]], name="lid"), "lid: edges have shape (1, 2)"),
    ("edges int", lambda: P(TET, [], edges=5, name="lid"), "lid: edges have shape ()"),
    ("edges None inside", lambda: P(TET, [], edges=[[None, 1]], name="lid"), "lid: edges have shape (1, 2)"),
    ("solid open", lambda: P(TET, TF[:3], solid=True, name="lid"), "lid: solid=True, but the mesh is open (first"),
    ("solid str", lambda: P(TET, TF, solid="maybe", name="lid"), None),
    ("name int", lambda: str(fc.first_contact(P(TET, TF, name=5).moving(slide()), cube().translated((0, 0, 9)))), None),
    (
        "named list",
        lambda: str(fc.first_contact(cube().named(["x"]).moving(slide()), cube().translated((0, 0, 9)))),
        "name is ['x']; give a text",
    ),
    ("load long", lambda: P.load("x" * 5000 + ".stl"), ""),
    ("load long no suffix", lambda: P.load("x" * 5000), ""),
    ("load null", lambda: P.load("a\0b.stl"), "a\x00b.stl: no such file"),
    ("load none", lambda: P.load(None), "None is no path"),
    ("load int", lambda: P.load(5), "5 is no path"),
    ("load empty", lambda: P.load(""), ".: unknown mesh format ''"),
    ("load surrogate", lambda: P.load("\udcff.stl"), "\udcff.stl: no such file"),
    ("load newline", lambda: P.load("a\nb.stl"), "a b.stl: no such file"),
    ("load bytes", lambda: P.load(b"a.stl"), "b'a.stl' is no path"),
    ("from_trimesh None", lambda: P.from_trimesh(None), "from_trimesh: None is no mesh"),
    ("from_trimesh int", lambda: P.from_trimesh(5), "from_trimesh: 5 is no mesh"),
    ("translated None", lambda: cube().translated(None), "translation is None"),
    ("translated nan", lambda: cube().translated((0, 0, NAN)), "translation[2] is nan"),
    ("translated huge", lambda: cube().translated((0, 0, "1e400")), "translation[2] is '1e400'"),
    ("translated str", lambda: cube().translated("xyz"), "translation[0] is 'x'"),
    ("rotated zero", lambda: cube().rotated((0, 0, 0), degrees=1), "rotation axis is zero"),
    ("rotated inf", lambda: cube().rotated((0, 0, 1), degrees=INF), "rotation degrees is inf"),
    ("rotated huge degrees", lambda: cube().rotated((0, 0, 1), degrees="1e9999"), None),
    ("rotated 1e300 axis", lambda: cube().rotated((0, 0, 1e-300), degrees=30), None),
    ("rotated none degrees", lambda: cube().rotated((0, 0, 1), degrees=None), "rotation degrees is None"),
    ("transformed None", lambda: cube().transformed(None), "transformed() needs a 4x4 matrix"),
    (
        "transformed singular",
        lambda: cube().transformed(np.zeros((4, 4))),
        "the last row of the matrix is not (0, 0, 0, ",
    ),
    ("transformed ragged", lambda: cube().transformed([[1], [2]]), "transformed() needs a 4x4 matrix"),
    ("transformed ints", lambda: cube().transformed([1, 2, 3, 4]), "transformed() needs a 4x4 matrix"),
    ("transformed nan", lambda: cube().transformed(np.full((4, 4), NAN)), "matrix[0][0] is nan"),
    (
        "transformed huge",
        lambda: cube().transformed([[HUGE, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
        "cube: coordinates leave the range 2^150 unde",
    ),
    (
        "transformed tiny solid",
        lambda: ball().transformed([["1e-400", 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
        "ball: this map makes it smaller by more than",
    ),
    (
        "transformed huge solid",
        lambda: ball().transformed([[HUGE, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).bounds(),
        "ball: coordinates leave the range 2^150 unde",
    ),
    (
        "ruled transformed huge",
        lambda: strip().transformed([[HUGE, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).bounds(),
        None,
    ),
    ("moving none", lambda: cube().moving(None), "None is no motion"),
    ("moving str", lambda: cube().moving("slide"), "'slide' is no motion"),
    ("moving class", lambda: cube().moving(fc.Translation), "<class 'firstcontact.motion.translation.Tran"),
    (
        "moving twice",
        lambda: fc.first_contact(cube().moving(slide()).moving(slide()), cube()),
        "<Polyhedron 'cube': solid, 8 vertices, 18 ed",
    ),
    (
        "moving span only",
        lambda: fc.first_contact(cube().moving(type("M", (), {"span": 5, "__call__": lambda s, t: 1})()), cube()),
        " of 'cube': polyhedra take Translation",
    ),
    ("at str", lambda: cube().moving(slide()).at("soon"), "time is 'soon'"),
    ("at none", lambda: cube().moving(slide()).at(None), "time is None"),
    ("at nan", lambda: cube().moving(slide()).at(NAN), "time is nan"),
    ("at inf", lambda: cube().moving(slide()).at(INF), "time is inf"),
    ("at huge", lambda: cube().moving(slide()).at(HUGE), "time is 1"),
    ("at nan turn", lambda: cube().moving(turn()).at(NAN), "time is nan"),
    ("at huge turn", lambda: cube().moving(turn()).at(HUGE), "time is 1"),
    ("at inf turn", lambda: cube().moving(turn()).at(INF), "time is inf"),
    ("at nan screw", lambda: cube().moving(fc.Screw((0, 0, 1), degrees=9, advance=1)).at(NAN), "time is nan"),
    ("at huge screw", lambda: cube().moving(fc.Screw((0, 0, 1), degrees=9, advance=1)).at(HUGE), "time is 1"),
    ("at str screw", lambda: cube().moving(fc.Screw((0, 0, 1), degrees=9, advance=1)).at("x"), "time is 'x'"),
    ("at nan seq", lambda: cube().moving(fc.Sequence([slide()])).at(NAN), "time is nan"),
    ("at str seq", lambda: cube().moving(fc.Sequence([slide()])).at("x"), "time is 'x'"),
    ("at nan rational", lambda: cube().moving(fc.RationalMotion([np.eye(4).tolist()])).at(NAN), "time is nan"),
    (
        "at str traj",
        lambda: cube().moving(fc.Trajectory([0, 1], [(0, 0, 0), (1, 0, 0)], quat_wxyz=[(1, 0, 0, 0)] * 2)).at("x"),
        "time is 'x'",
    ),
    (
        "at nan traj",
        lambda: cube().moving(fc.Trajectory([0, 1], [(0, 0, 0), (1, 0, 0)], quat_wxyz=[(1, 0, 0, 0)] * 2)).at(NAN),
        "time is nan",
    ),
    ("at strip nan", lambda: fc.RuledSurface("(u,0,T)", "(u,1,T)").at(NAN), "ruled surface: time is nan"),
    ("at strip inf", lambda: fc.RuledSurface("(u,0,T)", "(u,1,T)").at(INF), "ruled surface: time is inf"),
    ("at strip str", lambda: fc.RuledSurface("(u,0,T)", "(u,1,T)").at("x"), "ruled surface: time is 'x'"),
    ("bounds span none", lambda: cube().moving(slide()).bounds("ab"), "span is 'ab'"),
    ("bounds span nan", lambda: cube().moving(slide()).bounds((0, NAN)), "span is (0, nan)"),
    ("bounds span huge", lambda: cube().moving(slide()).bounds((0, HUGE)), "span is (0, 1"),
    ("bounds span reversed", lambda: cube().moving(slide()).bounds((1, 0)), "span is (1, 0)"),
    ("bounds span int", lambda: cube().moving(slide()).bounds(5), "span is 5"),
    ("rotation zero", lambda: fc.Rotation((0, 0, 0), degrees=9), "Rotation axis is zero"),
    ("rotation none angle", lambda: fc.Rotation((0, 0, 1)), "Rotation needs exactly one of radians=, degr"),
    (
        "rotation two angles",
        lambda: fc.Rotation((0, 0, 1), degrees=1, turns=1),
        "Rotation needs exactly one of radians=, degr",
    ),
    ("rotation nan", lambda: fc.Rotation((0, 0, 1), degrees=NAN), "Rotation degrees is nan"),
    ("rotation list", lambda: fc.Rotation((0, 0, 1), degrees=[1]), "Rotation degrees is [1]"),
    ("rotation str", lambda: fc.Rotation((0, 0, 1), degrees="right"), "Rotation degrees is 'right'"),
    (
        "rotation 1e9999 turns",
        lambda: fc.first_contact(
            cube().moving(fc.Rotation((0, 0, 1), turns="1e9999")), cube().translated((9, 0, 0)), budget=1000
        ),
        "Rotation turns is '1e9999'",
    ),
    (
        "rotation 1e400 turns repr",
        lambda: repr(fc.Rotation((0, 0, 1), turns=HUGE)) + str(fc.Rotation((0, 0, 1), turns=HUGE)(0.5)),
        "Rotation turns is 1",
    ),
    ("rotation tiny axis", lambda: fc.Rotation((0, 0, 1e-320), degrees=9)(0.5), None),
    ("rotation huge axis", lambda: fc.Rotation((2.0**149,) * 3, degrees=9)(0.5), None),
    (
        "screw huge advance",
        lambda: fc.first_contact(
            cube().moving(fc.Screw((0, 0, 1), degrees=9, advance=HUGE)), cube().translated((9, 0, 0))
        ),
        "Screw advance is 1",
    ),
    ("screw nan advance", lambda: fc.Screw((0, 0, 1), degrees=9, advance=NAN), "Screw advance is nan"),
    ("screw tiny axis", lambda: fc.Screw((0, 0, "1e-400"), degrees=9, advance=1)(0.5), None),
    ("rational none", lambda: fc.RationalMotion(None), "RationalMotion coefficients are None"),
    ("rational empty", lambda: fc.RationalMotion([]), "RationalMotion has no coefficients"),
    ("rational str", lambda: fc.RationalMotion("abc"), "coefficients[0] is no 4x4 matrix"),
    ("rational ragged", lambda: fc.RationalMotion([[[1]]]), "coefficients[0] is no 4x4 matrix"),
    ("rational nan", lambda: fc.RationalMotion([np.full((4, 4), NAN)]), "coefficients[0][0][0] is nan"),
    ("rational zero", lambda: fc.RationalMotion([np.zeros((4, 4))]), "RationalMotion: the weight, entry [3][3], is"),
    (
        "rational huge",
        lambda: fc.RationalMotion(
            [
                [[HUGE, 0, 0, 0], [0, HUGE, 0, 0], [0, 0, HUGE, 0], [0, 0, 0, HUGE]],
                [[0, 0, 0, HUGE], [0] * 4, [0] * 4, [0] * 4],
            ]
        ),
        "coefficients[0] has an entry of 2^150 or mor",
    ),
    ("rational int", lambda: fc.RationalMotion(5), "RationalMotion coefficients are 5"),
    ("rational ints", lambda: fc.RationalMotion([5]), "coefficients[0] is 5"),
    ("between none", lambda: fc.RationalMotion.between(None, None), "pose0 is None"),
    (
        "between half",
        lambda: fc.RationalMotion.between(np.eye(4), np.diag([-1, -1, 1, 1])),
        "pose0 and pose1 are half a turn apart, so ne",
    ),
    ("between nan", lambda: fc.RationalMotion.between(np.full((4, 4), NAN), np.eye(4)), "pose0[0][0] is nan"),
    (
        "between not rotation",
        lambda: fc.RationalMotion.between(np.eye(4) * 2, np.eye(4)),
        "pose0: the last row is not (0, 0, 0, 1)",
    ),
    (
        "between zero quat",
        lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=[(0, 0, 0, 0), (1, 0, 0, 0)]),
        "quat_wxyz[0] is (0, 0, 0, 0)",
    ),
    (
        "between one quat",
        lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=[(1, 0, 0, 0)]),
        "quat_wxyz has 1 quaternions for 2 poses",
    ),
    ("between quat int", lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=5), "quat_wxyz is 5"),
    (
        "between quat str",
        lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz="ab"),
        "quat_wxyz[0][0] is 'a'",
    ),
    (
        "between quat nan",
        lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=[(NAN, 0, 0, 0), (1, 0, 0, 0)]),
        "quat_wxyz[0][0] is nan",
    ),
    (
        "between quat tiny",
        lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=[(1e-320, 0, 0, 0), (1, 0, 0, 0)]),
        None,
    ),
    (
        "between quat huge",
        lambda: fc.RationalMotion.between((0, 0, 0), (1, 0, 0), quat_wxyz=[(HUGE, 1, 0, 0), (1, 0, 0, 0)]),
        None,
    ),
    (
        "between both quats",
        lambda: fc.RationalMotion.between(
            (0, 0, 0), (1, 0, 0), quat_wxyz=[(1, 0, 0, 0)] * 2, quat_xyzw=[(0, 0, 0, 1)] * 2
        ),
        "quat_xyzw= and quat_wxyz= are both given",
    ),
    ("between snap str", lambda: fc.RationalMotion.between(np.eye(4), np.eye(4), snap="x"), "snap is 'x'"),
    ("between snap inf", lambda: fc.RationalMotion.between(np.eye(4) * 1.0, np.eye(4) * 1.5, snap=INF), "snap is inf"),
    ("between snap negative", lambda: fc.RationalMotion.between(np.eye(4), np.eye(4), snap=-1), "snap is -1"),
    (
        "between singular snap 10",
        lambda: fc.RationalMotion.between(np.diag([0.0, 0, 0, 1]), np.eye(4), snap=10),
        "snap is 10",
    ),
    (
        "between mirrored",
        lambda: fc.RationalMotion.between(np.diag([-1.0, 1, 1, 1]), np.eye(4)),
        "pose0: the linear part is no rotation, it mi",
    ),
    ("sequence empty", lambda: fc.Sequence([]), "Sequence has no steps"),
    ("sequence none", lambda: fc.Sequence(None), "Sequence steps or durations are no lists ('N"),
    ("sequence int", lambda: fc.Sequence(5), "Sequence steps or durations are no lists ('i"),
    ("sequence str", lambda: fc.Sequence("abc"), "Sequence step 0 is 'a'"),
    ("sequence motion", lambda: fc.Sequence(slide()), "Sequence steps or durations are no lists ('T"),
    ("sequence durations", lambda: fc.Sequence([slide()], durations=[0]), "Sequence durations[0] is 0"),
    ("sequence durations nan", lambda: fc.Sequence([slide()], durations=[NAN]), "Sequence durations[0] is nan"),
    (
        "sequence durations int",
        lambda: fc.Sequence([slide()], durations=5),
        "Sequence steps or durations are no lists ('i",
    ),
    ("sequence durations str", lambda: fc.Sequence([slide()], durations="a"), "Sequence durations[0] is 'a'"),
    (
        "sequence durations huge",
        lambda: fc.first_contact(
            cube().moving(fc.Sequence([slide()], durations=["1e400"])), cube().translated((0, 0, 5))
        ),
        "Sequence durations[0] is 1",
    ),
    (
        "sequence durations tiny",
        lambda: fc.first_contact(
            cube().moving(fc.Sequence([slide()], durations=["1e-400"])), cube().translated((0, 0, 5))
        ),
        "Sequence durations[0] is 1/1",
    ),
    ("sequence nested", lambda: fc.Sequence([fc.Sequence([slide()])]), "Sequence step 0 is Sequence([Translation((0."),
    (
        "sequence 1e6 turns",
        lambda: fc.first_contact(
            cube().moving(fc.Sequence([turn(turns=10**12)])), cube().translated((9, 0, 0)), budget=1000
        ),
        None,
    ),
    ("traj none", lambda: fc.Trajectory(None, None), "Trajectory times is None"),
    ("traj one", lambda: fc.Trajectory([0], [np.eye(4)]), "Trajectory has 1 times"),
    ("traj descending", lambda: fc.Trajectory([1, 0], [np.eye(4)] * 2), "Trajectory times[1] does not lie after times"),
    ("traj nan time", lambda: fc.Trajectory([0, NAN], [np.eye(4)] * 2), "Trajectory times[1] is nan"),
    ("traj str times", lambda: fc.Trajectory("01", [np.eye(4)] * 2), None),
    ("traj poses str", lambda: fc.Trajectory([0, 1], "ab"), "Trajectory poses[0] is 'a'"),
    ("traj poses ints", lambda: fc.Trajectory([0, 1], [1, 2]), "Trajectory poses[0] is 1"),
    ("traj poses none", lambda: fc.Trajectory([0, 1], [None, None]), "Trajectory poses[0] is None"),
    (
        "traj poses shape",
        lambda: fc.Trajectory([0, 1], np.zeros((2, 3, 3))),
        "Trajectory poses[0] is array([[0., 0., 0.], ",
    ),
    (
        "traj poses zeros",
        lambda: fc.Trajectory([0, 1], np.zeros((2, 4, 4))),
        "Trajectory poses[0]: the last row is not (0,",
    ),
    ("traj poses nan", lambda: fc.Trajectory([0, 1], np.full((2, 4, 4), NAN)), "Trajectory poses[0][0][0] is nan"),
    ("traj poses inf", lambda: fc.Trajectory([0, 1], np.full((2, 4, 4), INF)), "Trajectory poses[0][0][0] is inf"),
    (
        "traj poses huge",
        lambda: fc.Trajectory([0, 1], np.full((2, 4, 4), 1e300)),
        "Trajectory poses[0]: the last row is not (0,",
    ),
    (
        "traj interpolation",
        lambda: fc.Trajectory([0, 1], [np.eye(4)] * 2, "cubic"),
        "Trajectory interpolation is 'cubic'",
    ),
    (
        "traj interpolation none",
        lambda: fc.Trajectory([0, 1], [np.eye(4)] * 2, None),
        "Trajectory interpolation is None",
    ),
    ("traj interpolation list", lambda: fc.Trajectory([0, 1], [np.eye(4)] * 2, []), "Trajectory interpolation is []"),
    (
        "traj quats short",
        lambda: fc.Trajectory([0, 1], [(0, 0, 0)] * 2, quat_wxyz=[(1, 0, 0, 0)]),
        "quat_wxyz has 1 quaternions for 2 poses",
    ),
    (
        "traj quat 3",
        lambda: fc.Trajectory([0, 1], [(0, 0, 0)] * 2, quat_wxyz=[(1, 0, 0)] * 2),
        "quat_wxyz[0] is (1, 0, 0)",
    ),
    ("traj tuple pose", lambda: fc.Trajectory([0, 1], [("a", "b"), (1, 2)]), "Trajectory poses[0] is ('a', 'b')"),
    ("traj many counts", lambda: fc.Trajectory([0, 1, 2], [np.eye(4)] * 2), "Trajectory has 3 times but 2 poses"),
    (
        "traj huge vector",
        lambda: fc.Trajectory([0, 1], [(0, 0, 0), (0, 0, "1e400")], quat_wxyz=[(1, 0, 0, 0)] * 2),
        "Trajectory poses[1][2] is '1e400'",
    ),
    (
        "traj tiny step",
        lambda: fc.first_contact(
            cube().moving(fc.Trajectory([0, "1e-400"], [(0, 0, 0), (0, 0, 6)], quat_wxyz=[(1, 0, 0, 0)] * 2)),
            cube().translated((0, 0, 5)),
        ),
        "Trajectory times[1] lies within 2^-150 of ti",
    ),
    ("threads sweep 1e30", verb("first_contact", pair, threads=10**30, engine="sweep"), "threads is 1"),
    ("engine x", verb("first_contact", pair, engine="x"), "engine 'x' is unknown"),
    ("engine none", verb("first_contact", pair, engine=None), "engine None is unknown"),
    (
        "engine lifted balls",
        verb("first_contact", balls, engine="lifted"),
        "engine 'lifted' searches trees of polyhedra",
    ),
    ("pairs none", lambda: fc.contact_pairs(None, None), "None is no body"),
    ("pairs balls", lambda: fc.contact_pairs(*balls()), "contact_pairs is for Polyhedron with Polyhed"),
    ("pairs span", lambda: fc.contact_pairs(*pair(), (0, "1e400")), "span end is '1e400'"),
    (
        "pairs 1e12 turns",
        lambda: fc.contact_pairs(cube().translated((3, 0, 0)).moving(turn(turns=10**12)), cube().translated((0, 3, 0))),
        "cube: Rotation((0.0, 0.0, 1.0), point=(0.0, ",
    ),
    ("condition none", lambda: fc.contact_condition(None, None), "contact_condition is for two ruled surfaces,"),
    ("condition cubes", lambda: fc.contact_condition(*pair()), "contact_condition is for two ruled surfaces,"),
    ("condition count", lambda: fc.contact_condition(*strips(), count="x"), "count is 'x'"),
    ("condition count neg", lambda: fc.contact_condition(*strips(), count=-1), "count is -1"),
    ("curve moving", lambda: fc.intersection_curve(*strips()), "intersection_curve is for two ruled surfaces"),
    ("curve none", lambda: fc.intersection_curve(None, 5), "None is no body"),
    ("curve cubes", lambda: fc.intersection_curve(cube(), cube()), "intersection_curve is for Polyhedron with Ru"),
    (
        "tiny polyhedron",
        lambda: str(fc.first_contact(P((np.array(TET) * 1e-300), TF).moving(slide()), ball().translated((0, 0, 5)))),
        None,
    ),
    (
        "tiny polyhedra",
        lambda: str(
            fc.first_contact(
                P((np.array(TET) * 1e-300), TF).moving(slide()), P((np.array(TET) * 1e-300), TF).translated((0, 0, 5))
            )
        ),
        None,
    ),
    (
        "tiny poly intervals",
        lambda: str(
            fc.contact_intervals(P((np.array(TET) * 1e-300), TF).moving(slide()), ball().translated((0, 0, 5)))
        ),
        None,
    ),
    (
        "tiny balls intervals",
        lambda: str(fc.contact_intervals(fc.sphere(1e-300).moving(slide()), ball().translated((0, 0, 5)))),
        "sphere radius is 1e-300",
    ),
    (
        "tiny ball pair",
        lambda: str(
            fc.first_contact(
                fc.sphere(1e-300).moving(slide((0, 0, 6e-300))), fc.sphere(1e-300).translated((0, 0, 5e-300))
            )
        ),
        "sphere radius is 1e-300",
    ),
    (
        "tiny shift",
        lambda: str(fc.first_contact(ball().moving(slide((0, 0, 1e-300))), ball().translated((0, 0, 5)))),
        None,
    ),
    (
        "tiny place",
        lambda: str(
            fc.first_contact(ball().translated((1e-300, 0, 0)).moving(slide()), ball().translated((0, 1e-300, 5)))
        ),
        None,
    ),
    ("csg empty", lambda: ball() & ball().translated((9, 0, 0)), "solid is empty: its conditions contradict ea"),
    ("csg self", lambda: ball() - ball(), "solid is empty: its conditions contradict ea"),
    ("contains str", lambda: ball().contains("x"), "points are 'x'"),
    ("contains none", lambda: ball().contains(None), "points have shape ()"),
    ("contains nan", lambda: ball().contains([(NAN, 0, 0)]), "points hold a value that is not finite"),
    ("contains 2d", lambda: ball().contains([(0, 0)]), "points have shape (1, 2)"),
    ("contains huge", lambda: ball().contains([(HUGE, 0, 0)]), "points are [(1"),
    ("to_mesh 0", lambda: ball().to_mesh(0), "to_mesh tolerance is 0"),
    ("to_mesh nan", lambda: ball().to_mesh(NAN), "to_mesh tolerance is nan"),
    ("to_mesh inf", lambda: ball().to_mesh(INF), "to_mesh tolerance is inf"),
    ("to_mesh str", lambda: ball().to_mesh("x"), "to_mesh tolerance is 'x'"),
    ("to_mesh 1e-300", lambda: ball().to_mesh(1e-300), "to_mesh tolerance is 1e-300"),
    ("to_mesh 1e-12", lambda: ball().to_mesh(1e-12), "to_mesh tolerance is 1e-12"),
    ("to_mesh tiny ball", lambda: fc.sphere(1e-300).to_mesh(1e-3), "sphere radius is 1e-300"),
    ("to_mesh half space", lambda: fc.half_space((0, 0, 1), 0).to_mesh(0.1), "solid: no bound is known"),
    ("quadric ragged", lambda: fc.quadric([[1]]), "quadric needs a symmetric 4x4 matrix"),
    ("quadric ints", lambda: fc.quadric([1, 2, 3, 4]), "quadric needs a symmetric 4x4 matrix"),
    (
        "quadric asym",
        lambda: fc.quadric([[1, 2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]]),
        "quadric matrix is not symmetric: entries [1]",
    ),
    (
        "quadric 1e-300",
        lambda: fc.first_contact(fc.quadric(np.diag([1e-300, 1e-300, 1e-300, -1])).moving(slide()), ball()),
        "quadric matrix has entries whose sizes diffe",
    ),
    (
        "quadric far",
        lambda: fc.first_contact(
            fc.quadric(np.diag([1e300, 1e300, 1e300, -1])).moving(slide()), ball().translated((0, 0, 3))
        ),
        "quadric matrix has entries whose sizes diffe",
    ),
    ("a scene that is no path", lambda: load_scene(5), "5 is no path"),
    ("a scene with a null character", lambda: load_scene("a\0b"), "a\0b: embedded null byte"),
    ("a page into nowhere", lambda: fc.first_contact(*pair()).show("/none/x.html"), "/none/x.html: no such file"),
    ("a page of no path", lambda: fc.first_contact(*pair()).show(5), "5: "),
    ("a page with a long name", lambda: fc.first_contact(*pair()).show("x" * 5000), "xxx"),
    ("doubled and solid", lambda: P(TET, TF * 2, solid=True, name="twice"), "twice: every face is listed an even"),
]
# What goes wrong with keywords of verbs, and the word that has to be in the line.
KEYWORDS = [
    *[{"tolerance": x} for x in (INF, NAN, 0, -1, "x", Fraction(1, HUGE), HUGE, None)],
    *[{"budget": x} for x in (10**30, -1, 1.5, "9", 10**5000)],
    *[{"span": x} for x in ((0, "1e400"), ("-1e400", 0), (0, NAN), (1, 0), "ab", 5, (0, 1, 2), (None, None), (-INF, 0),
                            (0, 1e300), ("a", "b"))],
]  # fmt: skip
ROWS += [
    (f"{name} of {bodies.__name__}, {short(keys)}", verb(name, bodies, **keys), next(iter(keys)))
    for name in ("first_contact", "contact_intervals")
    for bodies in (pair, balls, strips)
    for keys in KEYWORDS
]
# More turns than are searched, whatever the budget; those of polyhedra count as work of one.
ROWS += [
    (f"{name} of {body.__name__}, {kind} of {turns} turns", call, f"{body().name}: {kind}(")
    for name, kind in (("contact_intervals", "Rotation"), ("contact_intervals", "Screw"), ("first_contact", "Screw"))
    for body in (cube, ball)
    for turns in (MOST_TURNS + 1, 10**12, "1e30")
    for call in [
        lambda name=name, kind=kind, body=body, turns=turns: getattr(fc, name)(
            body().translated((3, 0, 0)).moving(getattr(fc, kind)((0, 0, 1), turns=turns)),
            body().translated((0, 3, 0)),
            budget=1000 if body is ball else None,
        )
    ]
]
# Numbers that no builder of solids takes, each for each number of each.
NUMBERS = (None, "abc", NAN, INF, "1e99999999", "1/0", [1, 2, 3, 4, 5], "7" * 5000, 10**5000)
LENGTHS = (0, -1, HUGE, 1e-300, "1e-400")
BUILDERS = [
    ("box size[0]", lambda x: fc.box((x, 1, 1)), True),
    ("sphere radius", fc.sphere, True),
    ("ellipsoid radii[1]", lambda x: fc.ellipsoid((1, x, 1)), True),
    ("cylinder ", lambda x: fc.cylinder(x, 1), True),
    ("cylinder height", lambda x: fc.cylinder(1, x), True),
    ("cone radius", lambda x: fc.cone(x, 1), True),
    ("cone height", lambda x: fc.cone(1, x), True),
    ("frustum height", lambda x: fc.frustum(1, 2, x), True),
    ("paraboloid radii", lambda x: fc.paraboloid(x, 1), True),
    ("paraboloid height", lambda x: fc.paraboloid((1, 2), x), True),
    ("hyperboloid radii[2]", lambda x: fc.hyperboloid((1, 1, x), 4), True),
    ("hyperboloid height", lambda x: fc.hyperboloid((1, 1, 1), x), True),
    ("half_space normal[0]", lambda x: fc.half_space((x, 0, 0), 1), False),
    ("half_space offset", lambda x: fc.half_space((0, 0, 1), x), False),
]
ROWS += [
    (f"{who} {short(x)}",
     lambda build=build, x=x: build(x), who)
    for who, build, is_length in BUILDERS
    for x in NUMBERS + (LENGTHS if is_length else ())
]  # fmt: skip
BOXES = ("ab", [(0, 0, 0)], [(0, 0, NAN), (1, 1, 1)], [(1, 1, 1), (0, 0, 0)], [(0, 0, 0), (HUGE, 1, 1)], 5)
ROWS += [
    (f"intersection_curve of {name}, {short(keys)}", lambda ask=ask, keys=keys: ask(**keys), next(iter(keys)))
    for name, ask in (
        ("strips", lambda **keys: fc.intersection_curve(*still(), **keys)),
        ("ball", lambda **keys: fc.intersection_curve(strip(), ball("1/2"), **keys)),
    )
    for keys in [{"tolerance": x} for x in (INF, NAN, 0, "x", Fraction(1, HUGE), HUGE)] + [{"box": x} for x in BOXES]
]
DIRECTRICES = {
    "none": (None, "strip: first"),
    "empty": ("", "strip: first"),
    "word": ("abc", "strip: first"),
    "2": ("(u,0)", "strip: first"),
    "4": ("(u,0,0,0)", "strip: first"),
    "unknown": ("(v,0,0)", "strip: first"),
    "call": ("(exp(u),0,0)", "strip: first"),
    "power": ("(u**1000000,0,0)", "strip: first"),
    "power tower": ("(u**9**9**9,0,0)", "strip: first"),
    "digits power": ("(9**9**9,0,0)", "strip: first"),
    "neg power": ("(0**-1,0,0)", "strip: first"),
    "div 0": ("(u/0,0,0)", "strip: first"),
    "div poly 0": ("(1/(u-u),0,0)", "strip: first"),
    "deep": ("(" * 3000 + "u" + ")" * 3000, "strip: first"),
    "deep minus": ("-" * 5000 + "u", "strip: first"),
    "long sum": ("+".join(["u"] * 20000), "strip: first"),
    "long tuple": ("(" + "u," * 20000 + ")", "strip: first"),
    "letters": ("(ü,0,0)", "strip: first"),
    "null": ("(u\x00,0,0)", "strip: first"),
    "nl": ("(u,\n0,0)", None),
    "huge digits": ("(" + "7" * 6000 + ",0,0)", "strip: first"),
    "digits 4000": ("(" + "7" * 4000 + "*u,0,0)", "strip: first"),
    "1e999": ("(1e999*u,0,0)", "strip: first"),
    "1e9999": ("(1e9999*u,0,0)", "strip: first"),
    "import": ("__import__('os').system('x')", "strip: first"),
    "lambda": ("lambda: u", "strip: first"),
    "attr": ("u.x", "strip: first"),
    "pole": ("(1/u,0,0)", "strip: first"),
    "big product": ("((u+1)**200*(u+2)**200*(u+3)**200,0,0)", "strip: first"),
    "T power": ("(u*T**199,u**200,0)", None),
    "xor": ("(u^2,0,0)", "strip: first"),
    "int": (5, "strip: first"),
    "bytes": (b"(u,0,0)", "strip: first"),
    "list": (["u", "0", "0"], "strip: first"),
    "bool": ("(True,0,0)", "strip: first"),
    "complex": ("(1j,0,0)", "strip: first"),
    "str in": ("('u',0,0)", "strip: first"),
    "underscore": ("(1_0,0,0)", "strip: first"),
    "hex": ("(0x10,0,0)", "strip: first"),
    "mixed": ("(u**150/(1+T**150),u,0)", None),
}
TRIMS = {
    "none": (None, "strip: trim"),
    "int": (5, "strip: trim"),
    "word": ("abc", "strip: trim"),
    "eq": ("u == s", "strip: trim"),
    "strict": ("u < s", "strip: trim"),
    "huge": ("u**999999 <= s", "strip: trim"),
    "tower": ("u**9**9**9<=1", "strip: trim"),
    "div": ("1/u <= s", "strip: trim"),
    "unknown": ("x <= 1", "strip: trim"),
    "list none": ([None], "strip: trim"),
    "long": (["u <= 1"] * 5000, None),
    "never": (["u <= -1"], "strip: trim"),
    "chain": (" <= ".join(["u"] * 3000), None),
    "deep": ("(" * 3000 + "u" + ")" * 3000 + "<=1", "strip: trim"),
    "const": ("1 <= 0", "strip: trim"),
    "and": ("u<=1 and s<=1", "strip: trim"),
}
G = [[(0, 0, 0), (0, 4, 0)], [(1, 0, 1), (1, 4, 2)], [(2, 0, 1), (2, 4, 2)], [(3, 0, 0), (3, 4, 0)]]
GRIDS = {
    "points none": (dict(points=None), "roof: "),
    "points str": (dict(points="ab"), "roof: "),
    "points int": (dict(points=5), "roof: "),
    "points flat": (dict(points=[1, 2, 3]), "roof: "),
    "points ragged": (dict(points=[[(0, 0, 0)], [(0, 0, 0), (1, 1, 1)]]), "roof: "),
    "points nan": (dict(points=[[(0, 0, NAN), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]]), "roof: "),
    "points huge": (dict(points=[[(0, 0, HUGE), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]]), "roof: "),
    "points same": (dict(points=[[(0, 0, 0)] * 2] * 2), "roof: "),
    "points 2d": (dict(points=[[(0, 0)] * 2] * 2), "roof: "),
    "points long": (dict(points=[[(i, 0, i % 7), (i, 1, 0)] for i in range(400)]), "roof: "),
    "knots str": (dict(points=G, knots="abc"), "roof: "),
    "knots short": (dict(points=G, knots=[0, 1]), "roof: "),
    "knots desc": (dict(points=G, knots=[0, 0, 0, 2, 1, 2, 2]), "roof: "),
    "knots nan": (dict(points=G, knots=[0, 0, 0, NAN, 2, 2, 2]), "roof: "),
    "knots same": (dict(points=G, knots=[0] * 7), "roof: "),
    "knots int": (dict(points=G, knots=5), "roof: "),
    "knots three": (dict(points=G, knots=[[0], [1], [2]]), "roof: "),
    "knots huge": (dict(points=G, knots=[0, 0, 0, 1, HUGE, HUGE, HUGE]), "roof: "),
    "knots tiny": (dict(points=G, knots=[0, 0, 0, "1e-400", 2, 2, 2]), None),
    "knots words": (dict(points=G, knots=list("abcdefg")), "roof: "),
    "knots none in": (dict(points=G, knots=[None] * 7), "roof: "),
    "weights str": (dict(points=G, weights="abcd"), "roof: "),
    "weights 0": (dict(points=G, weights=[[0, 1]] * 4), "roof: "),
    "weights nan": (dict(points=G, weights=[[NAN, 1]] * 4), "roof: "),
    "weights shape": (dict(points=G, weights=[[1, 1]]), "roof: "),
    "weights int": (dict(points=G, weights=5), "roof: "),
    "weights flat": (dict(points=G, weights=[1, 1, 1, 1]), "roof: "),
    "weights uneven": (dict(points=G, weights=[[1, 1e300]] * 4), "roof: "),
    "weights huge": (dict(points=G, weights=[[HUGE, 1]] * 4), "roof: "),
    "degree str": (dict(points=G, degree="x"), "roof: "),
    "degree neg": (dict(points=G, degree=-1), "roof: "),
    "degree 0": (dict(points=G, degree=0), "roof: "),
    "degree huge": (dict(points=G, degree=10**30), "roof: "),
    "degree float": (dict(points=G, degree=1.5), "roof: "),
    "degree list": (dict(points=G, degree=[1, 2, 3]), "roof: "),
    "degree pair huge": (dict(points=G, degree=(10**9, 1)), "roof: "),
    "degree pair str": (dict(points=G, degree=("a", 1)), "roof: "),
    "degree True": (dict(points=G, degree=True), "roof: "),
    "degree [x]": (dict(points=G, degree=(-5, -5)), "roof: "),
}
RANGES = {
    "str": ("ab", "strip: "),
    "one": ((0,), "strip: "),
    "rev": ((1, 0), "strip: "),
    "same": ((0, 0), "strip: "),
    "nan": ((0, NAN), "strip: "),
    "inf": ((0, INF), "strip: "),
    "int": (5, "strip: "),
    "huge": ((0, HUGE), "strip: "),
    "tiny": ((0, "1e-400"), None),
    "words": (("a", "b"), "strip: "),
    "endless": ((0, "1e99999999"), "strip: "),
}
NUMERATORS = {
    "none": (None, ""),
    "int": (5, ""),
    "empty": ([], ""),
    "str": ("abc", ""),
    "3x3": (np.zeros((3, 3)), None),
    "zeros": ([[0], [0], [0]], None),
    "nan": ([[NAN], [0], [0]], ""),
    "deep": ([[[[1]]], [0], [0]], ""),
    "long": ([[0] * 5000 + [1], [0], [0]], None),
    "huge": ([[HUGE, 1], [0], [0]], ""),
    "str num": ([["x"], [0], [0]], ""),
    "long T": ([[[0] * 300 + [1]], [0], [0]], None),
}
ROWS += [
    *[(f"directrix {k}", lambda x=x: fc.RuledSurface(x, "(u, 1, u)", name="strip"), f)
      for k, (x, f) in DIRECTRICES.items()],
    *[(f"trim {k}", lambda x=x: strip(trim=x), f) for k, (x, f) in TRIMS.items()],
    *[(f"NURBS {k}", lambda x=x: fc.RuledSurface.from_nurbs(name="roof", **x), f) for k, (x, f) in GRIDS.items()],
    *[(f"range {key} {k}", lambda key=key, x=x: strip(**{key: x}), f and f"{f}{key}")
      for key in ("u", "s") for k, (x, f) in RANGES.items()],
    *[(f"numerators {k}", lambda x=x: fc.RationalCurve(x), f) for k, (x, f) in NUMERATORS.items()],
]  # fmt: skip


# -- mechanisms, tools ----------------------------------------------------------------------------------------


def gate():
    post, bar = fc.box((1, 1, 1)), fc.box((1, 1, 1)).translated((3, 0, 0))
    joint = fc.Joint("hinge", "revolute", "post", "bar", limits=(0, 90))
    return fc.Mechanism({"post": post, "bar": bar}, [joint])


def swung():
    return gate().course([0, 1], {"hinge": [0, 1]})


def milled(tools, bodies):
    return list(fc.ToolPath("examples/pocket.nc", start=(0, 0, 80)).verdicts(tools, bodies))


MILL = [("flutes", "cutter", 6, 20)]
ROWS += [
    ("links in a list", lambda: fc.Mechanism([ball()], []), "links are [<CompositeQuadric"),
    ("skip of no link", lambda: fc.Mechanism({"a": ball()}, [], skip=[("a", "b")]), "skip[0]: no link 'b'"),
    ("chain to no link", lambda: gate().chain("roof"), "chain: no link 'roof'; the links are 'post', 'bar'"),
    ("against a number", lambda: swung().first_contacts(against=[5]), "5 is no body"),
    ("against a body", lambda: swung().first_contacts(against=ball()), "against is <CompositeQuadric"),
    ("velocities of lines", lambda: gate().course([0, 1], {"hinge": [0, 1]}, velocities={"hinge": [1, 1]}),
     'velocities are for interpolation="cubic"'),
    ("a sweep at its own value", lambda: gate().sweep("hinge", at={"hinge": 45}), "joint 'hinge' is driven"),
    ("a name that is a number", lambda: ball().named(5), "name is 5; give a text"),
    ("tool bodies in a list", lambda: milled(fc.Tool(MILL), [ball()]), "bodies are [<CompositeQuadric"),
    ("a number for a tool", lambda: milled(5, {"clamp": ball()}), "tools are 5; give an fc.Tool"),
]  # fmt: skip


def test_there_are_many_rows_and_no_two_of_one_name():
    names = [name for name, _, _ in ROWS]
    assert len(names) > 500 and len(set(names)) == len(names)


@pytest.mark.parametrize(("call", "says"), [row[1:] for row in ROWS], ids=[row[0] for row in ROWS])
def test_a_careless_call_ends_in_one_line_or_an_answer(call, says):
    before = resource.getrusage(resource.RUSAGE_SELF)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if says is None:
            str(call())
        else:
            with pytest.raises(fc.FirstContactError) as error:
                call()
            line = str(error.value)
            assert says in line and len(line.splitlines()) == 1 and len(line) <= 2000
    after = resource.getrusage(resource.RUSAGE_SELF)
    assert after.ru_utime - before.ru_utime < MOST_SECONDS and after.ru_maxrss - before.ru_maxrss < MOST_KILOBYTES


@pytest.mark.parametrize("power", [150, 900, 1020])
def test_a_slow_shift_of_solids_goes_on_as_far_as_doubles_do(power):
    falling = ball().translated((0, 0, 4)).moving(slide((0, 0, Fraction(-1, 2**power))))
    for exact in (False, True):
        hit = fc.first_contact(falling, ball(), (0, 3 * 2**power), exact=exact)
        assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(2.0 ** (power + 1))
        (one,) = fc.contact_intervals(falling, ball(), (0, 7 * 2**power), exact=exact)
        assert (one.start, one.end) == (pytest.approx(2.0 ** (power + 1)), pytest.approx(6 * 2.0**power))
    text = "span end lies beyond 2.1023" if power > 150 else "span end is .*; give a time below 2.150"
    with pytest.raises(fc.InputError, match=text):
        fc.first_contact(falling, ball(), (0, 2**1023))


def test_a_mesh_listed_twice_holds_no_interior_and_says_so():
    with pytest.warns(UserWarning, match="twice: every face is listed an even number of times"):
        twice = P(TET, TF * 2, name="twice")
    assert not twice.solid
    inner = "1/20", (0.2, 0.2, 0.2)
    small = fc.sphere(inner[0]).translated(inner[1])
    assert fc.first_contact(small.moving(fc.Translation((0, 0, 0.01))), twice).status is fc.Status.FREE
    assert fc.first_contact(small.moving(fc.Translation((0, 0, 0.01))), P(TET, TF)).initial == "containment"


def test_a_long_message_keeps_its_end():
    with pytest.raises(fc.InputError, match="stl: file name too long; check that the file can be read"):
        P.load("/tmp/" + "/".join(["x" * 200] * 30) + ".stl")
