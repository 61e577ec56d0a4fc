"""What the verbs answer: small immutable records.

A result never converts to bool: write ``hit.status is Status.FREE``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from enum import Enum
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any, Self, TypeAlias, TypedDict, TypeVar, overload

import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import ArrayLike

    from firstcontact.body.kinds import Body
    from firstcontact.view.html import NotebookFrame

TOLD_CORRECTION = 1e-9
"""Of rounded poses: from that on the text of an answer tells it."""
MOST_OTHERS = 100
"""Further pairs of elements that a result lists."""
LONGEST = 80
"""Letters of an exact number that a text for readers shows; longer ones are described."""
SCHEMA = 1
"""Of what `to_dict` gives; `from_dict` refuses others."""


class Status(Enum):
    """How a query ended; the value says what is proved and what to do next."""

    FREE = "no shared point in the span; proved"
    CONTACT = "first shared point found; time_interval encloses its time"
    INITIAL_CONTACT = "shared points at the start of the span; ask for contact_intervals"
    UNDECIDED = "free_until is proved; raise the budget, shorten the span or see reason"

    def __bool__(self) -> bool:
        raise TypeError("a Status has no truth value; write `status is Status.FREE`")


class _NoTruth:
    __slots__ = ()

    def __bool__(self) -> bool:
        raise TypeError(f"a {type(self).__name__} has no truth value; look at .status")


# What files hold, and a table of them.
Json: TypeAlias = "str | int | float | bool | Sequence[Json] | Mapping[str, Json] | None"
Table: TypeAlias = "dict[str, Json]"


class Written:
    """What `to_dict` writes and `from_dict` reads: one schema, in which exact numbers are texts."""

    __slots__ = ()

    def to_dict(self) -> Table:
        """Lists, texts and numbers alone; doubles are doubles, other exact numbers are texts such as "1/3"."""
        raise NotImplementedError

    def to_json(self) -> str:
        return json.dumps(finite(self.to_dict()))

    @classmethod
    def from_dict(cls, data: Mapping[str, Json]) -> Self:
        """What `to_dict` wrote.  Raises InputError that names what it does not know."""
        from firstcontact import InputError, from_dict

        made = from_dict(data)
        if not isinstance(made, cls):
            raise InputError(f"this is a {type(made).__name__}, no {cls.__name__}; read it by firstcontact.from_dict")
        return made

    @classmethod
    def from_json(cls, text: str) -> Self:
        """What `to_json` wrote."""
        from firstcontact import InputError

        try:
            data = json.loads(text)
        except (TypeError, ValueError, RecursionError) as error:
            raise InputError(f"this is no JSON: {error}") from error
        return cls.from_dict(data)


@dataclass(frozen=True, slots=True)
class Absent:
    """Stands in a result that was pickled, or read, for a body that did not come along."""

    name: str | None
    correction: float = 0.0
    """Of its motion: see `RationalMotion.correction`."""


class Answer(Written):
    """A result: what it says is its value; bodies count by their names, `stats` not at all.

    Pickles leave the bodies out, unless they are those of `with_bodies()`.
    """

    __slots__ = ()

    def with_bodies(self) -> Self:
        """The same result, which takes its bodies along into pickles."""
        return replace(self, keeps_bodies=True)  # type: ignore[type-var]

    def __reduce__(self) -> tuple[object, ...]:
        record: Any = self
        values = {f.name: getattr(record, f.name) for f in fields(record)}
        if not values.get("keeps_bodies", True):
            values |= {key: _absent(values[key]) for key in ("a", "b")}
        return _restored, (type(self), values)

    def __copy__(self) -> Self:
        return self  # it does not change

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        return self

    def _said(self) -> Table:
        said: dict[str, Any] = finite(self.to_dict())
        return {key: value for key, value in said.items() if key != "stats"}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        return self is other or self._said() == other._said()

    def __hash__(self) -> int:
        said = self._said()
        return hash((type(self), *(str(said.get(key)) for key in ("a", "b", "status", "time"))))

    def _repr_html_(self) -> str:
        """A small picture and the text, for notebooks."""
        from firstcontact.view.html import cell

        return cell(self)


class Shown(Answer):
    """A result about two bodies, of which there is a page."""

    __slots__ = ()

    def show(self, path: str | None = None) -> Path | NotebookFrame:
        """Write the page that shows this result; without a path show it in the notebook, or in the browser."""
        from firstcontact.view.html import show_page

        shown: Any = self
        return show_page(path, [shown])


T = TypeVar("T")


def _restored(cls: Callable[..., T], values: dict[str, object]) -> T:
    return cls(**values)


def _absent(body: Body) -> Body | Absent | None:
    return body if body is None or isinstance(body, Absent) else Absent(_name(body, "") or None, _correction(body))


class _Deferring(_NoTruth):
    """A frozen record of which some fields may be worked out when one of them is first read."""

    __slots__ = ("_rest",)
    _rest: Callable[[], dict[str, Any]]

    @classmethod
    def deferring(cls, known: dict[str, object], rest: Callable[[], dict[str, object]], later: str = "") -> Self:
        """The record with the fields `known`; `rest` gives all others, or some and, as "_rest", what gives the rest.

        Of what is seldom told, None where it is not known, the field `later` alone is left to `rest`.
        """
        record, put = object.__new__(cls), _setters(cls)  # type: ignore[arg-type]
        put["_rest"](record, rest)
        put["keeps_bodies"](record, False)
        for name in ("allowed", "model_deviation", "unit", "within_deviation"):
            if name != later:
                put[name](record, None)
        put["joints"](record, ())
        for name, value in known.items():
            put[name](record, value)
        return record

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:  # asked for fields that are not set
            if name not in self.__dataclass_fields__:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            put = _setters(type(self))
            found = self._rest()
            for field_name, value in found.items():
                put[field_name](self, value)
            return getattr(self, name) if "_rest" in found else object.__getattribute__(self, name)


@cache
def _setters(cls: Any) -> dict[str, Callable[[Any, Any], None]]:
    """How the slots of a frozen record are filled, in half the time that `object.__setattr__` takes."""
    return {name: getattr(cls, name).__set__ for name in ("_rest", *cls.__dataclass_fields__)}


_TOLD_OF_FREE = "status", "free_until", "stats", "a", "b", "span"


@cache
def _unsaid() -> dict[str, object]:
    """The fields of a FirstContact that say nothing where it is FREE."""
    return {f.name: f.default for f in fields(FirstContact) if f.name not in _TOLD_OF_FREE}


@dataclass(frozen=True, slots=True)
class Asked:
    """A way to an answer that was asked: what it told (a status, or why it passed the question on), and its time."""

    way: str
    told: str
    seconds: float


@dataclass(frozen=True, slots=True)
class Stats(Mapping[str, "float | str | tuple[Asked, ...]"]):
    """Work done by one query; readable as attributes and as a mapping."""

    node_visits: int = 0
    pair_tests: int = 0
    undecided: int = 0
    """Pair tests the floats could not decide."""
    exact_evaluations: int = 0
    seconds: float = 0.0
    engine: str = ""
    """Of polyhedra: which engine answered (the last one, where there were several pieces of motion)."""
    ways: tuple[Asked, ...] = ()
    """The ways to an answer that were asked, in order."""

    def note(self, ways: tuple[Asked, ...]) -> None:
        """Fills `ways`, before the stats are given away."""
        object.__setattr__(self, "ways", ways)

    def note_time(self, seconds: float) -> None:
        """The same of `seconds`."""
        object.__setattr__(self, "seconds", seconds)

    def __getitem__(self, key: str) -> float | str | tuple[Asked, ...]:
        if key not in list(self):
            raise KeyError(key)
        value: float | str | tuple[Asked, ...] = getattr(self, key)
        return value

    def __iter__(self) -> Iterator[str]:
        return (f.name for f in fields(self))

    def __len__(self) -> int:
        return len(fields(self))

    def to_dict(self) -> Table:
        return {**asdict(self), "ways": [asdict(way) for way in self.ways]}

    def __add__(self, other: Stats) -> Stats:
        return Stats(
            self.node_visits + other.node_visits,
            self.pair_tests + other.pair_tests,
            self.undecided + other.undecided,
            self.exact_evaluations + other.exact_evaluations,
            self.seconds + other.seconds,
            other.engine or self.engine,
            self.ways + other.ways,
        )


@dataclass(frozen=True, slots=True, order=True)
class Element:
    """One element of a body: ``kind`` is "vertex", "edge" or "face"; ``index`` counts within the body."""

    kind: str
    body: str
    index: int
    label: str

    def __str__(self) -> str:
        return f"{self.label} {self.kind} {self.index}"

    def to_dict(self) -> Table:
        return {"kind": self.kind, "body": self.body, "index": self.index, "label": self.label}


@dataclass(frozen=True, slots=True)
class AlgebraicNumber:
    """The only root of ``polynomial`` (integers, ascending) in the closed interval [lo, hi]."""

    polynomial: tuple[int, ...]
    lo: Fraction
    hi: Fraction

    def __float__(self) -> float:
        """The double nearest the root."""
        lo, hi = self.lo, self.hi
        sign_lo = self._sign(lo)
        if sign_lo == 0:
            return float(lo)
        while float(lo) != float(hi):
            mid = (lo + hi) / 2
            sign = self._sign(mid)
            if sign == 0:
                return float(mid)
            lo, hi = (mid, hi) if sign == sign_lo else (lo, mid)
        return float(lo)

    def _sign(self, x: Fraction) -> int:
        value = Fraction(0)
        for coefficient in reversed(self.polynomial):
            value = value * x + coefficient
        return (value > 0) - (value < 0)

    @property
    def closed_form(self) -> str | None:
        """The number by square roots, such as "(1 + sqrt(5))/2"; None beyond degree 2.

        >>> AlgebraicNumber((-1, 0, 2), Fraction(-1), Fraction(0)).closed_form
        '-sqrt(2)/2'
        """
        if len(self.polynomial) != 3:
            return None
        c, b, a = self.polynomial
        upper = self._sign(Fraction(-b, 2 * a)) and Fraction(float(self)) * 2 * a > -b
        p, q, way = (-b, 2 * a, 1 if upper else -1) if a > 0 else (b, -2 * a, -1 if upper else 1)
        inside, outside, k = b * b - 4 * a * c, 1, 2
        while k * k <= inside and k < 1000:
            while inside % (k * k) == 0:
                inside, outside = inside // (k * k), outside * k
            k += 1
        common = math.gcd(p, q, outside)
        p, q, outside = p // common, q // common, outside // common
        root = f"sqrt({inside})" if outside == 1 else f"{outside}*sqrt({inside})"
        above = f"{p} {'+' if way > 0 else '-'} {root}" if p else root if way > 0 else f"-{root}"
        return above if q == 1 else f"({above})/{q}" if p else f"{above}/{q}"

    def written(self) -> str:
        """All of it, as JSON has it; `str` shortens what is long.

        >>> AlgebraicNumber((-1, 0, 2), Fraction(1, 2), Fraction(1)).written()
        'root of 2 x^2 - 1 in [1/2, 1]'
        """
        return f"root of {polynomial_text(self.polynomial)} in [{self.lo}, {self.hi}]"

    def __str__(self) -> str:
        text = polynomial_text(self.polynomial)
        if len(text) > LONGEST:
            digits = max(len(str(abs(c))) for c in self.polynomial)
            text = f"a polynomial of degree {len(self.polynomial) - 1}, coefficients of up to {digits} digits,"
        window = f"in [{self.lo}, {self.hi}]"
        return f"root of {text} {window if len(window) <= LONGEST else f'near {float(self)!r}'}"


@dataclass(frozen=True, slots=True)
class ExactAngle:
    """A contact time under rotation: the angle with this cosine and sine, in [0, 2 pi), as a time.

    ``float()`` is the time (a parameter of the motion), correctly rounded.
    """

    cosine: AlgebraicNumber | Fraction
    sine: AlgebraicNumber | Fraction
    time: float

    def __float__(self) -> float:
        return self.time

    def written(self) -> str:
        """All of it, as JSON has it."""
        return f"angle with cosine {written(self.cosine)}, sine {written(self.sine)}"

    def __str__(self) -> str:
        return f"angle with cosine {_told(self.cosine)}, sine {_told(self.sine)}"


ExactTime = Fraction | AlgebraicNumber | ExactAngle


@dataclass(frozen=True, slots=True)
class JointValue:
    """Where a joint of a mechanism stands at a time of contact: its value, and an interval that encloses the true one.

    >>> print(JointValue("hinge", 30.0, (29.999, 30.001), "deg"))
    hinge = 30 deg
    """

    name: str
    value: float
    interval: tuple[float, float]
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.12g}{' ' if self.unit else ''}{self.unit}"

    def to_dict(self) -> Table:
        return {"name": self.name, "value": self.value, "interval": list(self.interval), "unit": self.unit}


def polynomial_text(coefficients: Sequence[int]) -> str:
    """Integers, ascending, as people write a polynomial in x.

    >>> polynomial_text((-1, 0, 2)), polynomial_text((0, 1, -1)), polynomial_text((5,))
    ('2 x^2 - 1', '-x^2 + x', '5')
    """
    text = ""
    for power, c in reversed(list(enumerate(coefficients))):
        if c:
            sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
            x = "" if power == 0 else "x" if power == 1 else f"x^{power}"
            text += sign + " ".join(part for part in ("" if abs(c) == 1 and x else str(abs(c)), x) if part)
    return text or "0"


def written(x: Fraction | AlgebraicNumber | ExactAngle | float) -> str:
    """An exact number in full, as JSON has it."""
    return x.written() if isinstance(x, AlgebraicNumber | ExactAngle) else str(x)


def _told(x: ExactTime) -> str:
    """An exact number for readers: by square roots where that is possible, shortened where it is long."""
    short = getattr(x, "closed_form", None) or str(x)
    if len(short) <= LONGEST or isinstance(x, ExactAngle):
        return short
    if isinstance(x, Fraction):
        return f"a fraction of {len(str(x.denominator))} digits near {float(x)!r}"
    return str(x)


@dataclass(frozen=True, slots=True)
class ElementPair:
    """Two elements that meet: ``element_a`` on body a, ``element_b`` on body b."""

    element_a: Element
    element_b: Element

    def __str__(self) -> str:
        return f"{self.element_a} and {self.element_b}"

    def to_list(self) -> list[Table]:
        return [self.element_a.to_dict(), self.element_b.to_dict()]


class ContactSet(str):
    """What two bodies share at a time of contact: "point", "segment", "conic arc" or "patch".

    A patch is any area that both hold: flat, whatever bounds it, or curved, as that of a cone in its seat.
    points: (n, 3) float64, world frame: the point, the two ends, points along the arc, or around the patch: its corners
    and points along its arcs.
    """

    points: np.ndarray

    def __new__(cls, kind: str, points: ArrayLike) -> ContactSet:
        self = super().__new__(cls, kind)
        self.points = np.asarray(points, float)
        return self

    def __reduce__(self) -> tuple[object, ...]:
        return ContactSet, (str(self), self.points)


@dataclass(frozen=True, slots=True, eq=False)
class CandidateTime:
    """A root of a contact equation.

    time, multiplicity   of the root.
    point                (3,) float64, world: where the features meet, None when they do not.
    verdict              "contact" where both bodies hold the point, else "no contact"; reason says why.
    """

    time: float
    multiplicity: int
    point: np.ndarray | None
    verdict: str
    reason: str

    def __str__(self) -> str:
        where = "" if self.point is None else " at ({:.9g}, {:.9g}, {:.9g})".format(*self.point)
        why = f" ({self.reason})" if self.reason else ""
        return f"{self.time!r} x{self.multiplicity}: {self.verdict}{where}{why}"

    def to_dict(self) -> Table:
        point = None if self.point is None else [float(x) for x in self.point]
        return {**{f.name: getattr(self, f.name) for f in fields(self)}, "point": point}


@dataclass(frozen=True, slots=True, eq=False)
class Subproblem:
    """Two features, their case (Choi et al. 2014, "I" to "XI") and all candidate times of their contact equation.

    reason: why the pair has no equation (its features slide in one another), else "".
    """

    element_a: Element
    element_b: Element
    case: str
    candidates: tuple[CandidateTime, ...]
    reason: str = ""

    def __str__(self) -> str:
        head = f"case {self.case}: {self.element_a.label} and {self.element_b.label}"
        lines = [self.reason] if self.reason else [str(c) for c in self.candidates] or ["no candidate"]
        return "\n".join([head, *(f"  {line}" for line in lines)])

    def to_dict(self) -> Table:
        return {
            "element_a": self.element_a.to_dict(),
            "element_b": self.element_b.to_dict(),
            "case": self.case,
            "candidates": [x.to_dict() for x in self.candidates],
            "reason": self.reason,
        }


class ContactFields(TypedDict, total=False):
    """Fields of a FirstContact, but for its status, its bodies and the work."""

    time: float | None
    time_interval: tuple[float, float] | None
    time_exact: ExactTime | None
    point: np.ndarray | None
    normal: np.ndarray | None
    element_a: Element | None
    element_b: Element | None
    others: tuple[ElementPair, ...]
    multiplicity: int
    contact_set: str | None
    initial: str | None
    free_until: float | None
    reason: str | None
    subproblems: tuple[Subproblem, ...]


WITHIN = "no deeper than the parts deviate from the file's"
"""What is said of an overlap that `within_deviation` tells of."""


@dataclass(frozen=True, slots=True, eq=False)  # arrays have no single truth: see `Answer`
class FirstContact(_Deferring, Shown):
    """The earliest time at which two moving bodies share a point, or the proof that they share none.

    Of polyhedra, point, normal and elements are worked out when one of them is first read, of curved solids point,
    normal, others, multiplicity and contact_set, of ruled surfaces in contact at the start all these and initial;
    `stats` ends before that.

    status          Status.FREE proves that they share no point at any time of ``span``.
    time            the double nearest the true time (the motion's parameter), or, of curved bodies that doubles
                    decided, one within its enclosure; None when free.
    time_interval   (lo, hi) doubles that enclose the true time.
    time_exact      the time itself (``exact=True``): Fraction, AlgebraicNumber or ExactAngle.
    point, normal   (3,) float64, world frame at that time; normal is unit, from b towards a, None where
                    undefined (grazing, parallel edges, a start in contact).
    element_a/_b    the two elements; among simultaneous pairs the lowest (kind, index).
    others          further pairs at that time, at most 100; ``multiplicity`` counts all of them.
    contact_set     "point", "segment", "conic arc" or "patch"; None where the shared set, and with it which further
                    pairs meet, was not computed.
    subproblems     curved models with ``method="algebraic"``: every pair of features that is not exempt.
    joints          of mechanisms: where their joints stand at that time, enclosed.
    initial         for INITIAL_CONTACT: "touching", "overlapping" or "containment"; None where none was proved.
    free_until      no shared point before this time, or no new one; proved.
    reason          for UNDECIDED: "budget", "precision" or "memory"; of `first_new_contact` also "contact".
    allowed         of `first_new_contact`, and of scenes with [[allow]]: what of a start in contact was let pass, and
                    why; None where nothing was.
    model_deviation of parts of CAD files: how far the two bodies as built, about which all of this is proved, are from
                    the file's at most, both together; None of bodies that stand for themselves.
    unit            of lengths, where a file tells it.
    within_deviation of parts of CAD files that overlap at the start: whether it is proved that no common point is
                    farther from the surfaces of both than these deviate from the file's, so that the file's parts may
                    as well only touch, or not meet; False: not proved.
    """

    status: Status
    time: float | None = None
    time_interval: tuple[float, float] | None = None
    time_exact: ExactTime | None = None
    point: np.ndarray | None = None
    normal: np.ndarray | None = None
    element_a: Element | None = None
    element_b: Element | None = None
    others: tuple[ElementPair, ...] = ()
    multiplicity: int = 0
    contact_set: str | None = None
    initial: str | None = None
    free_until: float | None = None
    reason: str | None = None
    stats: Stats = field(default_factory=Stats)
    a: Any = field(default=None, repr=False)
    b: Any = field(default=None, repr=False)
    span: tuple[float, float] = (0.0, 1.0)
    subproblems: tuple[Subproblem, ...] = field(default=(), repr=False)
    allowed: str | None = None
    joints: tuple[JointValue, ...] = ()
    keeps_bodies: bool = False
    model_deviation: float | None = None
    unit: str | None = None
    within_deviation: bool | None = None

    @classmethod
    def free(cls, stats: Stats, a: Body, b: Body, span: tuple[float, float]) -> FirstContact:
        """The proof that two bodies share no point all over the span; fields that say nothing, which take most of the
        time to make, are filled when they are asked for."""
        record, put = object.__new__(cls), _setters(cls)  # type: ignore[arg-type]
        put["_rest"](record, _unsaid)
        for name, value in zip(_TOLD_OF_FREE, (Status.FREE, span[1], stats, a, b, span), strict=True):
            put[name](record, value)
        return record

    def __repr__(self) -> str:
        when = "" if self.time is None else f" at time {self.time!r}"
        return f"<FirstContact of {_name(self.a, 'a')} and {_name(self.b, 'b')}: {self.status.name}{when}>"

    def __str__(self) -> str:
        allowed = "" if self.allowed is None else f"\n  allowed: {self.allowed}"
        joints = f"\n  {', '.join(map(str, self.joints))}" if self.joints else ""
        models = _about_models(self.model_deviation, self.unit)
        return self._told() + joints + allowed + models + _corrected(self.a, self.b)

    def _told(self) -> str:
        names = f"{_name(self.a, 'a')} and {_name(self.b, 'b')}"
        lo, hi = self.span
        if self.status is Status.FREE:
            none = "shared point" if self.allowed is None else "new contact"
            return f"{names}: FREE over [{lo:g}, {hi:g}]\n  no {none} at any time of the span; proved"
        if self.status is Status.UNDECIDED:
            return f"{names}: UNDECIDED ({self.reason})\n  proved free until {self.free_until!r}"
        where = "" if self.point is None else " at ({:.9g}, {:.9g}, {:.9g})".format(*self.point)
        if self.contact_set not in (None, "point"):
            where = f" in a {self.contact_set}{where}"
        met = None if self.element_a is None else f"{self.element_a} meets {self.element_b}"
        if self.status is Status.INITIAL_CONTACT:
            elements = "" if met is None else f"; {met}"
            depth = "" if not self.within_deviation else f"\n  {WITHIN}: whether the file's overlap is not told"
            return f"{names}: INITIAL_CONTACT ({self.initial}) at time {self.time!r}\n {where}{elements}{depth}"
        assert self.time_interval is not None
        more = f" (and {self.multiplicity - 1} more pairs)" if self.multiplicity > 1 else ""
        exactly = "" if self.time_exact is None else f"\n  exactly {_told(self.time_exact)}"
        return (
            f"{names}: CONTACT at time {self.time!r}{where}\n"
            f"  {met or 'which elements meet is not told'}{more}; "
            f"time in [{self.time_interval[0]!r}, {self.time_interval[1]!r}]{exactly}"
        )

    def to_dict(self) -> Table:
        """One entry of "checks" in the JSON output; exact numbers are strings."""
        points = getattr(self.contact_set, "points", None)
        return {
            "schema": SCHEMA,
            "a": _name(self.a, "a"),
            "b": _name(self.b, "b"),
            "status": self.status.name,
            "span": list(self.span),
            "time": self.time,
            "time_interval": None if self.time_interval is None else list(self.time_interval),
            "time_exact": None if self.time_exact is None else written(self.time_exact),
            "point": None if self.point is None else [float(x) for x in self.point],
            "normal": None if self.normal is None else [float(x) for x in self.normal],
            "element_a": None if self.element_a is None else self.element_a.to_dict(),
            "element_b": None if self.element_b is None else self.element_b.to_dict(),
            "others": [p.to_list() for p in self.others],
            "multiplicity": self.multiplicity,
            "initial": self.initial,
            "contact_set": None if self.contact_set is None else str(self.contact_set),
            "contact_points": None if points is None else points.tolist(),
            "free_until": self.free_until,
            "reason": self.reason,
            "allowed": self.allowed,
            **_models_table(self),
            **({} if self.within_deviation is None else {"within_deviation": self.within_deviation}),
            "subproblems": [x.to_dict() for x in self.subproblems],
            **({"joints": [x.to_dict() for x in self.joints]} if self.joints else {}),
            "stats": self.stats.to_dict(),
        }


@dataclass(frozen=True, slots=True)
class ContactInterval(_NoTruth):
    """A maximal closed interval of times at which the bodies share a point.

    start, end                     doubles nearest the true ends; of ends that are known by their enclosures alone, the
                                   simple number in the enclosure where there is one, else its middle
    start_interval, end_interval   (lo, hi) enclosures
    start_exact, end_exact         the ends themselves when ``exact=True``
    """

    start: float
    end: float
    start_interval: tuple[float, float]
    end_interval: tuple[float, float]
    start_exact: ExactTime | None = None
    end_exact: ExactTime | None = None

    def __str__(self) -> str:
        if self.start_exact is None or self.end_exact is None:
            return f"[{self.start!r}, {self.end!r}]"
        ends = (self.start_exact, self.end_exact)
        short = [_told(x) if isinstance(x, Fraction) or getattr(x, "closed_form", None) else "" for x in ends]
        shown = ", ".join(x if 0 < len(x) <= LONGEST else repr(float(y)) for x, y in zip(short, ends, strict=True))
        roots = [f"\n    {name}: {x}" for name, x in zip(("start", "end"), ends, strict=True)
                 if not isinstance(x, Fraction)]  # fmt: skip
        return f"[{shown}]{''.join(roots)}"

    def to_dict(self) -> Table:
        out: dict[str, Any] = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name.endswith("_exact"):
                value = None if value is None else written(value)
            elif isinstance(value, tuple):
                value = list(value)
            out[f.name] = value
        return out


@dataclass(frozen=True, slots=True, eq=False)
class ContactIntervals(_NoTruth, Shown, Sequence[ContactInterval]):
    """All closed times of the span at which the bodies share a point: disjoint, ascending.

    With Status.UNDECIDED the list is what is proved of [start of span, ``free_until``].
    """

    intervals: tuple[ContactInterval, ...]
    status: Status
    free_until: float | None = None
    reason: str | None = None
    stats: Stats = field(default_factory=Stats)
    a: Any = field(default=None, repr=False)
    b: Any = field(default=None, repr=False)
    span: tuple[float, float] = (0.0, 1.0)
    keeps_bodies: bool = False
    model_deviation: float | None = None
    unit: str | None = None

    @classmethod
    def free(cls, stats: Stats, a: Body, b: Body, span: tuple[float, float]) -> ContactIntervals:
        """The proof that two bodies share no point all over the span."""
        return cls((), Status.FREE, span[1], None, stats, a, b, span)

    def __len__(self) -> int:
        return len(self.intervals)

    @overload
    def __getitem__(self, index: int) -> ContactInterval: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[ContactInterval, ...]: ...
    def __getitem__(self, index: int | slice) -> ContactInterval | tuple[ContactInterval, ...]:
        return self.intervals[index]

    def __repr__(self) -> str:
        names, count = f"{_name(self.a, 'a')} and {_name(self.b, 'b')}", len(self.intervals)
        return f"<ContactIntervals of {names}: {self.status.name}, {count} interval{'' if count == 1 else 's'}>"

    def __str__(self) -> str:
        head = f"{_name(self.a, 'a')} and {_name(self.b, 'b')}: {self.status.name}"
        if self.status is Status.UNDECIDED:
            head += f" ({self.reason}); decided until {self.free_until!r}"
        text = "\n".join([head, *(f"  {interval}" for interval in self.intervals)])
        return text + _about_models(self.model_deviation, self.unit) + _corrected(self.a, self.b)

    def to_dict(self) -> Table:
        """One entry of "checks" in the JSON output; exact numbers are strings."""
        return {
            "schema": SCHEMA,
            "a": _name(self.a, "a"),
            "b": _name(self.b, "b"),
            "status": self.status.name,
            "span": list(self.span),
            "intervals": [interval.to_dict() for interval in self.intervals],
            "free_until": self.free_until,
            "reason": self.reason,
            **_models_table(self),
            "stats": self.stats.to_dict(),
        }


@dataclass(frozen=True, slots=True, eq=False)
class ContactPairs(_NoTruth, Answer, Sequence[ElementPair]):
    """The element pairs that meet during the span: vertex/face, edge/edge, face/vertex, sorted.

    ``piercing`` lists edge/face and face/edge pairs that meet at the start of the span already, ``undecided`` pairs of
    either kind of which no precision tells whether they meet.  All others do not.
    """

    pairs: tuple[ElementPair, ...]
    piercing: tuple[ElementPair, ...] = ()
    undecided: tuple[ElementPair, ...] = ()
    stats: Stats = field(default_factory=Stats)

    def __len__(self) -> int:
        return len(self.pairs)

    @overload
    def __getitem__(self, index: int) -> ElementPair: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[ElementPair, ...]: ...
    def __getitem__(self, index: int | slice) -> ElementPair | tuple[ElementPair, ...]:
        return self.pairs[index]

    @property
    def count(self) -> int:  # type: ignore[override]
        """How many pairs meet, those pierced at the start not counted."""
        return len(self.pairs)

    def to_dict(self) -> Table:
        """Pairs of elements: that of a, that of b."""
        listed = {key: [pair.to_list() for pair in getattr(self, key)] for key in ("pairs", "piercing", "undecided")}
        return {"schema": SCHEMA, **listed, "stats": self.stats.to_dict()}

    def __repr__(self) -> str:
        return f"<ContactPairs: {self}>"

    def __str__(self) -> str:
        text = f"{len(self.pairs)} element pairs meet, {len(self.piercing)} pierced at the start"
        return f"{text}, {len(self.undecided)} undecided" if self.undecided else text


def finite(value: object) -> Any:
    """The value with infinite numbers as strings ("inf") and None for nan: JSON has none of its own."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def _name(body: Body, default: str) -> str:
    return getattr(body, "name", None) or default


def _correction(body: Body) -> float:
    """By how much an entry of a matrix given for the body's motion is off the rotation that it stands for, at most."""
    off: float = getattr(getattr(body, "motion", body), "correction", 0.0)
    return off


def _models_table(answer: FirstContact | ContactIntervals) -> Table:
    """What an answer says of the models of its bodies, where they are of files."""
    if answer.model_deviation is None:
        return {}
    return {"model_deviation": answer.model_deviation, "unit": answer.unit}


def _about_models(deviation: float | None, unit: str | None) -> str:
    """The end of an answer's text: of which bodies it is proved."""
    if deviation is None:
        return ""
    length = "" if unit is None else f" {unit}"
    if deviation == 0.0:
        return f"\n  of the bodies with the file's own surfaces{', lengths in' + length if length else ''}"
    return f"\n  of the bodies as built, within {_rounded_up(deviation)}{length} of the file's, both together"


def _rounded_up(x: float) -> str:
    """Two digits, no less than x."""
    unit = 10.0 ** (math.floor(math.log10(x)) - 1)
    return f"{math.ceil(x / unit * (1 - 1e-12)) * unit:.2g}"


def _corrected(a: Body, b: Body) -> str:
    """The end of an answer's text: how far given poses are off the rotations that were looked at."""
    bodies = [(_name(body, x), _correction(body)) for body, x in ((a, "a"), (b, "b"))]
    return "".join(
        f"\n  matrices of {name} are no exact rotations: the nearest ones were taken, entries off by up to {off:.1g}"
        for name, off in bodies if off > TOLD_CORRECTION
    )  # fmt: skip
