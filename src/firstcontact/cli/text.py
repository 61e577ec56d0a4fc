"""What `check` and `intervals` print: few answers in full, of many the counts and the contacts, earliest first."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from firstcontact.result import ContactIntervals, Element, FirstContact
    from firstcontact.scene.load import Scene
    from firstcontact.view.pair import Result

FEW = 8
"""Pairs whose answers are printed in full, as they come."""
MOST_CONTACTS, MOST_OPEN, MOST_ALLOWED, MOST_NAMED = 20, 5, 5, 3
"""Lines of each kind, and pairs that a line names: what there is fits on a screen."""
SAID = {"CONTACT": "in contact", "UNDECIDED": "undecided", "ALLOWED": "allowed", "FREE": "free"}


def in_full(result: Result, scene: Scene) -> str:
    """The answer; of a first contact also how far the bodies have moved, and what its time means."""
    from firstcontact.assembly.words import progress, reading
    from firstcontact.result import FirstContact

    if not isinstance(result, FirstContact) or result.status.name == "FREE":
        return str(result)
    done = progress(result, scene.unit)
    return f"{result}\n  {done}: {reading((result.a, result.b))}" if done else str(result)


def left_out(scene: Scene) -> str:
    """"" where nothing is."""
    if not scene.resting:
        return ""
    return f"{_count(scene.resting, 'pair')} at rest with each other left out (rest = true asks for them)"


def summary(results: Sequence[Any], scene: Scene) -> str:
    return "\n".join(_lines(results, scene))


def _lines(results: Sequence[FirstContact | ContactIntervals], scene: Scene) -> Iterator[str]:
    from firstcontact.assembly.together import verdict
    from firstcontact.assembly.words import reading

    kinds = [verdict(result) for result in results]
    counts = Counter(kinds)
    told = ", ".join(f"{counts[kind]:,} {word}" for kind, word in SAID.items() if counts[kind])
    yield f"{_count(len(scene.bodies), 'body', 'bodies')}, {_count(len(results), 'pair')} asked: {told}"
    if scene.resting:
        yield left_out(scene)
    yield reading(scene.bodies.values()) + (f"; lengths in {scene.unit}" if scene.unit else "")
    contacts = sorted((r for r, kind in zip(results, kinds, strict=True) if kind == "CONTACT"), key=_when)
    yield from (_contact(result, scene.unit) for result in contacts[:MOST_CONTACTS])
    yield from _more(len(contacts) - MOST_CONTACTS, "contacts")
    undecided = [r for r, kind in zip(results, kinds, strict=True) if kind == "UNDECIDED"]
    yield from (f"undecided: {_pair(r)}, free until {r.free_until:.9g} ({r.reason})" for r in undecided[:MOST_OPEN])
    yield from _more(len(undecided) - MOST_OPEN, "undecided")
    allowed: dict[str, list[FirstContact | ContactIntervals]] = defaultdict(list)
    for result in results:
        if (why := getattr(result, "allowed", None)) is not None:
            allowed[why].append(result)
    for why, pairs in list(allowed.items())[:MOST_ALLOWED]:
        names = ", ".join(map(_pair, pairs[:MOST_NAMED])) + ", ..." * (len(pairs) > MOST_NAMED)
        yield f"allowed: {_count(len(pairs), 'pair')} {why}: {names}"
    yield from _more(len(allowed) - MOST_ALLOWED, "kinds of what is allowed")


def _more(n: int, what: str) -> Iterator[str]:
    if n > 0:
        yield f"  and {n:,} more {what}: --all"


def _when(result: FirstContact | ContactIntervals) -> float:
    from firstcontact.result import ContactIntervals

    time = result[0].start if isinstance(result, ContactIntervals) else result.time
    assert time is not None  # it is in contact
    return time


def _contact(result: FirstContact | ContactIntervals, unit: str) -> str:
    """One line; how far the bodies have moved is told where one of them rests."""
    from firstcontact.assembly.resting import moves
    from firstcontact.assembly.words import progress
    from firstcontact.result import ContactIntervals

    done = "" if moves(result.a) and moves(result.b) else progress(result, unit)
    if isinstance(result, ContactIntervals):
        spans = ", ".join(f"[{x.start:.9g}, {x.end:.9g}]" for x in result[:MOST_NAMED])
        return "; ".join(x for x in (f"  {_pair(result)}: {spans}{', ...' * (len(result) > MOST_NAMED)}", done) if x)
    where = "" if result.point is None else " at ({:.6g}, {:.6g}, {:.6g})".format(*result.point)
    met = ""
    if result.element_a is not None and result.element_b is not None:
        met = f"{_short(result.element_a)} meets {_short(result.element_b)}{where}"
    within = " within the deviation" if result.within_deviation else ""
    how = f"{result.initial} at the start{within}" if result.initial else done
    return "; ".join(x for x in (f"  {result.time:<12.9g} {_pair(result)}", how, met) if x)


def _short(element: Element) -> str:
    """Without the body's name, which stands before."""
    return f"{element.kind} {element.index}" if element.label == element.body else element.label


def _pair(result: FirstContact | ContactIntervals) -> str:
    return f"{result.a.name or 'a'} / {result.b.name or 'b'}"


def _count(n: int, one: str, many: str | None = None) -> str:
    return f"{n:,} {one if n == 1 else many or one + 's'}"
