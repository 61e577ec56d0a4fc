"""Closed windows of exact times; an end is None where it is infinite."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from firstcontact.exact.numbers import sign

if TYPE_CHECKING:
    from firstcontact.exact.ring import C

Window = tuple[Any, Any]
ALWAYS: Window = (None, None)


def clip(window: Window | None, other: Window) -> Window | None:
    """The common part of two windows."""
    if window is None:
        return None
    lo = _later(window[0], other[0])
    hi = _earlier(window[1], other[1])
    if lo is not None and hi is not None and lo is not hi and sign(hi - lo) < 0:
        return None  # (an instant is one object twice: no ball need tell its ends apart)
    return lo, hi


def hull(windows: list[Window | None]) -> Window | None:
    """The smallest window around all of them."""
    found = [w for w in windows if w is not None]
    if not found:
        return None
    lo, hi = found[0]
    for w in found[1:]:
        lo = None if lo is None or w[0] is None else lo if sign(lo - w[0]) <= 0 else w[0]
        hi = None if hi is None or w[1] is None else hi if sign(hi - w[1]) >= 0 else w[1]
    return lo, hi


def _later(x: C | None, y: C | None) -> C | None:
    if x is None or y is None:
        return y if x is None else x
    return x if sign(x - y) >= 0 else y


def _earlier(x: C | None, y: C | None) -> C | None:
    if x is None or y is None:
        return y if x is None else x
    return x if sign(x - y) <= 0 else y
