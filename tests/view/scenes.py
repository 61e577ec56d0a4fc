"""Small scenes with answers known by hand, one for every way a query can end."""

import firstcontact as fc
from firstcontact.body.polyhedron import Polyhedron
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.translation import Translation
from firstcontact.result import FirstContact, Status

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
