"""Results as tables, for what was written to be read again; exact numbers are the texts that results write."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import BeforeValidator, StrictBool, StrictInt, StrictStr

from firstcontact.result import (
    Absent,
    AlgebraicNumber,
    Asked,
    CandidateTime,
    ContactInterval,
    ContactIntervals,
    ContactPairs,
    ContactSet,
    Element,
    ElementPair,
    ExactAngle,
    FirstContact,
    JointValue,
    Stats,
    Status,
    Subproblem,
)
from firstcontact.result_curve import (
    Branch,
    BranchEnd,
    CurveGraph,
    ExactParameters,
    GraphNode,
    IntersectionCurve,
    OpenPlace,
    SingularPoint,
)
from firstcontact.scene.values import Table, list_of

if TYPE_CHECKING:
    from firstcontact.result import ExactTime, Json
    from firstcontact.result_curve import ExactParameter

_TERM = re.compile(r"([+-]?)(\d*)(x?)(?:\^(\d+))?")


def _double(value: Json) -> float:
    """A double; JSON has infinity as a text and nan as null."""
    if value is None:
        return math.nan
    if isinstance(value, str) and value in ("inf", "-inf"):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{value!r} is not a number; write 0.5")
    return float(value)


ReadExact: TypeAlias = "Fraction | AlgebraicNumber | tuple[ReadExact, ReadExact]"
"""(cosine, sine) of an angle."""


def _exact(text: Json) -> ReadExact:
    """A fraction, a root or an angle, as results write them: (cosine, sine) of an angle, whose time stands beside."""
    if not isinstance(text, str):
        raise ValueError(f"{text!r} is no exact number; write one as \"1/3\" or \"root of x^2 - 2 in [1, 2]\"")
    if text.startswith("angle with cosine "):
        cosine, _, sine = text.removeprefix("angle with cosine ").partition(", sine ")
        return _exact(cosine), _exact(sine)
    found = re.fullmatch(r"root of (.+) in \[(.+), (.+)\]", text)
    try:
        if found is None:
            return Fraction(text)
        number = AlgebraicNumber(_polynomial(found[1]), Fraction(found[2]), Fraction(found[3]))
    except (ValueError, ZeroDivisionError) as error:
        raise ValueError(f"{text!r} is no exact number ({error})") from error
    if number.written() != text:
        raise ValueError(f"{text!r} is no root of a polynomial; write one such as \"root of x^2 - 2 in [1, 2]\"")
    return number


def _polynomial(text: str) -> tuple[int, ...]:
    """Ascending coefficients of a text such as "2 x^2 - 1"."""
    powers: dict[int, int] = {}
    for sign, digits, x, power in _TERM.findall(text.replace(" ", "")):
        if digits or x:
            powers[int(power or 1) if x else 0] = int(f"{sign}{digits or 1}")
    return tuple(powers.get(k, 0) for k in range(max(powers, default=-1) + 1))


def _parameter(text: Json) -> ExactParameter | ReadExact | None:
    """An exact parameter, a double as a text, or None."""
    if text is None:
        return None
    if isinstance(text, str) and re.fullmatch(r"-?(inf|nan|\d+\.\d*(e[+-]?\d+)?|\d+e[+-]?\d+)", text):
        return float(text)
    return _exact(text)


def _time(
    exact: ExactTime | tuple[Fraction | AlgebraicNumber, Fraction | AlgebraicNumber] | None, time: float | None
) -> ExactTime | None:
    if not isinstance(exact, tuple):
        return exact
    cosine, sine = exact
    return ExactAngle(cosine, sine, 0.0 if time is None else time)


def _array(width: int) -> BeforeValidator:
    """Rows of that many doubles."""
    def read(value: Json) -> np.ndarray:
        if not isinstance(value, list) or any(not isinstance(row, list) or len(row) != width for row in value):
            raise ValueError(f"{value!r} is no list of rows of {width} numbers")
        return np.array([[_double(x) for x in row] for row in value]).reshape(-1, width)

    return BeforeValidator(read)


Double = Annotated[float, BeforeValidator(_double)]
Exact = Annotated[Any, BeforeValidator(_exact)]
Parameter = Annotated[Any, BeforeValidator(_parameter)]
Doubles = Annotated[tuple[Double, Double], list_of(2, "two numbers; write [lo, hi]")]
Triple = Annotated[tuple[Double, Double, Double], list_of(3, "three numbers; write [x, y, z]")]
Quadruple = Annotated[tuple[Double, Double, Double, Double], list_of(4, "four numbers; write [u, v, s, t]")]
Triples = Annotated[Any, _array(3)]
Quadruples = Annotated[Any, _array(4)]
Term = Annotated[tuple[StrictInt, StrictInt, Exact], list_of(3, "a term; write [i, j, \"coefficient\"]")]


class WayTable(Table):
    way: StrictStr
    told: StrictStr
    seconds: Double


class StatsTable(Table):
    node_visits: StrictInt = 0
    pair_tests: StrictInt = 0
    undecided: StrictInt = 0
    exact_evaluations: StrictInt = 0
    seconds: Double = 0.0
    engine: StrictStr = ""
    ways: list[WayTable] = []

    def build(self) -> Stats:
        ways = tuple(Asked(x.way, x.told, x.seconds) for x in self.ways)
        return Stats(**{**{key: getattr(self, key) for key in StatsTable.model_fields}, "ways": ways})


class ElementTable(Table):
    kind: StrictStr
    body: StrictStr
    index: StrictInt
    label: StrictStr

    def build(self) -> Element:
        return Element(self.kind, self.body, self.index, self.label)


ElementPairTable = Annotated[tuple[ElementTable, ElementTable], list_of(2, "two elements; write [{...}, {...}]")]


def _pairs(tables: list[tuple[ElementTable, ElementTable]]) -> tuple[ElementPair, ...]:
    return tuple(ElementPair(a.build(), b.build()) for a, b in tables)


class CandidateTable(Table):
    time: Double
    multiplicity: StrictInt
    point: Triple | None
    verdict: StrictStr
    reason: StrictStr

    def build(self) -> CandidateTime:
        return CandidateTime(self.time, self.multiplicity, _point(self.point), self.verdict, self.reason)


class SubproblemTable(Table):
    element_a: ElementTable
    element_b: ElementTable
    case: StrictStr
    candidates: list[CandidateTable]
    reason: StrictStr = ""

    def build(self) -> Subproblem:
        candidates = tuple(x.build() for x in self.candidates)
        return Subproblem(self.element_a.build(), self.element_b.build(), self.case, candidates, self.reason)


class _AnswerTable(Table):
    stats: StatsTable = StatsTable()


class _TimesTable(_AnswerTable):
    a: StrictStr
    b: StrictStr
    status: Literal["FREE", "CONTACT", "INITIAL_CONTACT", "UNDECIDED"]
    span: Doubles
    free_until: Double | None = None
    reason: StrictStr | None = None
    model_deviation: Double | None = None
    unit: StrictStr | None = None

    def _shared(self) -> dict[str, Any]:
        return {
            "a": Absent(self.a),
            "b": Absent(self.b),
            "status": Status[self.status],
            "span": self.span,
            "free_until": self.free_until,
            "reason": self.reason,
            "model_deviation": self.model_deviation,
            "unit": self.unit,
            "stats": self.stats.build(),
        }


class JointValueTable(Table):
    name: StrictStr
    value: Double
    interval: Doubles
    unit: StrictStr = ""

    def build(self) -> JointValue:
        return JointValue(self.name, self.value, self.interval, self.unit)


class FirstTable(_TimesTable):
    time: Double | None = None
    time_interval: Doubles | None = None
    time_exact: Exact | None = None
    point: Triple | None = None
    normal: Triple | None = None
    element_a: ElementTable | None = None
    element_b: ElementTable | None = None
    others: list[ElementPairTable] = []
    multiplicity: StrictInt = 0
    initial: StrictStr | None = None
    contact_set: StrictStr | None = None
    contact_points: Triples | None = None
    allowed: StrictStr | None = None
    within_deviation: StrictBool | None = None
    subproblems: list[SubproblemTable] = []
    joints: list[JointValueTable] = []

    def build(self) -> FirstContact:
        kind, points = self.contact_set, self.contact_points
        return FirstContact(
            **self._shared(),
            time=self.time,
            time_interval=self.time_interval,
            time_exact=_time(self.time_exact, self.time),
            point=_point(self.point),
            normal=_point(self.normal),
            element_a=None if self.element_a is None else self.element_a.build(),
            element_b=None if self.element_b is None else self.element_b.build(),
            others=_pairs(self.others),
            multiplicity=self.multiplicity,
            initial=self.initial,
            contact_set=kind if kind is None or points is None else ContactSet(kind, points),
            subproblems=tuple(x.build() for x in self.subproblems),
            allowed=self.allowed,
            within_deviation=self.within_deviation,
            joints=tuple(x.build() for x in self.joints),
        )


class IntervalTable(Table):
    start: Double
    end: Double
    start_interval: Doubles
    end_interval: Doubles
    start_exact: Exact | None = None
    end_exact: Exact | None = None

    def build(self) -> ContactInterval:
        exact = _time(self.start_exact, self.start), _time(self.end_exact, self.end)
        return ContactInterval(self.start, self.end, self.start_interval, self.end_interval, *exact)


class IntervalsTable(_TimesTable):
    intervals: list[IntervalTable]

    def build(self) -> ContactIntervals:
        return ContactIntervals(tuple(x.build() for x in self.intervals), **self._shared())


class PairsTable(_AnswerTable):
    pairs: list[ElementPairTable]
    piercing: list[ElementPairTable] = []
    undecided: list[ElementPairTable] = []

    def build(self) -> ContactPairs:
        return ContactPairs(_pairs(self.pairs), _pairs(self.piercing), _pairs(self.undecided), self.stats.build())


class EndTable(Table):
    kind: StrictStr
    on: list[StrictStr]
    point: Triple
    parameters: Quadruple
    u: Parameter = None
    v: Parameter = None

    def build(self) -> BranchEnd:
        exact = None if self.u is None and self.v is None else _known(self.u, self.v)
        return BranchEnd(self.kind, tuple(self.on), np.array(self.point), np.array(self.parameters), exact)


class BranchTable(Table):
    points: Triples
    parameters: Quadruples
    closed: StrictBool
    length: Double = 0.0
    """Follows from the points."""
    ends: list[EndTable]
    multiplicity: StrictInt = 1

    def build(self) -> Branch:
        ends = tuple(x.build() for x in self.ends)
        return Branch(self.points, self.parameters, self.closed, ends, self.multiplicity)


class SingularTable(Table):
    point: Triple
    kind: StrictStr


class NodeTable(Table):
    u: Parameter
    v: Parameter
    kind: StrictStr
    point: Triple | None


class GraphTable(Table):
    nodes: list[NodeTable]
    edges: list[Annotated[tuple[StrictInt, StrictInt], list_of(2, "two numbers of nodes; write [i, j]")]]
    components: StrictInt = 0
    """Follows from the edges."""

    def build(self) -> CurveGraph:
        nodes = tuple(GraphNode(_point(x.point), x.kind, _known(x.u, x.v)) for x in self.nodes)
        return CurveGraph(nodes, tuple(self.edges))


class PlaceTable(Table):
    point: Triple
    u: Doubles
    v: Doubles
    ends: StrictInt


class IntersectionCurveTable(_AnswerTable):
    a: StrictStr
    b: StrictStr
    branches: list[BranchTable]
    overlap_lines: list[Triples]
    singular_points: list[SingularTable]
    isolated_points: Triples
    two_dimensional: StrictBool
    graph: GraphTable
    delta: list[Term]
    common_rulings: list[Annotated[tuple[Parameter, Parameter], list_of(2, "two parameters; write [u, v]")]]
    correspondence: list[Term] = []
    method: StrictStr = "exact"
    open_places: list[PlaceTable] = []
    box: Triples | None = None

    def build(self) -> IntersectionCurve:
        return IntersectionCurve(
            branches=tuple(x.build() for x in self.branches),
            overlap_lines=np.array(self.overlap_lines, float).reshape(-1, 2, 3),
            singular_points=tuple(SingularPoint(np.array(x.point), x.kind) for x in self.singular_points),
            isolated_points=self.isolated_points,
            two_dimensional=self.two_dimensional,
            graph=self.graph.build(),
            delta={(i, j): int(c) for i, j, c in self.delta},
            common_rulings=tuple(self.common_rulings),
            correspondence={(i, j): int(c) for i, j, c in self.correspondence},
            method=self.method,
            open_places=tuple(OpenPlace(np.array(x.point), x.u, x.v, x.ends) for x in self.open_places),
            box=self.box,
            stats=self.stats.build(),
            a=Absent(self.a),
            b=Absent(self.b),
        )


def _known(u: ExactParameter | None, v: ExactParameter | None) -> ExactParameters:
    return ExactParameters(lambda: (u, v))


def _point(values: Sequence[float] | None) -> np.ndarray | None:
    return None if values is None else np.array(values, float)
