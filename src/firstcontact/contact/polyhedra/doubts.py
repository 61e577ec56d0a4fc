"""Times in which it is left open whether two elements meet, and what is left of them beside certain contact.

A doubt inside a time in which the bodies certainly meet changes nothing; one at its end is a part of what encloses that
end.  One between two contacts makes them one, if it is so short that times are not told apart in it: where a corner
passes a face, what touches before and what touches after it do at one time, which enclosures cannot tell.  A doubt by
itself leaves the answer open, and so does a long one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flint import arb, fmpq

from firstcontact.exact.numbers import dyadic
from firstcontact.exact.times.instants import RationalInstant

# The widest doubt that may enclose an end, or join two contacts, as a share of the piece.
WIDEST = fmpq(1, 10**12)


@dataclass(frozen=True, slots=True)
class Doubt:
    """The closed time [lo, hi]; is_contact: there certainly is a contact in it."""

    lo: fmpq
    hi: fmpq
    is_contact: bool

    def is_wide(self, length: fmpq) -> bool:
        """Whether it is too wide to enclose an end."""
        return bool(self.hi - self.lo > WIDEST * length)


@dataclass(slots=True)
class Certain:
    """A time of contact: from somewhere in [start, begun] until somewhere in [ending, end]."""

    start: fmpq
    begun: fmpq
    ending: fmpq
    end: fmpq


def merged(doubts: list[Doubt]) -> list[Doubt]:
    """The doubts as disjoint ones, ascending."""
    out: list[Doubt] = []
    for doubt in sorted(doubts, key=lambda d: (d.lo, d.hi)):
        if out and doubt.lo <= out[-1].hi:
            last = out[-1]
            out[-1] = Doubt(last.lo, max(last.hi, doubt.hi), last.is_contact or doubt.is_contact)
        else:
            out.append(doubt)
    return out


def settled(
    windows: list[tuple[Any, Any]], doubts: list[Doubt], length: fmpq
) -> tuple[list[tuple[RationalInstant, RationalInstant]], fmpq | None]:
    """(disjoint windows of contact, ascending; the time from which on it is open what else there is, or None)."""
    found = _united([_certain(*window, length) for window in windows])
    for doubt in merged([*doubts, *_gaps(found)]):
        if any(w.begun <= doubt.lo and doubt.hi <= w.ending for w in found):
            continue
        beside = [w for w in found if w.start <= doubt.hi and doubt.lo <= w.end]
        if doubt.is_wide(length) or not (beside or doubt.is_contact):
            return [_window(w) for w in _until(found, doubt.lo)], doubt.lo
        if beside:
            w = _joined(beside)
            w.start, w.end = min(w.start, doubt.lo), max(w.end, doubt.hi)
            found = [*(x for x in found if not any(x is y for y in beside)), w]
            continue
        found.append(Certain(doubt.lo, doubt.hi, doubt.lo, doubt.hi))
    return [_window(w) for w in sorted(found, key=lambda w: w.start)], None


def _certain(start: RationalInstant, end: RationalInstant, length: fmpq) -> Certain:
    return Certain(*_ends(start.value, length), *_ends(end.value, length))


def _ends(value: fmpq | arb, length: fmpq) -> tuple[fmpq, fmpq]:
    if isinstance(value, fmpq):
        return value, value
    return max(dyadic(value.lower()), fmpq(0)), min(dyadic(value.upper()), length)


def _united(windows: list[Certain]) -> list[Certain]:
    """Those that certainly share a time as one."""
    out: list[Certain] = []
    for w in sorted(windows, key=lambda w: w.begun):
        if out and w.begun <= out[-1].ending:
            last = out[-1]
            last.start = min(last.start, w.start)
            last.ending, last.end = max(last.ending, w.ending), max(last.end, w.end)
        else:
            out.append(w)
    return out


def _joined(windows: list[Certain]) -> Certain:
    """From the start of the first until the end of the last."""
    first, last = min(windows, key=lambda w: w.begun), max(windows, key=lambda w: w.ending)
    return Certain(first.start, first.begun, last.ending, last.end)


def _gaps(windows: list[Certain]) -> list[Doubt]:
    """The times between two windows of which it is not known that they share none."""
    return [
        Doubt(x.ending, y.begun, False) for k, x in enumerate(windows) for y in windows[k + 1 :] if x.end >= y.start
    ]


def _until(windows: list[Certain], time: fmpq) -> list[Certain]:
    """What of the windows is before the time, which none of them is open at."""
    out = []
    for w in sorted(windows, key=lambda w: w.start):
        if w.begun <= time and w.ending <= w.end <= time:
            out.append(w)
        elif w.begun <= time:
            out.append(Certain(w.start, w.begun, min(w.ending, time), min(w.end, time)))
    return out


def _window(w: Certain) -> tuple[RationalInstant, RationalInstant]:
    start, end = (RationalInstant(_instant(*ends)) for ends in ((w.start, w.begun), (w.ending, w.end)))
    return (start, start) if (w.start, w.begun) == (w.ending, w.end) else (start, end)


def _instant(lo: fmpq, hi: fmpq) -> fmpq | arb:
    return lo if lo == hi else arb(lo).union(arb(hi))
