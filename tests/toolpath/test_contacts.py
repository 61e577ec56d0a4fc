"""Where tools meet boxes, by closed formulas; and what hulls tell, beside the exact solids."""

import math
from fractions import Fraction

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from firstcontact.kernels.workspace import workspace
from firstcontact.search.trees.frame import tree_of
from firstcontact.toolpath.check import Setup
from firstcontact.toolpath.moves import StraightMove, Swing
from firstcontact.toolpath.rules import Allowed
from firstcontact.toolpath.walk import APART, INSIDE, OPEN, told_of_rows

MILL = fc.Tool([("flutes", "cutter", 6, 20), ("shank", "holder", 4, 20), ("collet", "holder", (10, 30), 30)])


def post(corner, size=(10, 10, 30), mesh=True):
    """A box with its lowest corner there."""
    middle = [x + s / 2 for x, s in zip(corner, size, strict=True)]
    if mesh:
        made = fc.examples.box(size)
        return fc.Polyhedron(made.vertices + middle, made.triangles)
    return fc.box(size).translated(middle)


def found_in(tmp_path, text, bodies, start=(0, 0, 0), tool=MILL, name="job.nc", **given):
    """The findings of the last block."""
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    return list(fc.ToolPath(file, start=start).verdicts(tool, bodies, workers=1, **given))[-1]


def only(verdict, part="flutes"):
    (finding,) = [x for x in verdict.findings if x.part == part]
    assert finding.lo <= finding.fraction <= finding.hi and finding.hi - finding.lo < 1e-11
    return finding


BOTH = pytest.mark.parametrize("mesh", [True, False], ids=["mesh", "solid"])


@BOTH
def test_straight_into_an_upright_edge(tmp_path, mesh):
    finding = only(found_in(tmp_path, "G1 X40", {"post": post((20, 1.8, -5), mesh=mesh)}))
    assert finding.fraction == pytest.approx((20 - math.sqrt(9 - 1.8**2)) / 40, abs=1e-13)
    assert finding.point[:2] == pytest.approx((20, 1.8)) and finding.tip == pytest.approx((17.6, 0, 0))


@BOTH
def test_the_holder_meets_what_the_cutter_passes(tmp_path, mesh):
    """The collet, 10 wide at height 40 and 30 at 70: at the height 55 of the post's top its radius is 10."""
    finding = only(found_in(tmp_path, "G0 X40", {"post": post((20, 8, -5), (10, 10, 60), mesh)}), "collet")
    assert (finding.kind, finding.move) == ("holder", "rapid")
    assert finding.fraction == pytest.approx((20 - math.sqrt(10**2 - 8**2)) / 40, abs=1e-13)
    assert finding.point == pytest.approx((20, 8, 55))


@BOTH
@pytest.mark.parametrize("rest", ["", " Z-3"], ids=["circle", "helix"])
def test_along_an_arc_into_an_upright_edge(tmp_path, mesh, rest):
    """About the origin at the radius 25, to the corner (-8, 26): 3 away from it."""
    corner, radius = (-8.0, 26.0), 25.0
    body = {"post": post((-18, 26, -9), mesh=mesh)}  # its corner towards the arc is (-8, 26)
    finding = only(found_in(tmp_path, f"G3 X-25 Y0 I-25{rest}", body, start=(25, 0, 0)))
    far = math.hypot(*corner)
    angle = math.atan2(corner[1], corner[0]) - math.acos((radius**2 + far**2 - 9) / (2 * radius * far))
    assert finding.fraction == pytest.approx(angle / math.pi, abs=1e-12)
    assert finding.point[:2] == pytest.approx(corner)


def spike(angle, reach):
    """A long thin pyramid that points at the origin, its tip so far from it; its sides are no wider than 1/20."""
    along, across = np.array([math.cos(angle), math.sin(angle), 0]), np.array([-math.sin(angle), math.cos(angle), 0])
    base = [(reach + 10) * along + x * across + (0, 0, 5 + z) for x, z in ((-0.05, 0), (0.05, 0), (0, 0.05))]
    tip = reach * along + (0, 0, 5)
    return fc.Polyhedron([tip, *base], [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])


@pytest.mark.thorough
def test_what_the_chords_of_an_arc_pass_by_is_met(tmp_path):
    """Spikes from outside that reach a little into the ring that the cutter sweeps, at many angles of the arc.

    Within a part of the arc the cutter goes beyond the hull of the part's ends.  Halves of a turn at the radius 50:
    the ring ends at 53.
    """
    for angle in np.linspace(0.1, math.pi - 0.1, amount(41, 4)):
        in_the_way = found_in(tmp_path, "G3 X-50 Y0 I-50", {"spike": spike(angle, 53 - 1e-4)}, start=(50, 0, 0))
        assert only(in_the_way).fraction == pytest.approx(angle / math.pi, abs=1e-2)
        beside = found_in(tmp_path, "G3 X-50 Y0 I-50", {"spike": spike(angle, 53 + 1e-4)}, start=(50, 0, 0))
        assert beside.status == "FREE"


def test_what_the_chords_of_a_swing_pass_by_is_met(tmp_path):
    """The top of a tilting cutter goes around the tip: spikes reach into the ball of its rim, between hulls' ends.

    The highest point of its upper end goes first.
    """
    text = "MULTAX/ON\nFROM/0,0,0,0,0,1\nGOTO/0,0,0,1,0,0"
    flutes, rim = fc.Tool([("flutes", "cutter", 6, 20)]), math.hypot(3, 20)
    for angle in np.linspace(0.2, 1.2, amount(21, 3)):
        told = []
        for reach in (rim - 1e-4, rim + 1e-4):
            body = spike(0.0, reach)
            turned = [math.cos(angle), 0, math.sin(angle)]
            place = np.array([turned, [0, 1, 0], [-turned[2], 0, turned[0]]]).T
            moved = fc.Polyhedron((body.vertices - (0, 0, 5)) @ place.T, body.triangles)
            told.append(found_in(tmp_path, text, {"spike": moved}, tool=flutes, name="job.apt").status)
        assert told == ["CONTACT", "FREE"]


def test_down_an_arc_in_the_plane_of_the_axis(tmp_path):
    """From (0, 0, 10) about (10, 0, 10) downwards; the flat end comes to the height 4 of the top."""
    plate = {"plate": post((-50, -50, -6), (100, 100, 10))}
    assert found_in(tmp_path, "G18 G3 X20 Z10 I10", plate, start=(0, 0, 10)).status == "FREE"
    finding = only(found_in(tmp_path, "G18 G2 X20 Z10 I10", plate, start=(0, 0, 10)))
    assert finding.tip[2] == pytest.approx(4, abs=1e-11)
    # parts of the arc are as long as their angles, and time in a part is a tangent
    whole, angle, step = math.pi, math.asin(0.6), 2 * math.atan(1 / 8)
    k = int(angle / step)
    in_part = 8 * math.tan((angle - k * step) / 2)
    assert finding.fraction == pytest.approx((k + in_part) * step / whole, abs=1e-12)


@BOTH
def test_the_axis_turns_about_the_tip(tmp_path, mesh):
    """Tilted by an angle, the rim of the end is 3 sin(angle) below the tip, which stays 1.2 above the plate."""
    text = "MULTAX/ON\nFROM/0,0,0,0,0,1\nGOTO/0,0,0,0.6,0,0.8"
    finding = only(found_in(tmp_path, text, {"plate": post((-50, -50, -11.2), (100, 100, 10), mesh)}, name="job.apt"))
    angle, half = math.asin(0.4), math.asin(0.6) / 2
    tangent = math.tan(angle / 2)
    assert finding.fraction == pytest.approx(tangent / (math.sin(half) + tangent * (1 - math.cos(half))), abs=1e-12)


def test_a_tilted_tool_goes_straight(tmp_path):
    """Its end is a tilted disc: along x it meets the plane x = 20 with its rim, 3 cos(angle) before the tip."""
    text = "MULTAX/ON\nFROM/0,0,0,0.6,0,0.8\nGOTO/40,0,0,0.6,0,0.8"
    finding = only(found_in(tmp_path, text, {"wall": post((20, -50, -60), (10, 100, 60.5))}, name="job.apt"))
    # the side reaches farther than the rim at heights above -3 * 0.6: up to the edge at 0.5
    height = 0.5
    reach = (3 + 0.6 * height) / 0.8  # of the side, a cylinder of radius 3 along (0.6, 0, 0.8), at that height
    assert finding.fraction == pytest.approx((20 - reach) / 40, abs=1e-12)


def test_cutting_stock_is_no_collision_unless_it_is_asked_for(tmp_path):
    bodies = {"stock": post((10, -5, -5), (10, 10, 20)), "fixture": post((10, 60, -5))}
    assert found_in(tmp_path, "G1 X15", bodies).status == "FREE"
    assert found_in(tmp_path, "G1 X15\nG0 Z50", bodies).status == "FREE"  # back over what it has cut
    for text in ("G0 X15", "G1 X15\nG0 Z50\nZ0", "G1 X15\nG0 X0"):
        verdict = found_in(tmp_path, text, bodies)
        assert {(x.part, x.body, x.move) for x in verdict.findings} == {("flutes", "stock", "rapid")}
    (finding,) = found_in(tmp_path, "G1 X15 Z-8", bodies).findings  # too deep
    assert (finding.part, finding.move) == ("shank", "feed")
    assert found_in(tmp_path, "G1 X15", bodies, allow=()).status == "CONTACT"
    assert found_in(tmp_path, "G1 X15 Z-8", bodies, allow=[Allowed.read("*:*:st?ck")]).status == "FREE"
    for text in ("cutter:feed", "cutter:fast:stock", ":feed:stock"):
        with pytest.raises(fc.InputError, match=text):
            Allowed.read(text)


def test_a_tool_inside_a_solid_that_its_surface_does_not_meet(tmp_path):
    hall = {"hall": post((-500, -500, -500), (1000, 1000, 1000))}
    assert {x.status for x in found_in(tmp_path, "G1 X30", hall).findings} == {"INITIAL_CONTACT"}
    shell = {"hall": fc.Polyhedron(hall["hall"].vertices, hall["hall"].triangles, solid=False)}
    assert found_in(tmp_path, "G1 X30", shell).status == "FREE"


def test_a_body_without_bounds_and_a_body_that_moves(tmp_path):
    table = {"table": fc.half_space((0, 0, 1), -1)}
    assert found_in(tmp_path, "G1 X30", table).status == "FREE"
    assert only(found_in(tmp_path, "G1 Z-4", table)).fraction == pytest.approx(0.25, abs=1e-13)
    with pytest.raises(fc.InputError, match="body 'post' moves"):
        found_in(tmp_path, "G1 X1", {"post": post((20, 0, 0)).moving(fc.Translation((1, 0, 0)))})


@pytest.mark.thorough
@pytest.mark.parametrize(("body", "x"), [
    (fc.torus(8, 2).translated((40, 0, 0)), 40 - 8 - 2 - 3),
    (fc.sphere(5).translated((20, 0, 5)), 20 - 5 - 3),
    (fc.Polyhedron([[20, -5, -1], [20, 5, 10]], [], edges=[[0, 1]]), 20 - 3),
    (fc.Polyhedron([[20, 1, 5]], []), 20 - math.sqrt(8)),
    (fc.RuledSurface("(20, 5*u, 0)", "(20, 5*u, 9)", u=(-1, 1)), 20 - 3),
], ids=["torus", "sphere", "edge", "point", "ruled surface"])  # fmt: skip
def test_bodies_of_all_kinds(tmp_path, body, x):
    assert only(found_in(tmp_path, "G1 X40", {"body": body})).fraction == pytest.approx(x / 40, abs=1e-12)
    assert found_in(tmp_path, "G1 X40\nG1 Y-90\nX0", {"body": body}).status == "FREE"


def test_several_tools_are_called_by_number(tmp_path):
    thin = fc.Tool([("thin", "cutter", 2, 20)], "thin", number=1)
    wide = fc.Tool([("wide", "cutter", 20, 20)], "wide", number=2)
    body = {"post": post((10, 5, -5))}
    text = "T1 M6\nG1 X40\nT2\nX0\nM6\nX40"
    file = tmp_path / "job.nc"
    file.write_text(text)
    told = list(fc.ToolPath(file, start=(0, 0, 0)).verdicts([thin, wide], body, workers=1))
    assert [[x.part for x in verdict.findings] for verdict in told] == [[], [], ["wide"]]
    file.write_text("T3 M6\nG1 X40")
    with pytest.raises(fc.InputError, match="line 2: T3: there is no such tool; the tools are thin .number 1., wide"):
        list(fc.ToolPath(file, start=(0, 0, 0)).verdicts([thin, wide], body))
    with pytest.raises(fc.InputError, match="line 2: T3: there is no such tool; the tools are thin .number 1."):
        list(fc.ToolPath(file, start=(0, 0, 0)).verdicts(thin, body))
    of_all = fc.Tool([("wide", "cutter", 20, 20)], "wide")  # without a number
    (verdict,) = fc.ToolPath(file, start=(0, 0, 0)).verdicts(of_all, body, workers=1)
    assert verdict.status == "CONTACT"


@pytest.mark.parametrize(("given", "what"), [
    ([], "no segments"), ([("a", "mill", 3, 4)], "kind 'mill' is unknown"),
    ([("a", "cutter", 0, 4)], "have to be positive"), ([("a", "cutter", 3)], "give .name"),
    ([("a", "cutter", 3, 4), ("a", "holder", 3, 4)], "two segments are called 'a'"),
])  # fmt: skip
def test_tools_that_are_none(given, what):
    with pytest.raises(fc.InputError, match=what):
        fc.Tool(given)


# -- hulls ----------------------------------------------------------------------------------------------------------


def exact(x):
    return fc.Translation(np.round(x, 3).tolist()).vector


def random_ways(rng, count):
    """Lines, and swings of up to half a radian, about a ball of radius 1."""
    for k in range(count):
        start, end = rng.normal(size=3) * 1.6, rng.normal(size=3) * 0.4
        if k % 2:
            yield StraightMove("feed", exact(start), exact(start + end))
        else:
            u = rng.normal(size=3)
            yield Swing("feed", exact(start), exact(start + end), exact(4 * u), exact(4 * u + 0.6 * rng.normal(size=3)))


def test_what_hulls_prove_apart_is_free():
    """Beside `first_contact` of the exact solid under the exact motion, another search: and little is left open."""
    ball, rng = fc.examples.noisy_sphere(2000), np.random.default_rng(5)
    tool = fc.Tool([("a", "cutter", "1/5", "1/2"), ("b", "holder", ("1/5", "3/5"), "1/2")])
    setup = Setup(tool, {"ball": ball}, ())
    apart = left = 0
    for way in random_ways(rng, 120):
        places = way.places(0.002, tool.segments[1].reach)
        tree = tree_of(ball)
        for segment in tool.segments:
            out = np.empty(len(places.fractions) - 1, np.int64)
            told_of_rows(
                tree.boxes, tree.links, tree.xyz, tree.ids, tree.error, True,
                np.stack([places.tips[:-1], places.tips[1:]], axis=1),
                np.stack([places.axes[:-1], places.axes[1:]], axis=1),
                np.full(len(out), places.pad + places.swing * segment.reach), np.array(segment.doubles),
                workspace()[0], out,
            )  # fmt: skip
            hit = fc.first_contact(way.moving(segment.solid), ball)
            if (out == APART).all():
                assert hit.status is fc.Status.FREE
                apart += 1
            elif hit.status is fc.Status.FREE:
                left += 1
            if (out == INSIDE).all():
                assert hit.initial == "containment"
    assert apart > 60 and left <= 0.1 * apart
    assert setup.targets[0].mesh is ball and OPEN not in (APART, INSIDE)


def turned(u, v, t):
    """By hand: the straight line of unit quaternions from 1 to the one that takes u to v."""
    q = np.array([1 + u @ v, *np.cross(u, v)])
    q /= np.linalg.norm(q)
    w, *xyz = (1 - t) * np.array([1.0, 0, 0, 0]) + t * q
    k = np.array([[0, -xyz[2], xyz[1]], [xyz[2], 0, -xyz[0]], [-xyz[1], xyz[0], 0]])
    n = w * w + np.dot(xyz, xyz)
    return np.eye(3) + 2 / n * (w * k + k @ k)


def test_places_hold_all_between():
    """Points of the tool at times between two places stray from the line between theirs by no more than is told."""
    rng = np.random.default_rng(2)
    for way in random_ways(rng, 60):
        if isinstance(way, StraightMove):
            continue
        places = way.places(0.05, 2.0)
        u, v = (np.array([float(c.p) / float(c.q) for c in x]) for x in (way.axis0, way.axis1))
        u, v = u / np.linalg.norm(u), v / np.linalg.norm(v)
        start = places.tips[0]
        whole = places.tips[-1] - start
        x = rng.normal(size=(50, 3))
        x *= 2.0 / np.linalg.norm(x, axis=1)[:, None]
        for i, j in zip(places.fractions, places.fractions[1:], strict=False):
            ends = [x @ turned(u, v, t).T + start + t * whole for t in (i, j)]
            for s in (0.25, 0.5, 0.8):
                t = i + s * (j - i)
                here = x @ turned(u, v, t).T + start + t * whole
                off = np.linalg.norm(here - (1 - s) * ends[0] - s * ends[1], axis=1).max()
                assert off <= places.pad + 2.0 * places.swing
        for t, axis in zip(places.fractions, places.axes, strict=True):
            assert axis == pytest.approx(turned(u, v, t) @ u, abs=1e-13)


@pytest.mark.thorough
def test_free_and_contact_beside_points_of_the_tool(tmp_path):
    """Random blocks before a box: sampled points of a free tool are outside; just after a contact the tool is in."""
    rng, lo, hi = np.random.default_rng(9), np.array([10.0, -8.0, -20.0]), np.array([26.0, 9.0, 3.0])
    body = {"post": post(lo, hi - lo)}
    tool = fc.Tool([("flutes", "cutter", 6, 20)])
    lines = ["G90 G17"]
    at = (0.0, 0.0)
    for k in range(90):
        to = np.round(rng.uniform((-20, -25), (45, 25)), 2)
        z = round(float(rng.uniform(-10, 12)), 2)
        centre = (0.5 * (to[0] - at[0]), 0.5 * (to[1] - at[1]))
        arc = f"G{2 + k % 2} X{to[0]} Y{to[1]} Z{z} I{centre[0]:.6f} J{centre[1]:.6f}"
        lines.append(arc if k % 3 == 0 else f"G1 X{to[0]} Y{to[1]} Z{z}")
        at = tuple(to)
    file = tmp_path / "job.nc"
    file.write_text("\n".join(lines))
    a = np.linspace(0, 2 * np.pi, 120)
    ring = np.column_stack([np.cos(a), np.sin(a)])
    rings = [(3, z) for z in np.linspace(0, 20, 60)] + [(r, z) for r in (0, 1, 2) for z in (0, 20)]
    points = np.concatenate([np.column_stack([r * ring, np.full(len(a), z)]) for r, z in rings])

    def inside(tip, by):
        x = points + tip
        return ((x > lo + by) & (x < hi - by)).all(axis=1).any()

    statuses = set()
    for verdict in fc.ToolPath(file, start=(0, 0, 5)).verdicts(tool, body, workers=1):
        (way,) = verdict.block.stretches
        statuses.add(verdict.status)
        until = only(verdict).fraction if verdict.findings else 1.0
        for t in np.linspace(0, until, 60)[: len(verdict.findings) * -1 or None] if until else ():
            assert not inside(np.array(way.tip(t)), 1e-9)
        if verdict.findings and until < 0.98:
            assert inside(np.array(way.tip(until + 0.02)), -0.2)
    assert statuses == {"FREE", "CONTACT"}


@pytest.mark.share(4)
@pytest.mark.parametrize("whole", [3, 7, 9, 13])
def test_the_enclosure_holds_fractions_that_are_no_doubles(tmp_path, whole):
    """A cutter of radius 1 goes from 0 to `whole`, and a wall stands so that they meet at k / whole."""
    tool = fc.Tool([("flutes", "cutter", 2, 2)])
    for k in range(1, whole):
        wall = fc.box((1, 4, 4)).translated((k + 1 + Fraction(1, 2), 0, 0))
        (finding,) = found_in(tmp_path, f"G0 X{whole} Y0 Z0", {"wall": wall}, tool=tool).findings
        assert Fraction(finding.lo) <= Fraction(k, whole) <= Fraction(finding.hi)


@pytest.mark.thorough
def test_the_enclosure_holds_fractions_of_a_block_of_many_ways(tmp_path):
    """A drill goes down 1 fast and on to its depth, then back up to -1: it meets the floor after top of 2 depth - 1."""
    drill = fc.Tool([("flutes", "cutter", 2, 2)])
    for depth in (3, 5, 6, 7, 9, 11, 12, 13, 14, 15):
        for top in range(2, depth):
            floor = {"floor": fc.box((4, 4, 40)).translated((0, 0, -top - 20))}
            (finding,) = found_in(tmp_path, f"G90 G99 G81 X0 Y0 Z-{depth} R-1 F100", floor, tool=drill).findings
            way = 2 * depth - 1
            assert Fraction(finding.lo) <= Fraction(top, way) <= Fraction(finding.hi), (depth, top)
