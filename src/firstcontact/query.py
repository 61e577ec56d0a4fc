"""The verbs."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import TYPE_CHECKING

from firstcontact.contact import table
from firstcontact.errors import InputError, UnsupportedPair, shown
from firstcontact.exact.numbers import positive_double
from firstcontact.kernels.jit import with_signals
from firstcontact.motion.linkage import Linkage
from firstcontact.motion.screw import Screw
from firstcontact.motion.span import common_span, refuse_many_turns
from firstcontact.result import ContactIntervals, ContactPairs, FirstContact
from firstcontact.work import MOST_BUDGET, Progress, Query

if TYPE_CHECKING:
    from firstcontact.body.kinds import AnyBody
    from firstcontact.exact.numbers import Given
    from firstcontact.result_curve import IntersectionCurve


@with_signals
def first_contact(
    a: AnyBody,
    b: AnyBody,
    span: Sequence[Given] | None = None,
    *,
    exact: bool = False,
    method: str = "auto",
    engine: str = "auto",
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Progress | None = None,
    threads: int = 1,
) -> FirstContact:
    """FirstContact at the earliest time in the closed span at which a and b share a point.

    Contact is between closed sets: grazing counts, solids own their interior.  Status.FREE proves that they share no
    point at any time of the span.

    a, b: bodies, at rest or ``body.moving(motion)``.  Bodies are Polyhedron, meshes of trimesh, CompositeQuadric (box,
    sphere, ellipsoid, cylinder, cone, frustum, paraboloid, hyperboloid, half_space, quadric, combined by ``|``, ``&``,
    ``-``) and RuledSurface.  Motions are Translation, Rotation, Screw, RationalMotion, Sequence and Trajectory.
    span: (first, last) in the motions' clock, default None: what the motions' own have in common; ``inf`` as last for
    translations.
    exact: True decides in exact arithmetic and adds `time_exact`; default False.
    method: "certified" answers in doubles with proofs, "algebraic" by exact equations alone; default "auto" takes what
    is sooner done.
    engine: of polyhedra, which trees are asked; the answer is the same.  "boxes"; "lifted", for scenes in which nearly
    everything passes nearly everything; default "auto" begins with boxes and changes over to "lifted" when boxes have
    had enough pair tests; "composed" is the paper's structure among edges and "sweep" its plane sweep among vertices
    and facets, for reading and measuring.  All but boxes are for translations and rotations only.  `stats.engine` tells
    which one answered.
    tolerance: largest width of `time_interval`, relative to the span, default 1e-12 (enclosures come out a few units in
    the last place wide, whatever is asked).
    budget: node visits plus pair tests (curved models: strides, subproblems and candidates) after which to answer
    UNDECIDED; default None: no limit.
    progress: called with (free until, work) now and then; default None.
    threads: how many share the queries of "composed" and the groups of "sweep", default 1; other engines take one.  The
    answer is the same, bit for bit.

    Raises UnsupportedPair with exact=True where times have no exact form, as under screws (docs/motions.md).

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((2, 2, 2))
    >>> hit = fc.first_contact(cube.moving(fc.Translation((0, 0, 6))), cube.translated((0.5, 0.5, 5)))
    >>> hit.time, hit.point.tolist()
    (0.5, [1.0, 1.0, 4.0])
    """
    begin = clock.perf_counter()
    tolerance = check_arguments(method, engine, tolerance, budget)
    if not isinstance(threads, int) or not 1 <= threads <= MOST_THREADS:
        raise InputError(f"threads is {shown(threads)}; give a whole number from 1 to {MOST_THREADS}")
    a, b = table.as_body(a), table.as_body(b)
    first, last = common_span(a, b, span)
    if budget is None or table.kinds_of(a, b) != table.MESHES:  # turns of polyhedra count as work
        refuse_many_turns(a, b, first, last, (Screw, Linkage))  # the first contact of a Rotation is in its first turn
    return table.first_contact(
        Query(a, b, first, last, exact, method, engine, tolerance, budget, progress, threads, begin)
    )


@with_signals
def contact_intervals(
    a: AnyBody,
    b: AnyBody,
    span: Sequence[Given] | None = None,
    *,
    exact: bool = False,
    method: str = "auto",
    tolerance: float = 1e-12,
    budget: int | None = None,
    progress: Progress | None = None,
) -> ContactIntervals:
    """All closed times of the span at which a and b share a point, as disjoint intervals; exact ends.

    Arguments as in `first_contact`; method, of curved bodies: "certified" has enclosures of the ends from doubles,
    "algebraic" exact equations alone, "auto" what is sooner done.  The cost grows with the number of element pairs that
    meet near the ends of the intervals.  Status.FREE proves that there are none.

    >>> import firstcontact as fc
    >>> cube = fc.examples.box((1, 1, 1))
    >>> print(fc.contact_intervals(cube.moving(fc.Translation((8, 0, 0))), cube.translated((3, 0, 0))))
    box and box: CONTACT
      [0.25, 0.5]
    """
    begin = clock.perf_counter()
    tolerance = check_arguments(method, "auto", tolerance, budget)
    a, b = table.as_body(a), table.as_body(b)
    first, last = common_span(a, b, span)
    if budget is None or table.kinds_of(a, b) != table.MESHES:
        refuse_many_turns(a, b, first, last)
    return table.contact_intervals(
        Query(a, b, first, last, exact, method, tolerance=tolerance, budget=budget, progress=progress, begin=begin)
    )


@with_signals
def contact_pairs(a: AnyBody, b: AnyBody, span: Sequence[Given] | None = None) -> ContactPairs:
    """All element pairs (vertex/face, edge/edge, face/vertex) that meet during the span.

    Arguments as in `first_contact`; diagonals inside polygons count as their faces.  Where many pairs pass each other
    and few meet, those that do are reported by the paper's range searching instead of tested one by one.

    >>> import firstcontact as fc
    >>> rod = fc.Polyhedron([[-1, 0, 0], [1, 0, 0]], [], edges=[[0, 1]])
    >>> print(fc.contact_pairs(rod.moving(fc.Translation((0, 0, 2))), rod.rotated((0, 0, 1), degrees=90)))
    1 element pairs meet, 0 pierced at the start
    """
    begin = clock.perf_counter()
    a, b = table.as_body(a), table.as_body(b)
    first, last = common_span(a, b, span)
    refuse_many_turns(a, b, first, last)
    return table.contact_pairs(Query(a, b, first, last, begin=begin))


@with_signals
def intersection_curve(
    p: AnyBody,
    q: AnyBody,
    *,
    tolerance: float = 1e-6,
    method: str = "auto",
    box: Sequence[Sequence[Given]] | None = None,
) -> IntersectionCurve:
    """IntersectionCurve: all points that two ruled surfaces at rest share, or one of them and a solid's boundary.

    Branches with their topology, common rulings, isolated and singular points; what is not listed is proved not to be
    there, but for `open_places` (docs/ruled-surfaces.md says what the coordinates rest on).  Deforming or moving
    surfaces: give p.at(t).

    tolerance: greatest distance between a branch and its polyline.  box: two corners ((x, y, z), (x, y, z)); only what
    lies in it is reported.  Without one, unbounded branches are cut about 100 times the size of the directrices away
    from the origin, and beyond that the tolerance grows.  method: "algebraic" is exact; "certified" takes pieces of any
    degree and strips, in doubles with proofs, and exactly where doubles leave something open and degrees are small; of
    two surfaces with whole rulings it tells what lies in the result's `box`; "auto" chooses.

    Solids are half-spaces, quadrics and all models made of them, and polyhedra of any shape, open ones too; their
    columns of the parameters are nan (null in JSON), their exact parameters None.

    Raises UnsupportedPair for other bodies, and for the cases that docs/ruled-surfaces.md lists.

    >>> import firstcontact as fc
    >>> saddle = fc.RuledSurface("(u, 0, 0)", "(u, 1, u)")
    >>> plane = fc.RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
    >>> curve = fc.intersection_curve(saddle, plane)
    >>> [end.point.tolist() for end in curve.branches[0].ends]
    [[0.5, 1.0, 0.5], [1.0, 0.5, 0.5]]
    """
    from firstcontact.curves import ruled as verbs
    from firstcontact.curves.with_solids import solid_verbs
    from firstcontact.exact.curves.fibres import PrecisionExhausted

    p, q = table.as_body(p), table.as_body(q)
    table.proves("intersection_curve", p, q)
    tolerance = positive_double(tolerance, "tolerance", "length")
    search = verbs if set(table.kinds_of(p, q)) == {table.Kind.RULED} else solid_verbs
    try:
        found: IntersectionCurve = search.curve(p, q, tolerance, method, box)
        return found
    except PrecisionExhausted as error:
        raise UnsupportedPair(
            f"the curve of {p!r} and {q!r} asks for too many digits ({error}); move a body a little, or scale both"
        ) from error


METHODS = ("auto", "certified", "algebraic")
ENGINES = ("auto", "boxes", "lifted", "composed", "sweep")
# More than any machine has; each one asked for is started.
MOST_THREADS = 1024


def check_arguments(method: str, engine: str, tolerance: float, budget: int | None) -> float:
    """The tolerance as a double; raises for arguments that no search takes."""
    if method not in METHODS:
        raise UnsupportedPair(f"method {method!r} is unknown; choose one of {', '.join(METHODS)}")
    if engine not in ENGINES:
        raise UnsupportedPair(f"engine {engine!r} is unknown; choose one of {', '.join(ENGINES)}")
    if budget is not None and (not isinstance(budget, int) or not 0 <= budget <= MOST_BUDGET):
        raise InputError(f"budget is {shown(budget)}; give a whole number of node visits and pair tests, at most 2^60")
    return positive_double(tolerance, "tolerance")
