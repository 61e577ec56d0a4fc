"""Joint values over the time: from numbers at given times to a polynomial of each stretch between them."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from flint import fmpq

from firstcontact.errors import InputError, shown
from firstcontact.exact.numbers import exact_value, to_double
from firstcontact.motion.product import Value
from firstcontact.motion.translation import LARGEST, bounded

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Given

INTERPOLATIONS = "linear", "cubic"
JointValues: TypeAlias = "Mapping[str, Given | Iterable[Given]]"
"""By the joints' names: one value that stays, or one for each time."""


def read_times(values: Iterable[Given]) -> tuple[fmpq, ...]:
    """Ascending exact times, two or more, of numbers that doubles hold with their quotients."""
    times = tuple(bounded(t, f"times[{k}]") for k, t in enumerate(_listed(values, "times")))
    if len(times) < 2:
        raise InputError(f"{len(times)} times are given; give at least two")
    for k, (early, late) in enumerate(itertools.pairwise(times)):
        if not early < late:
            raise InputError(f"times[{k + 1}] does not lie after times[{k}]; give ascending times")
        if late - early < 1 / LARGEST:
            raise InputError(f"times[{k + 1}] lies less than 2^-150 after times[{k}]; give times farther apart")
    return times


def polynomials(
    name: str, times: tuple[fmpq, ...], values: Any, interpolation: str, velocities: Any = None
) -> tuple[Value, ...]:
    """For each stretch the value as a polynomial of the share of it that has passed.

    values: one number that stays, or one for each time.  "cubic": with the given velocities at the times, or else with
    those of the natural cubic spline.
    """
    if interpolation not in INTERPOLATIONS:
        raise InputError(f"interpolation {shown(interpolation)} is unknown; give one of {', '.join(INTERPOLATIONS)}")
    if isinstance(values, str) or not hasattr(values, "__len__"):
        return ((bounded(values, f"the value of joint {name!r}"),),) * (len(times) - 1)
    points = _exact(name, "values", values, times)
    if interpolation == "linear":
        return tuple(_trimmed((p, q - p)) for p, q in itertools.pairwise(points))
    slopes = _natural(times, points) if velocities is None else _exact(name, "velocities", velocities, times)
    return tuple(
        _cubic(t1 - t0, p, q, u, v)
        for (t0, t1), (p, q), (u, v) in zip(*map(itertools.pairwise, (times, points, slopes)), strict=True)
    )


def _exact(name: str, what: str, values: Iterable[Given], times: tuple[fmpq, ...]) -> list[fmpq]:
    numbers = _listed(values, f"{what} of joint {name!r}")
    if len(numbers) != len(times):
        raise InputError(f"joint {name!r} has {len(numbers)} {what} but {len(times)} times; give one for each")
    return [bounded(x, f"{what}[{k}] of joint {name!r}") for k, x in enumerate(numbers)]


def _cubic(length: fmpq, p: fmpq, q: fmpq, u: fmpq, v: fmpq) -> Value:
    """From p with velocity u to q with velocity v (Hermite)."""
    way, u, v = q - p, u * length, v * length
    return _trimmed((p, u, 3 * way - 2 * u - v, u + v - 2 * way))


def _trimmed(value: Value) -> Value:
    """Without zeros at the end, but for the constant."""
    count = max((k + 1 for k, c in enumerate(value) if c), default=1)
    return value[:count]


def _natural(times: tuple[fmpq, ...], points: list[fmpq]) -> list[fmpq]:
    """Velocities of the natural cubic spline, rounded to doubles: it passes exactly through the points, and smoothly.

    They solve a tridiagonal system, from which the elimination has no need to choose pivots.
    """
    lengths = [to_double(t1 - t0) for t0, t1 in itertools.pairwise(times)]
    rates = [to_double(q - p) / h for (p, q), h in zip(itertools.pairwise(points), lengths, strict=True)]
    n = len(points)
    above, right = [0.0] * n, [0.0] * n
    for k in range(n):
        left_share = 1.0 / lengths[k - 1] if k else 0.0
        right_share = 1.0 / lengths[k] if k < n - 1 else 0.0
        whole = 2.0 * (left_share + right_share)
        value = 3.0 * ((left_share * rates[k - 1] if k else 0.0) + (right_share * rates[k] if k < n - 1 else 0.0))
        pivot = whole - left_share * (above[k - 1] if k else 0.0)
        above[k] = right_share / pivot
        right[k] = (value - left_share * (right[k - 1] if k else 0.0)) / pivot
    for k in range(n - 2, -1, -1):
        right[k] -= above[k] * right[k + 1]
    return [exact_value(x) for x in right]


def _listed(values: Iterable[Given], what: str) -> list[Given]:
    try:
        return list(values)
    except TypeError as error:
        raise InputError(f"{what} are {shown(values)}; give a list") from error


def followed(leader: tuple[Value, ...], ratio: fmpq, offset: fmpq) -> tuple[Value, ...]:
    """The values of a joint that mimics another one."""
    return tuple(_trimmed((ratio * value[0] + offset, *(ratio * c for c in value[1:]))) for value in leader)


def known(names: Iterable[str], wanted: Mapping[str, object], what: str) -> None:
    """InputError for values of what is no joint that takes one."""
    if not isinstance(wanted, Mapping):
        raise InputError(f"{what}: {shown(wanted)} is no dict; give values by the joints' names")
    free = list(names)
    for name in wanted:
        if name not in free:
            raise InputError(f"{what}: no joint {name!r} takes a value; {', '.join(map(repr, free)) or 'none'} do")
