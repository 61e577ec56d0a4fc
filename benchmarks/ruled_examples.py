"""The examples of Chen, Shen & Yuan 2011: times and memory of this process, as JSON on stdout."""

from __future__ import annotations

import json
import resource
import statistics
import time
from collections.abc import Callable
from typing import Any

import firstcontact as fc

REPEATS = 9
CONE = "(1-u**2)/(1+u**2), 2*u/(1+u**2)"
Pair = tuple[Any, Any]


def whole(first: str, second: str) -> Any:
    return fc.RuledSurface(first, second, u=None, s=None)


def example_1() -> Pair:
    """A cone and a one-sheeted surface."""
    return (
        whole(f"({CONE}, 1)", "(2*(1-u**2)/(1+u**2), 4*u/(1+u**2), 2)"),
        whole(f"({CONE}, 1)", "((1-u**2)/(1+u**2), (1+u)**2/(1+u**2), 2)"),
    )


def example_2() -> Pair:
    """Two equal cylinders with parallel axes."""
    other = "-2*u**2/(1+u**2), 2*u/(1+u**2)"
    return whole(f"({CONE}, 0)", f"({CONE}, 1)"), whole(f"({other}, 0)", f"({other}, 1)")


def example_3() -> Pair:
    """A cone and a surface of degree 4."""
    quartic = "u**4 - 6*u**3 + 11*u**2"
    return (
        whole(f"(1, {CONE})", "(2, 61*(1-u**2)/(60*(1+u**2)), 61*u/(30*(1+u**2)))"),
        whole(f"(u, {quartic} - 6*u, 0)", f"(9*u/10, {quartic} - 7*u, 1)"),
    )


def example_4(u: tuple[int, int] | None = None) -> Pair:
    """A roller that shrinks and sinks, and a pipe at rest."""
    rim = "(1 - T - (1+T)*u**2)/(1+u**2), 2*u/(1+u**2) - T**2"
    circle = "-2*u**2/(1+u**2), 2*u/(1+u**2)"
    return (
        fc.RuledSurface(f"(-1, {rim})", f"(0, {rim})", u=u),
        fc.RuledSurface(f"({circle}, 1/2)", f"({circle}, 3/2)", u=u),
    )


def example_5() -> Pair:
    """Those of Example 4 at the time 0."""
    p, q = example_4()
    return p.at(0), q


def curve(p: Any, q: Any) -> Any:
    return fc.intersection_curve(p, q, method="algebraic")


def certified_curve(p: Any, q: Any) -> Any:
    return fc.intersection_curve(p, q, method="certified")


def intervals(p: Any, q: Any) -> Any:
    return fc.contact_intervals(p, q, (-2, 2), exact=True)


def exact_contact(p: Any, q: Any) -> Any:
    return fc.first_contact(p, q, (-2, 2), exact=True)


def certified_contact(p: Any, q: Any) -> Any:
    return fc.first_contact(p, q, (-2, 2), method="certified")


# what is asked, of which surfaces, and the time in ms that it may take, if there is a bar
QUERIES: list[tuple[str, Callable[[], Pair], Callable[[Any, Any], Any], float | None]] = [
    ("Example 1, curve, exact", example_1, curve, 20),
    ("Example 2, curve, exact", example_2, curve, 20),
    ("Example 3, curve, exact", example_3, curve, 80),
    ("Example 5, curve, exact", example_5, curve, 20),
    ("Example 1, curve, certified", example_1, certified_curve, None),
    ("Example 2, curve, certified", example_2, certified_curve, None),
    ("Example 3, curve, certified", example_3, certified_curve, None),
    ("Example 5, curve, certified", example_5, certified_curve, None),
    ("Example 4, intervals, exact", example_4, intervals, 50),
    ("Example 4, first contact, exact", example_4, exact_contact, 50),
    ("Example 4, first contact, certified", example_4, certified_contact, 5),
    ("Example 4 with u, v in [-3, 3], intervals, exact", lambda: example_4((-3, 3)), intervals, 300),
    ("Example 4 with u, v in [-3, 3], first contact, certified", lambda: example_4((-3, 3)), certified_contact, 5),
]


def said(answer: Any) -> str:
    """An answer in a few words."""
    if isinstance(answer, fc.IntersectionCurve):
        counts = len(answer.branches), len(answer.isolated_points), len(answer.overlap_lines)
        asked = f"; asked exactly: {answer.stats.exact_evaluations}" if answer.method == "certified" else ""
        return "branches {}, isolated points {}, common lines {}".format(*counts) + asked
    if isinstance(answer, fc.ContactIntervals):
        return ", ".join(f"[{x.start_exact}, {x.end_exact}]" for x in answer.intervals)
    return str(answer.time_exact) if answer.time_exact is not None else repr(answer.time)


def main() -> None:
    rows = []
    for name, make, ask, bar in QUERIES:
        answer, times = ask(*make()), []
        for _ in range(REPEATS):
            pair = make()
            begin = time.perf_counter()
            ask(*pair)
            times.append(time.perf_counter() - begin)
        rows.append({"name": name, "ms": 1e3 * statistics.median(times), "bar": bar, "answer": said(answer)})
    print(json.dumps({"rows": rows, "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))


if __name__ == "__main__":
    main()
