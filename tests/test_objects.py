"""Bodies, motions and results as values: what they write of themselves, pickle, and show in a notebook."""

from __future__ import annotations

import base64
import itertools
import json
import pickle
import re
import struct
import subprocess
import sys
import types
import zlib
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import firstcontact as fc
from firstcontact.result import Absent, polynomial_text

CUBE = fc.examples.box((1, 1, 1))
SLIDE = fc.Translation(("7/3", 0, 0))
TURN = np.array([[0.6, -0.8, 0, 1], [0.8, 0.6, 0, 0], [0, 0, 1, 0.1], [0, 0, 0, 1]])  # a rotation up to rounding


def prism() -> fc.Polyhedron:
    """With a hole through it: polygons of two rings."""
    ring, hole = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (1, 2), (2, 2), (2, 1)]
    vertices = [(x, y, z) for z in (0, "1/3") for x, y in (*ring, *hole)]
    rings = [[*range(4), 0], [*range(4, 8), 4]]
    sides = [[a, b, b + 8, a + 8] for own in rings for a, b in itertools.pairwise(own)]
    return fc.Polyhedron(vertices, [[[3, 2, 1, 0], [7, 6, 5, 4]], [[8, 9, 10, 11], [12, 13, 14, 15]], *sides])


@cache
def bodies() -> dict[str, object]:
    slab, hole = fc.box((8, 8, "1/3")).named("slab"), fc.cylinder(2, 4).named("hole")
    roof = [[(0, 0, 0), (0, 4, 0)], [(1, 0, 1), (1, 4, 2)], [(2, 0, 1), (2, 4, 2)], [(3, 0, 0), (3, 4, 0)]]
    saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", name="saddle")
    cone = fc.RuledSurface("(0, 0, 0)", "((1-u**2)/(1+u**2), 2*u/(1+u**2), 1)", u=None, name="cone")
    return {
        "triangles": CUBE,
        "fractions": fc.Polyhedron([["1/3", 0, 0], [Fraction(1, 7), 1, 0], [0, 0, 0.1]], [[0, 1, 2]], name="leaf"),
        "turned mesh": CUBE.rotated((1, 2, 3), degrees=7).named("turned"),
        "polygons": prism().named("prism"),
        "turned polygons": prism().rotated((0, 1, 1), degrees=33),
        "edges": fc.Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [], edges=[[1, 0], [1, 2]]),
        "points": fc.Polyhedron([[0, 0, 0], [-0.0, 2, 0.1]], []),
        "edges first": fc.Polyhedron([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], edges=[[2, 1]], name="flag"),
        "surface": fc.Polyhedron(CUBE.vertices, CUBE.triangles, solid=False),
        "box": fc.box((1, "1/3", 0.1)),
        "sphere": fc.sphere(radius=Fraction(2, 7), name="ball"),
        "ellipsoid": fc.ellipsoid(np.array([1.0, 2.0, 3.5])),
        "cylinder": fc.cylinder(radii=(1, 2), height=3),
        "elliptic by radius": fc.cylinder((2, 1), "1/3").translated((1, 0, 0)),
        "round by radii": fc.cylinder(radii=2, height=5),
        "bored by an ellipse": fc.box((9, 9, 2)) - fc.cylinder((1, 2), 3),
        "cone": fc.cone(1, 2).translated((0.1, "1/3", 0)),
        "frustum": fc.frustum(1, "1/2", 2).rotated((1, 1, 0), degrees=20),
        "paraboloid": fc.paraboloid((1, 2), 3),
        "paraboloid of one radius": fc.paraboloid(2, 3),
        "hyperboloid by default": fc.hyperboloid((1, 2, 3), 2),
        "hyperboloid": fc.hyperboloid((1, 1, 2), 3, sheets=2),
        "half space": fc.half_space((1, 2, 2), "1/9"),
        "quadric": fc.quadric([[1, 0, 0, 0], [0, 0, 0, "-1/2"], [0, 0, 1, 0], [0, "-1/2", 0, 0]]),
        "stretched": fc.sphere(1).transformed([[2, 1, 0, 0], [0, -1, 0, 0], [0, 0, "1/3", 5], [0, 0, 0, 1]]),
        "chain": (slab - hole - hole.translated((3, 0, 0)) - hole.translated((0, 3, 0)).named("slot")).named("plate"),
        "tree": ((slab | hole) - (fc.sphere(1) & fc.half_space((0, 0, 1), 0)).named("cap") & fc.box((6, 6, 6))),
        "same names": (slab.named("x") | slab.named("x").translated((1, 1, 1))) - hole.named("part1"),
        "odd names": slab.named("a b") - hole.named("and") - fc.sphere("1/2").named(""),
        "inner name": ((slab - hole).named("inner").rotated((0, 0, 1), degrees=45) | fc.sphere(3)).named("outer"),
        "ruled": saddle,
        "turned ruled": saddle.rotated((1, 0, 1), degrees=11),
        "whole line": cone,
        "whole rulings": fc.RuledSurface("(u, u**2, 0)", "(u, 1, 1/3 + u)", u=("-1/3", 2), s=None),
        "trimmed": fc.RuledSurface("(u, 0, 0)", "(u, 1, u)", trim=["u*s <= 1/3", "0 <= s + u**2 <= 1"]),
        "deforming": fc.RuledSurface("(u, 0, T)", "(u, 1 + T/3, u + T**2)", s=(0, "3/2"), name="wing"),
        "strip": fc.RuledSurface.from_nurbs(roof, knots=[0, 0, 0, 1, 2, 2, 2], name="roof"),
        "weighted": fc.RuledSurface.from_nurbs(roof, [0, 0, 0, 0, 1, 1, 1, 1], [[1, 1], [2, 1], [1, 3], [1, 1]]),
    }


@cache
def motions() -> dict[str, object]:
    turned = [(0, 0, 0), (1, 0, 0), (1, "1/3", 0)], [(1, 0, 0, 0), (1, 0, 0, 1), (1, 0, "1/7", 1)]
    steps = [SLIDE, fc.Rotation((0, 0, 1), degrees=45), fc.Screw((0, 1, 0), turns=2, advance=1)]
    return {
        "translation": fc.Translation((0.1, "1/3", 10**20)),
        "degrees": fc.Rotation((1, 2, 3), point=("1/3", 0, 0.7), degrees=100),
        "turns": fc.Rotation((0, 0, 1), turns="-1/7"),
        "radians": fc.Rotation((0, 0, 1), radians=2),
        "screw": fc.Screw((1, 1, 0), (0, 0, "1/9"), radians=0.3, advance="1/7"),
        "rational": fc.RationalMotion([np.eye(4), np.diag([0, 0, 0, 0.25])]),
        "between": fc.RationalMotion.between(np.eye(4), TURN),
        "sequence": fc.Sequence(steps, durations=[1, "1/3", 2]),
        "long": fc.Sequence([fc.Translation((k, 0, 0)) for k in range(50)]),
        "trajectory": fc.Trajectory([0, "1/3", 2], turned[0], quat_wxyz=turned[1]),
        "screws": fc.Trajectory([0, 1], [np.eye(4), TURN], interpolation="screw"),
    }


def through_json(x: object) -> object:
    return fc.from_dict(json.loads(x.to_json()))


WAYS = {"pickle": lambda x: pickle.loads(pickle.dumps(x)), "json": through_json,
        "class": lambda x: type(x).from_dict(x.to_dict()),
        "text": lambda x: type(x).from_json(x.to_json())}  # fmt: skip


@pytest.mark.share(12)
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", [*bodies(), *motions()])
def test_what_went_out_comes_back_equal(name, way):
    x = {**bodies(), **motions()}[name]
    again = WAYS[way](x)
    assert type(again) is type(x) and again is not x and again == x and hash(again) == hash(x)
    assert again.to_dict() == x.to_dict() and repr(again) == repr(x)
    assert len(repr(x)) < 250


@pytest.mark.share(4)
@pytest.mark.parametrize("name", bodies())
def test_bodies_that_come_back_are_where_they_were(name):
    """Looked at independently of equality: boxes, elements by name, exact vertices, points in and out."""
    x, again = bodies()[name], through_json(bodies()[name])
    assert again.name == x.name
    if isinstance(x, fc.Polyhedron):
        assert [again.exact_vertex(i) for i in range(len(again.vertices))] == [
            x.exact_vertex(i) for i in range(len(x.vertices))]  # fmt: skip
        assert again.edges.tolist() == x.edges.tolist() and again.n_faces == x.n_faces and again.solid == x.solid
    elif isinstance(x, fc.CompositeQuadric):
        for kind in ("faces", "edges", "vertices"):
            assert [f.name for f in getattr(again, kind)] == [f.name for f in getattr(x, kind)]
        points = np.random.default_rng(1).uniform(-4, 4, (300, 3))
        assert np.array_equal(again.contains(points), x.contains(points)) and again.bounded == x.bounded
    else:
        assert np.allclose(again.bounds(), x.bounds()) or not x.bounded
        assert [p.joined for p in again.pieces] == [p.joined for p in x.pieces]


@pytest.mark.parametrize("name", motions())
def test_motions_that_come_back_go_the_same_way(name):
    x, again = motions()[name], through_json(motions()[name])
    first, last = x.span
    for t in np.linspace(first, last, 7):
        assert np.array_equal(again(t), x(t))
    assert again.span == x.span and getattr(again, "correction", 0.0) == getattr(x, "correction", 0.0)
    moving = CUBE.moving(x)
    back = through_json(moving)
    assert back == moving == CUBE.moving(again) and hash(back) == hash(moving) and back.motion == x
    assert back != CUBE.moving(fc.Translation((1, 2, 3))) and back != CUBE and back != CUBE.named("b").moving(x)


def test_no_two_of_them_are_equal():
    every = [*bodies().values(), *motions().values()]
    assert len(set(every)) == len(every)
    for k, x in enumerate(every):
        assert [y for y in every if y == x] == [x] and every[k] is x
        assert x != "x" and x is not None


exact = st.fractions(max_denominator=10**6, min_value=-1000, max_value=1000)
doubles = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6)
number = st.one_of(exact, doubles, st.integers(-(2**70), 2**70))


@pytest.mark.thorough
@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.tuples(number, number, number), min_size=3, max_size=6), st.tuples(number, number, number))
def test_numbers_of_any_kind_come_back_exactly(vertices, vector):
    body = fc.Polyhedron(vertices, [], edges=[[0, 1]]).moving(fc.Translation(vector))
    again = through_json(body)
    assert again == body
    for i, vertex in enumerate(vertices):
        found = again.body.exact_vertex(i)
        assert [Fraction(int(x.p), int(x.q)) for x in found] == [Fraction(x) for x in vertex]


def test_equal_bodies_are_equal_however_they_were_made():
    assert fc.box((1, "1/2", 2)) == fc.box([1.0, Fraction(1, 2), np.float64(2)]) != fc.box((1, "1/2", 3))
    assert fc.box((1, 1, 1)) != fc.box((1, 1, 1), name="b") == fc.box((1, 1, 1)).named("b")
    there = CUBE.translated((1, 0, 0))
    assert there == fc.Polyhedron(CUBE.vertices + [1, 0, 0], CUBE.triangles, name="box") != CUBE
    assert CUBE.rotated((0, 0, 1), degrees=10).rotated((0, 0, 1), degrees=-10) == CUBE
    quarter, up = fc.Rotation((0, 0, 1), degrees=90), (0, 0, 1)
    assert quarter == fc.Rotation(up, turns="1/4") != fc.Rotation(up, radians=1)
    assert hash(CUBE) == hash(CUBE.named("other")) or CUBE != CUBE.named("other")


@pytest.mark.parametrize("row", [(1, 1, 0, 0), (3, 0, 0, 0), (-1, 0, 0, 0), (1, 0, 0, "1/3")])
def test_meshes_are_equal_however_they_were_made(row):
    """Found from outside: a sheared mesh was another one than that given by its vertices, and than itself read back."""
    made = CUBE.transformed([row, (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)])
    first = [sum(Fraction(c) * Fraction(x) for c, x in zip(row, (*v, 1), strict=True)) for v in CUBE.vertices]
    given = fc.Polyhedron([(x, *v[1:]) for x, v in zip(first, CUBE.vertices.tolist(), strict=True)], made.triangles)
    plain = fc.Polyhedron([made.exact_vertex(i) for i in range(len(made.vertices))], made.triangles)
    assert given == plain and hash(given) == hash(plain)
    again = fc.from_dict(json.loads(made.to_json()))
    assert again == made and hash(again) == hash(made)


def test_a_piece_of_a_strip_is_a_body_of_its_own():
    """The border that it shared is one of its own now."""
    piece = bodies()["strip"].pieces[0]
    assert piece.joined == {"u1"} and through_json(piece).joined == frozenset()


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"shape": "box", "size": [1, 1, 1], "sise": 2}, "unknown key 'sise', perhaps 'size'"),
        ({"shape": "prism"}, "'prism'.*use one of.*'cylinder'"),
        ({"type": "hover"}, "'hover'.*use one of.*'screw'"),
        ({"shape": "box", "size": [1, 1, 1], "schema": 2}, "schema 2 is unknown"),
        ({"size": [1, 1, 1]}, "no kind among the keys size"),
        ({"shape": "sphere", "radius": 1, "motion": {"type": "screw", "axis": [0, 0, 0], "turns": 1}}, "motion.*axis"),
        ({"shape": "csg", "expression": "a - b", "part": {"a": {"shape": "box", "size": [1, 1, 0]}}}, "part.a.*size"),
        ({"shape": "ruled", "first": "(u, 0, 0)", "second": "(u, 1, u)", "joined": ["u0"]}, "joined.*u0"),
        ({"shape": "ruled", "pieces": [{"first": "(u, 0, 0)"}]}, r"pieces\[0\].*second is missing"),
        ({"shape": "ruled", "pieces": [], "u": [0, 1]}, "u does not go with pieces"),
        ({"status": "FREE", "a": "a", "b": "b", "span": [0, 1], "tme": 3}, "unknown key 'tme', perhaps 'time'"),
        ({"status": "MAYBE", "a": "a", "b": "b", "span": [0, 1]}, "status"),
        ({"status": "CONTACT", "a": "a", "b": "b", "span": [0, 1], "time_exact": "root of y in [0, 1]"}, "root of y"),
        ("box", "'box' is no dictionary"),
    ],
)  # fmt: skip
def test_what_is_not_known_is_named(data, told):
    with pytest.raises(fc.InputError, match=told):
        fc.from_dict(data)


def test_the_class_that_reads_says_what_it_got():
    with pytest.raises(fc.InputError, match="is a CompositeQuadric, no Polyhedron"):
        fc.Polyhedron.from_dict(fc.sphere(1).to_dict())
    with pytest.raises(fc.InputError, match="no JSON"):
        fc.Polyhedron.from_json("{")


def test_tables_of_bodies_are_those_of_scenes(tmp_path):
    """What a body writes stands in a scene as it is, and makes the same body there."""
    from firstcontact.scene.load import load_scene

    def toml(value: object) -> str:
        if isinstance(value, dict):
            return "{" + ", ".join(f"{json.dumps(key)} = {toml(x)}" for key, x in value.items()) + "}"
        return "[" + ", ".join(map(toml, value)) + "]" if isinstance(value, list) else json.dumps(value)

    chosen = {key: bodies()[key] for key in ("polygons", "turned mesh", "chain", "tree", "trimmed", "strip")}
    moving = {key: body.named(f"the {key}").moving(motions()["sequence"]) for key, body in chosen.items()}
    tables = {key: {k: x for k, x in body.to_dict().items() if k != "schema"} for key, body in moving.items()}
    lines = [f"[body.{json.dumps(key)}]\n" + "\n".join(f"{k} = {toml(x)}" for k, x in table.items())
             for key, table in tables.items()]  # fmt: skip
    path = tmp_path / "scene.toml"
    path.write_text("\n".join(lines))
    assert load_scene(path).bodies == moving


# -- results ------------------------------------------------------------------------------------------------


@cache
def results() -> dict[str, object]:
    target = CUBE.translated((3, 0.25, 0.125)).named("target")
    swing = fc.Rotation((0, 0, 1), point=(0, 4, 0), turns="1/3")
    slab, plate, ball = bodies()["box"], bodies()["chain"], fc.sphere("3/2").named("ball").translated((1, 0, 6))
    plain = fc.box((8, 8, 2)) - fc.cylinder(2, 4).named("hole")
    saddle, plane = bodies()["ruled"], fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
    round_cone, tilted = bodies()["whole line"], fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 2/3)", u=(-1, 1))
    falls = fc.Translation((0, 0, -6))
    return {
        "contact": fc.first_contact(CUBE.moving(SLIDE), target, exact=True),
        "certified": fc.first_contact(CUBE.moving(SLIDE), target),
        "turn": fc.first_contact(CUBE.moving(swing), target, exact=True),
        "free": fc.first_contact(CUBE.moving(fc.Translation((1, 0, 0))), target),
        "endless": fc.first_contact(CUBE.moving(fc.Translation((-1, 0, 0))), target, span=(0, float("inf"))),
        "start": fc.first_contact(CUBE.moving(SLIDE), CUBE.translated((0.5, 0, 0))),
        "budget": fc.first_contact(CUBE.moving(SLIDE), target, budget=0),
        "model": fc.first_contact(ball.moving(falls), plain, exact=True),
        "subproblems": fc.first_contact(ball.moving(falls), plain, method="algebraic"),
        "flat": fc.first_contact(slab.moving(fc.Translation((0, 0, 4))), slab.translated((0.5, 0, 3))),
        "intervals": fc.contact_intervals(ball.moving(falls), plate, exact=True),
        "turning intervals": fc.contact_intervals(CUBE.moving(swing), target, exact=True),
        "pairs": fc.contact_pairs(CUBE.moving(fc.Translation((7, 0, 0))), target),
        "curve": fc.intersection_curve(saddle, plane),
        "certified curve": fc.intersection_curve(saddle, plane, method="certified"),
        "loops": fc.intersection_curve(round_cone, tilted),
    }  # fmt: skip


def test_all_kinds_of_answers_are_there():
    assert {x.status.name for x in results().values() if hasattr(x, "status")} == {status.name for status in fc.Status}
    assert results()["subproblems"].subproblems and results()["flat"].contact_set == "patch"
    assert isinstance(results()["model"].time_exact, fc.AlgebraicNumber)
    assert isinstance(results()["turn"].time_exact, fc.ExactAngle)
    assert len(results()["pairs"]) > 1 and results()["certified curve"].branches


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", results())
def test_results_come_back_equal(name, way):
    x = results()[name]
    again = WAYS[way](x)
    assert again == x and hash(again) == hash(x) and again is not x
    assert json.loads(again.to_json()) == json.loads(x.to_json())
    assert str(again) == str(x) and repr(again) == repr(x) and len(repr(x)) < 250
    for key in ("time_exact", "others", "span", "status", "free_until", "intervals", "delta", "pairs"):
        assert getattr(again, key, None) == getattr(x, key, None)
    assert getattr(again, "contact_set", None) == getattr(x, "contact_set", None)


def test_results_are_equal_where_they_say_the_same():
    target = CUBE.translated((3, 0.25, 0.125)).named("target")
    again = fc.first_contact(CUBE.moving(SLIDE), target)
    assert again == results()["certified"] and again.stats.seconds != results()["certified"].stats.seconds
    assert again != results()["contact"] and again != results()["free"] and again != "hit"
    assert again != fc.first_contact(CUBE.moving(SLIDE), target.named("other"))


def test_tables_of_answers_are_values():
    target = CUBE.translated((3, 0, 0))
    for ask in (fc.first_contacts, fc.many_contact_intervals):
        tables = [ask((CUBE.moving(fc.Translations(way)), target)) for way in ([(4, 0, 0)], [(4, 0, 0)], [(5, 0, 0)])]
        assert tables[0] == tables[1] and tables[0] != tables[2]
    longer = fc.examples.box((2, 1, 1)).translated((3.5, 0, 0))  # as far away, and longer
    way = CUBE.moving(fc.Translations([(8, 0, 0)]))
    assert fc.many_contact_intervals((way, target)) != fc.many_contact_intervals((way, longer))
    with pytest.raises(fc.InputError, match=r"vectors are complex; \(n, 3\) doubles are wanted"):
        fc.Translations(np.array([[4 + 1j, 0, 0]]))


def test_tables_of_answers_pickle_as_columns():
    many = fc.Translations([(4, 0, 0), (0, 4, 0), (8, 0, 0)])
    question = CUBE.moving(many), CUBE.translated((3, 0, 0))
    for table in (fc.first_contacts(question), fc.many_contact_intervals(question)):
        again = pickle.loads(pickle.dumps(table))
        assert type(again) is type(table) and again.to_numpy().tobytes() == table.to_numpy().tobytes()
        assert again == table and hash(again) == hash(table) and table != [table]
        assert again.counts == table.counts and table[0].status is fc.Status.CONTACT
        with pytest.raises(fc.InputError, match="ask question 1 again"):
            again[1]
    assert np.array_equal(again.intervals, table.intervals)


MANY = {
    "translations": lambda x: fc.Translations([(x, 0, 0), (0, 2, 0)]),
    "rotations": lambda x: fc.Rotations((0, 0, 1), (x, 0, 0), degrees=[30, 60]),
    "poses": lambda x: fc.Poses([[np.eye(4), np.diag([1.0, x, x, 1.0])]]),
}


@pytest.mark.parametrize("kind", MANY)
def test_many_motions_are_equal_where_all_are(kind):
    made, same, other = MANY[kind](1.0), MANY[kind](1.0), MANY[kind](-1.0)
    assert made == same == pickle.loads(pickle.dumps(made)) != other and hash(made) == hash(same)
    assert made[:1] != made or len(made) == 1
    assert made != made[0] and made != "x"


def test_pickles_of_results_leave_the_bodies_out():
    lid = fc.examples.box((1, 1, 1)).named("lid")
    mesh = fc.Polyhedron(np.random.default_rng(0).normal(size=(3000, 3)) + 50, np.arange(3000).reshape(-1, 3))
    hit = fc.first_contact(lid.moving(fc.RationalMotion.between(np.eye(4), TURN)), mesh)
    small, large = pickle.dumps(hit), pickle.dumps(hit.with_bodies())
    assert len(small) < 2000 < 50000 < len(large)
    light, full = pickle.loads(small), pickle.loads(large)
    assert light == full == hit and str(light) == str(hit)
    assert full.b == mesh and full.a.body == lid and light.a == Absent("lid", hit.a.motion.correction)
    with pytest.raises(fc.InputError, match="with_bodies"):
        light.show("page.html")
    assert "<img" not in light._repr_html_() and "<img" in full._repr_html_()
    assert pickle.loads(pickle.dumps(full)).b == mesh  # asked for once, kept on


# -- text ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("coefficients", "text"),
    [((-1, 0, 2), "2 x^2 - 1"), ((0, 1, -1), "-x^2 + x"), ((0, -1), "-x"), ((3,), "3"), ((), "0"),
     ((-2, -10, 0, 1), "x^3 - 10 x - 2")],
)  # fmt: skip
def test_polynomials_are_written_as_people_do(coefficients, text):
    assert polynomial_text(coefficients) == text


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.integers(-(10**30), 10**30), min_size=2, max_size=9).filter(lambda c: c[-1] != 0), exact, exact)
def test_written_roots_are_read_again(coefficients, lo, hi):
    from firstcontact.scene.answers import _exact

    number = fc.AlgebraicNumber(tuple(coefficients), lo, hi)
    assert _exact(number.written()) == number
    angle = fc.ExactAngle(number, Fraction(1, 3), 0.5)
    assert _exact(angle.written()) == (number, Fraction(1, 3))


def test_long_numbers_are_shortened_in_text_and_never_in_json():
    long = fc.AlgebraicNumber((-(10**90), *range(1, 30)), Fraction(10**40, 3 * 10**39 + 1), Fraction(4))
    assert len(str(long)) < 250 and "degree 29" in str(long) and "91 digits" in str(long)
    assert str(10**90) in long.written() and "29 x^29" in long.written()
    interval = fc.ContactInterval(1.0, 2.0, (1.0, 1.0), (2.0, 2.0), long, Fraction(10**60 + 1, 10**60))
    assert len(str(interval)) < 600 and interval.to_dict()["start_exact"] == long.written()


def test_exact_times_stand_in_the_text():
    assert str(results()["contact"]).endswith("\n  exactly 6/7")
    assert "exactly" not in str(results()["certified"])
    assert str(results()["turn"]).splitlines()[2].startswith("  exactly angle with cosine ")


# -- meshes of trimesh, help, start-up -------------------------------------------------------------------------


def test_meshes_of_trimesh_are_bodies():
    trimesh = pytest.importorskip("trimesh")
    mesh, target = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((1, 1, 1))
    target.apply_translation((3, 0.25, 0.125))
    moving = fc.Moving(mesh, fc.Translation((4, 0, 0)))
    assert fc.first_contact(moving, target).time == 0.5
    assert fc.first_contact(mesh, target).status is fc.Status.FREE
    assert fc.contact_intervals(moving, target)[0].start == 0.5
    assert len(fc.contact_pairs(moving, target)) > 0
    slope = fc.RuledSurface("(u, -1, 1/4)", "(u, 1, 1/4)", u=(-2, 2))
    assert len(fc.intersection_curve(slope, mesh).branches) == len(fc.intersection_curve(mesh, slope).branches) > 0
    with pytest.raises(fc.UnsupportedPair, match="is no body"):
        fc.first_contact(3, mesh)


def test_the_help_names_every_argument_and_kind():
    text = fc.first_contact.__doc__
    for argument in ("a, b", "span", "exact", "method", "engine", "tolerance", "budget", "progress", "threads"):
        assert re.search(rf"^    {argument}\b.*:", text, re.MULTILINE), argument
    for kind in ("Polyhedron", "CompositeQuadric", "RuledSurface", "trimesh", "Translation", "Rotation", "Screw",
                 "RationalMotion", "Sequence", "Trajectory"):  # fmt: skip
        assert kind in text, kind
    for default in ("1e-12", '"auto"', "False", "None"):
        assert default in text, default


def test_nothing_heavy_is_loaded_before_it_is_needed():
    script = "import sys, firstcontact; print([m for m in ('numpy', 'flint', 'pydantic', 'numba') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


# -- notebooks ----------------------------------------------------------------------------------------------


def pixels(page: str) -> np.ndarray:
    """The picture in a cell, decoded by hand: (height, width, 4)."""
    (data,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    png, at, parts = base64.b64decode(data), 8, {}
    while at < len(png):
        (size,) = struct.unpack(">I", png[at : at + 4])
        kind, body = png[at + 4 : at + 8], png[at + 8 : at + 8 + size]
        assert struct.unpack(">I", png[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + body)
        parts[kind] = body
        at += 12 + size
    width, height = struct.unpack(">2I", parts[b"IHDR"][:8])
    rows = np.frombuffer(zlib.decompress(parts[b"IDAT"]), np.uint8).reshape(height, 1 + 4 * width)
    return rows[:, 1:].reshape(height, width, 4)


@pytest.mark.share(5)
@pytest.mark.parametrize("name", ["contact", "free", "endless", "model", "intervals", "curve"])
def test_cells_show_both_bodies_and_the_verdict(name):
    page = results()[name]._repr_html_()
    seen = pixels(page).astype(int)
    solid = seen[seen[..., 3] > 200]
    blue, sand = (solid[:, 2] > solid[:, 0] + 30).sum(), (solid[:, 0] > solid[:, 2] + 30).sum()
    assert min(blue, sand) > 40 and (seen[..., 3] == 0).mean() > 0.1
    red = ((solid[:, 0] > 180) & (solid[:, 1] < 70)).sum()
    assert (red > 10) == (getattr(results()[name], "point", None) is not None)
    assert str(results()[name]).splitlines()[0].split(": ")[1][:4] in page and len(page) < 100_000


def test_cells_without_a_picture_tell_why(monkeypatch):
    def refuse(pair):
        raise fc.InputError("cannot draw <b>: both bodies are unbounded")

    plane, other = fc.half_space((0, 0, 1), 0).named("<b>"), fc.examples.box((1, 1, 1))
    hit = fc.first_contact(other.moving(fc.Translation((0, 0, -4))), plane)
    assert "<img" in hit._repr_html_() and "<b>" not in hit._repr_html_()
    monkeypatch.setattr("firstcontact.view.html.picture", refuse)
    told = hit._repr_html_()
    assert "<img" not in told and "&lt;b&gt;: INITIAL" in told and "no picture: cannot draw &lt;b&gt;: both" in told
    assert results()["pairs"]._repr_html_().startswith("<pre>")


def test_pages_are_shown_within_notebooks(monkeypatch, tmp_path):
    shells = iter([types.SimpleNamespace(kernel=object()), types.SimpleNamespace(kernel=object()), None])
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: next(shells)))
    monkeypatch.setattr("webbrowser.open", lambda url: None)
    frame = results()["contact"].show()._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and "&lt;html" in frame and not re.search(r'src="(?!data:)', frame)
    assert results()["curve"].show()._repr_html_().startswith("<iframe")
    assert results()["contact"].show().suffix == ".html"  # IPython without a kernel: a terminal
    assert results()["contact"].show(tmp_path / "page.html") == tmp_path / "page.html"
