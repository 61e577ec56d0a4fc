"""The joints of the bodies on a page: their values over the time, and how each of them moves what hangs on it.

The page poses links by the product of their joints itself, so that joints can be moved there by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.exact.numbers import to_double
from firstcontact.motion.linkage import Drive, Linkage
from firstcontact.motion.relative.reach import line_of

if TYPE_CHECKING:
    from flint import fmpq

    from firstcontact.body.kinds import Body
    from firstcontact.result import Json

Encoded = Callable[[np.ndarray], str]


def linkage_of(body: Body) -> Linkage | None:
    """The motion of a link, of a body that moves as one."""
    motion = getattr(body, "motion", None)
    return motion if isinstance(motion, Linkage) else None


class PageJoints:
    """The joints of a page, each written once however many bodies hang on it.

    encode: how an array of doubles is written.
    """

    def __init__(self, encode: Encoded) -> None:
        self._encode = encode
        self._drives: list[tuple[Drive, int]] = []  # with the number of its clock
        self._clocks: list[tuple[fmpq, ...]] = []
        self._known: dict[tuple[int, int], tuple[int, Drive]] = {}  # by the ids of drives, which it keeps alive

    def chain(self, linkage: Linkage) -> list[int]:
        """The numbers of the joints of a link, from the root outward."""
        clock = next((k for k, times in enumerate(self._clocks) if times == linkage.times), len(self._clocks))
        if clock == len(self._clocks):
            self._clocks.append(linkage.times)
        return [self._index(drive, clock) for drive in linkage.drives]

    def _index(self, drive: Drive, clock: int) -> int:
        key = id(drive), clock
        if key not in self._known:
            if (drive, clock) not in self._drives:
                self._drives.append((drive, clock))
            self._known[key] = self._drives.index((drive, clock)), drive
        return self._known[key][0]

    def written(self) -> dict[str, Json]:
        """Clocks: times (n,).  Joints: axis, point, way in the world, and per stretch four coefficients."""
        clocks = [self._encode(np.array([to_double(t) for t in times])) for times in self._clocks]
        return {"clocks": clocks, "joints": [self._joint(drive, clock) for drive, clock in self._drives]}

    def _joint(self, drive: Drive, clock: int) -> dict[str, Json]:
        axis, point, angle, way = line_of(drive.motion)
        follows = self._followed(drive, clock)
        lo, hi = _range(drive)
        if follows is not None and drive.limits is None:  # as far as its leader takes it
            k, ratio, offset = follows
            lo, hi = sorted(ratio * x + offset for x in _range(self._drives[k][0]))
        return {
            "name": drive.name, "unit": drive.unit, "clock": clock, "values": self._encode(drive.doubles),
            "axis": axis.tolist(), "point": point.tolist(), "angle": angle, "way": way.tolist(),
            "least": lo, "most": hi, "limited": drive.limits is not None, "follows": follows,
        }  # fmt: skip

    def _followed(self, drive: Drive, clock: int) -> tuple[int, float, float] | None:
        """The number of the joint that leads it, ratio and offset; None where none of the page does."""
        if drive.mimic is None:
            return None
        leader, ratio, offset = drive.mimic
        for k, (other, beside) in enumerate(self._drives):
            if (other.name, beside) == (leader, clock) and other.mimic is None:
                return k, to_double(ratio), to_double(offset)
        return None


def _range(drive: Drive) -> tuple[float, float]:
    """What a joint's slider goes through: its limits, and beyond them as far as the course does.

    Without limits: a full turn about the course's middle where it turns, else the course and half as much on each side.
    """
    on_the_way = drive.doubles @ np.linspace(0, 1, 9) ** np.arange(4)[:, None]
    lo, hi = float(on_the_way.min()), float(on_the_way.max())
    if drive.limits is not None:
        least, most = map(to_double, drive.limits)
        return min(lo, least), max(hi, most)
    angle = line_of(drive.motion)[2]
    half = max(hi - lo, abs(np.pi / angle) if angle else 1.0)
    middle = 0.5 * (lo + hi)
    return middle - half, middle + half
