"""Small scenes with answers known by hand, one for every way a query can end."""

import numpy as np

import firstcontact as fc
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.translation import Translation
from firstcontact.result import Element, FirstContact, Status

SQUARE = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
CUBE_FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
TOP = 1
"""Index of the cube's upper face."""
APEX = 0
"""Index of the spike's lowest vertex."""


def cube(name):
    """The cube |x|, |y|, |z| <= 1/2 with six square faces."""
    corners = [(x, y, z) for z in (-0.5, 0.5) for x, y in SQUARE]
    return Polyhedron(corners, CUBE_FACES, name=name)


def spike():
    """A pyramid on its apex (1/8, 1/4, 3/2), its square base above."""
    base = [(x + 0.125, y + 0.25, 2.5) for x, y in SQUARE]
    sides = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4]]
    return Polyhedron([(0.125, 0.25, 1.5), *base], [*sides, [1, 2, 3, 4]], name="spike")


def falling_spike():
    """The apex meets the cube's top at time 1/2, at (1/8, 1/4, 1/2), and is inside until the end."""
    return spike().moving(Translation((0, 0, -2))), cube("box")


def first_hit():
    return fc.first_contact(*falling_spike())


def passing_by():
    """A cube that turns around another one without touching it, in three steps over (0, 4)."""
    steps = [Translation((0, 0, 1)), Rotation((0, 0, 1), degrees=270), Translation((1, 0, 0))]
    mover = cube("<b>mover</b></script>").translated((3, 0, 0)).moving(Sequence(steps, [1, 2, 1]))
    return mover, cube("box")


def undecided():
    a, b = falling_spike()
    return FirstContact(Status.UNDECIDED, free_until=0.25, reason="budget", a=a, b=b)


def overlapping_at_start():
    mover = cube("mover").translated((0.5, 0.25, 0.25)).moving(Translation((2, 0, 0)))
    return fc.first_contact(mover, cube("box"))


class SharedCurve(str):
    """The kind of a contact set, with its points (n, 3) in the world."""

    def __new__(cls, kind, points):
        shared = super().__new__(cls, kind)
        shared.points = np.asarray(points, float)
        return shared


def plate():
    """A plate 4 x 4 x 1 about the origin with a hole of radius 1."""
    return (fc.box((4, 4, 1)).named("slab") - fc.cylinder(1, 2).named("hole")).named("plate")


def plug():
    """A cone, its tip at the bottom: radius 2 at z = 3, tip at z = 0."""
    return fc.cone(2, 3).rotated((1, 0, 0), degrees=180).translated((0, 0, 3)).named("plug")


def element(which, body, kind, name):
    features = {"face": body.faces, "edge": body.edges, "vertex": body.vertices, "apex": body.vertices}[kind]
    (feature,) = [f for f in features if f.name == name]
    return Element(kind, which, feature.index, name)


def plugged():
    """The plug falls by 4 from 2 above the origin and touches the rim of the hole, z = 1/2, all around.

    The cone has radius 1 at 3/2 above its tip: the tip is at z = -1, after 3/4 of the way.
    """
    a, b = plug().translated((0, 0, 2)).moving(Translation((0, 0, -4))), plate()
    angles = np.linspace(0, 2 * np.pi, 91)
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.full(91, 0.5)])
    return FirstContact(
        Status.CONTACT, time=0.75, time_interval=(0.75, 0.75), point=np.array([1.0, 0.0, 0.5]),
        element_a=element("a", a.body, "face", "plug.side"), element_b=element("b", b, "edge", "plate.hole.rim.top"),
        multiplicity=1, contact_set=SharedCurve("conic arc", circle), a=a, b=b,
    )  # fmt: skip


def tip_on_floor():
    """The plug's tip falls on a floor without end, z = 0, after half of the way."""
    a, b = plug().translated((0, 0, 2)).moving(Translation((0, 0, -4))), fc.half_space((0, 0, 1), 0, name="floor")
    return FirstContact(
        Status.CONTACT, time=0.5, time_interval=(0.5, 0.5), point=np.zeros(3), normal=np.array([0.0, 0.0, 1.0]),
        element_a=element("a", a.body, "vertex", "plug.apex"), element_b=element("b", b, "face", "floor.plane"),
        multiplicity=1, contact_set="point", a=a, b=b,
    )  # fmt: skip


CIRCLE = "((1-u**2)/(1+u**2), 2*u/(1+u**2), {})"


def crossing_pipes():
    """Two equal cylinders at a right angle meet in two ellipses, which cross in two nodes."""
    upright = fc.RuledSurface(CIRCLE.format(-2), CIRCLE.format(2), u=None, name="upright")
    return fc.intersection_curve(upright, upright.rotated((0, 1, 0), degrees=90).named("level"), tolerance=1e-3)


def cone_and_pipe():
    """A loop, a ruling that is in both, and the cone's apex, which lies on the pipe."""
    cone = fc.RuledSurface("(0, 0, 0)", CIRCLE.format(1), u=None, s=None, name="cone")
    leaning = "((1-u**2)/(1+u**2), (1+u)**2/(1+u**2), 2)"
    pipe = fc.RuledSurface(CIRCLE.format(1), leaning, u=None, s=None, name="pipe")
    return fc.intersection_curve(cone, pipe, tolerance=1e-3)


def flat_pieces():
    """Two unit squares of one plane share a square of side 1/2."""
    square = fc.RuledSurface("(u, 0, 0)", "(u, 1, 0)", name="square")
    return fc.intersection_curve(square, square.translated(("1/2", "1/2", 0)).named("other"))


def cusped():
    """The tangents of a cubic meet the plane across it at one of its points: a cusp there."""
    cubic, ahead = "(u, u**2, u**3)", "(u + 1, u**2 + 2*u, u**3 + 3*u**2)"
    tangents = fc.RuledSurface(cubic, ahead, u=(-1, 1), s=(-2, 2), name="tangents")
    plane = fc.RuledSurface("(0, u, 0)", "(0, u, 1)", u=(-2, 2), s=(-2, 2), name="plane")
    return fc.intersection_curve(tangents, plane, tolerance=1e-3)


def roller():
    """A cylinder along x about (., -T, -T^2) and one at rest touch from T = -sqrt(2)/2 until sqrt(2)/2."""
    along = "({}, (1 - T - (1 + T)*u**2)/(1 + u**2), 2*u/(1 + u**2) - T**2)"
    upright = "(-2*u**2/(1 + u**2), 2*u/(1 + u**2), {})"
    a = fc.RuledSurface(along.format(-1), along.format(0), u=None, name="roller")
    b = fc.RuledSurface(upright.format("1/2"), upright.format("3/2"), u=None, name="pipe")
    return fc.contact_intervals(a, b, (-2, 2))


def jointed():
    """An arm of two turning joints along cubic values, a claw that follows the elbow, and a wall."""
    links = {
        "wall": fc.box((1, 8, 4)).translated((-3, 0, 0)),
        "upper": fc.box((2, "1/4", "1/4")).translated((1, 0, 0)),
        "fore": fc.box((2, "1/4", "1/4")).translated((3, 0, "1/2")),
        "claw": fc.box(("1/4", "1/4", "1/4")).translated((4, 0, "1/2")),
    }
    joints = [
        fc.Joint("shoulder", "revolute", "wall", "upper", axis=(0, 0, 2), limits=(0, 180)),
        fc.Joint("elbow", "revolute", "upper", "fore", axis=(0, 1, 2), point=(2, 0, 0), limits=(-150, 150)),
        fc.Joint("grip", "prismatic", "fore", "claw", axis=(1, 0, 0), mimic=("elbow", "1/100", "1/8")),
    ]
    values = {"shoulder": [0, 90, 120], "elbow": [0, 30, 60]}
    return fc.Mechanism(links, joints).course([0, 1, 2], values, interpolation="cubic")
