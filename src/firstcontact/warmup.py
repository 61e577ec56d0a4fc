"""Compile every kernel by asking tiny questions whose paths together use all of them."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from functools import cache, partial
from itertools import chain
from multiprocessing import get_context
from typing import TYPE_CHECKING, Any

from firstcontact import query
from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.polyhedron.topology import component_of_vertices
from firstcontact.body.ruled.surface import RuledSurface
from firstcontact.body.solid import primitives
from firstcontact.body.solid.composite_quadric import CompositeQuadric
from firstcontact.kernels import thrift
from firstcontact.kernels.cache import COMPILED
from firstcontact.motion.rational import RationalMotion
from firstcontact.motion.rotation import Rotation
from firstcontact.motion.screw import Screw
from firstcontact.motion.sequence import Sequence
from firstcontact.motion.translation import Translation, vector3
from firstcontact.search.trees.crowding import crowding
from firstcontact.search.trees.frame import tree_of
from firstcontact.toolpath.blocks import Block
from firstcontact.toolpath.check import Setup
from firstcontact.toolpath.moves import StraightMove
from firstcontact.toolpath.tool import Tool

if TYPE_CHECKING:
    from firstcontact.body.kinds import Shape
    from firstcontact.motion.kinds import AnyMotion

Question = Callable[[], object]

# An oblique axis: kernels for axes along z alone would leave the general ones uncompiled.  The turn brings bodies near
# each other, else balls around them tell that they never meet.
SHIFT, SWING = Translation((0, 0, -2)), Rotation((1, 2, 0), (1, 0, 1), degrees=200)
SCREW = Screw((0.1, 1, 2), (0.3, -0.2, 0.1), degrees=40, advance=-3)
MOTIONS: dict[str, AnyMotion] = {
    "screw": SCREW,
    "rotation": SWING,
    "translation": SHIFT,
    "sequence": Sequence([SHIFT, SWING]),
}
SADDLE, LEVEL = RuledSurface("(u, 0, 0)", "(u, 1, u)"), RuledSurface("(u, 0, 1/2)", "(u, 1, 1/2)")
FEW = 2000
"""Units of work that a question may take: it is for the kernels' sake, not for the answer's."""


def questions() -> dict[str, Question]:
    """Questions by what they are about."""
    return dict(chain.from_iterable(map(_questions_of, range(len(_FAMILIES)))))


def warm(progress: Callable[[str], object] | None = None) -> int:
    """Ask them all; `progress` is told what comes next.  Returns how many kernels were compiled."""
    before = len(COMPILED)
    for name, ask in questions().items():
        if progress is not None:
            progress(name)
        ask()
    return len(COMPILED) - before


def warm_together(processes: int, progress: Callable[[str], object] | None = None, begun_by: str = "spawn") -> int:
    """The same by several processes, which share what they compile; `progress` is told what is done.

    Of a family one question is asked at a time: two would wait for each other at every kernel that both need.  Most
    families need what the first one compiles first, so they begin afterwards.

    begun_by: how processes begin, a word of `multiprocessing`; a "fork" imports nothing again, and inherits threads
    and locks of whoever calls.
    """
    with ProcessPoolExecutor(processes, mp_context=get_context(begun_by), initializer=thrift.apply) as pool:
        asked: dict[Future[tuple[str, int] | None], tuple[int, int]] = {}

        def ask(family: int, k: int) -> None:
            asked[pool.submit(_ask, family, k)] = family, k

        first, beside, *later = range(len(_FAMILIES))
        ask(first, 0)
        ask(beside, 0)
        compiled = 0
        while asked:
            for done in wait(asked, return_when=FIRST_COMPLETED).done:
                family, k = asked.pop(done)
                if (answer := done.result()) is None:
                    continue
                name, more = answer
                compiled += more
                if progress is not None:
                    progress(name)
                ask(family, k + 1)
                if family == first:
                    for each in later:
                        ask(each, 0)
                    later = []
    return compiled


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _ask(family: int, k: int) -> tuple[str, int] | None:
    """The k-th question of a family: what it is about, and how many kernels were compiled.  Without one, None."""
    questions = _questions_of(family)
    if k == len(questions):
        return None
    before = len(COMPILED)
    name, ask = questions[k]
    ask()
    gc.freeze()  # garbage is not looked for, by nobody and not at the end: the process ends soon
    return name, len(COMPILED) - before


@cache
def _questions_of(family: int) -> list[tuple[str, Question]]:
    return list(_FAMILIES[family]())


def _of_engine(engine: str) -> Iterator[tuple[str, Question]]:
    base, raised = _stacked()
    for name in ("translation", "rotation"):
        moving = raised.moving(MOTIONS[name])
        yield f"engine {engine} under {name}", partial(query.first_contact, moving, base, engine=engine)


def _of_meshes() -> Iterator[tuple[str, Question]]:
    base, raised = _stacked()
    verbs = query.first_contact, query.contact_intervals, query.contact_pairs
    for name, motion in MOTIONS.items():
        for verb in verbs[: 2 if name == "sequence" else 3]:
            yield f"{verb.__name__} under {name}", partial(verb, raised.moving(motion), base)
    inside = base.transformed([[0.1, 0, 0, 0.1], [0, 0.1, 0, 0.1], [0, 0, 0.1, 0.1], [0, 0, 0, 1]])
    open_mesh = Polyhedron(base.vertices, base.triangles[:2])
    yield "meshes that overlap", partial(query.first_contact, base.translated((0.1, 0.1, 0)), base)
    yield "a mesh inside another", partial(query.first_contact, inside, base)
    yield "an open mesh", partial(query.first_contact, raised.moving(SHIFT), open_mesh)
    yield "bare points", partial(query.first_contact, raised.moving(SHIFT), Polyhedron(base.vertices, []))
    yield "crowded trees", partial(_crowding, base)
    yield "parts of a mesh", partial(component_of_vertices, base.edges, len(base.vertices))  # of `info`


def _crowding(mesh: Polyhedron) -> None:
    """Asked only of larger bodies."""
    tree = tree_of(mesh)
    crowding(tree.boxes, tree.links, tree.boxes, tree.links)


def _of_solids() -> Iterator[tuple[str, Question]]:
    ball = primitives.sphere(1).translated((0.125, 0.0625, 3))
    holed = primitives.box((4, 4, 2)) - primitives.cylinder("1/2", 4)
    turned = RationalMotion.between(Rotation((0, 0, 1), degrees=0)(0.0), SWING(0.2))
    bodies: dict[str, Any] = {"a solid": holed, "a mesh": _notched()}
    for name, motion in {**MOTIONS, "rational motion": turned}.items():
        for kind, other in bodies.items():
            # intervals need the same kernels under all motions, and take long under some
            for verb in (query.first_contact, query.contact_intervals)[: 2 if name == "translation" else 1]:
                yield f"{verb.__name__} of a ball and {kind} under {name}", partial(
                    verb, ball.moving(motion), other, budget=FEW
                )
    yield "solids that overlap", partial(query.first_contact, ball.translated((0, 0, -2)), holed)
    yield "a capsule", partial(query.first_contact, _capsule().moving(SHIFT), holed, budget=FEW)


def _capsule() -> CompositeQuadric:
    stem = primitives.cylinder("1/4", 2).translated((0, 0, 4))
    return stem | primitives.sphere("1/4").translated((0, 0, 3))


def _of_tool_paths() -> Iterator[tuple[str, Question]]:
    tool = Tool([("mill", "cutter", "1/2", 1)])
    ways = StraightMove("rapid", vector3((5, 5, 5), "start"), vector3((5, 5, 4), "end")), StraightMove(
        "feed", vector3((0.5, 0.5, 0.75), "start"), vector3((0.5, 0.5, 0.25), "end")
    )
    blocks = [Block(k, "", (way,)) for k, way in enumerate(ways)]
    setup = Setup(tool, {"a mesh": _notched()}, (), 1)
    yield "a tool path before a mesh", lambda: list(setup.verdicts(blocks))


def _of_curves() -> Iterator[tuple[str, Question]]:
    yield "intersection_curve", partial(query.intersection_curve, SADDLE, LEVEL, method="certified")


def _of_ruled_surfaces() -> Iterator[tuple[str, Question]]:
    above = LEVEL.translated((0, 0, 2)).moving(SHIFT)
    others: dict[str, Shape] = {
        "surfaces": SADDLE,
        "a surface and a solid": primitives.sphere("1/2"),
        "a surface and a mesh": _notched(),
    }
    for kind, other in others.items():
        for verb in (query.first_contact, query.contact_intervals):
            yield f"{verb.__name__} of ruled {kind}", partial(verb, above, other, budget=FEW)


def _stacked() -> tuple[Polyhedron, Polyhedron]:
    base = _tetrahedron()
    return base, base.translated((0.125, 0.0625, 2))  # off the symmetric place, where screws leave pairs undecided


def _tetrahedron() -> Polyhedron:
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    return Polyhedron(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def _notched() -> Polyhedron:
    """A prism over an L: not convex."""
    corners = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    rings = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]]
    return Polyhedron([(x, y, z) for z in (0, 1) for x, y in corners], rings + sides)


_FAMILIES: list[Callable[[], Iterator[tuple[str, Question]]]] = [
    _of_meshes,
    _of_curves,
    partial(_of_engine, "lifted"),
    _of_solids,
    _of_ruled_surfaces,
    _of_tool_paths,
    partial(_of_engine, "sweep"),
    partial(_of_engine, "composed"),
]
"""Questions that share most of their kernels; the first two share none, those next compile longest."""
