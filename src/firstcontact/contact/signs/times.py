"""All times of contact of two ruled pieces over one piece of their motion, exactly.

The sheets' times cut the span into cells.  Most cells and instants are free by exclusion over the whole span.  A cell
is decided at one rational time: by exclusion; by the fibres over rational parameters between the borders, which see
every contact that is no isolated point; then by the isolated points that are left.  An instant belongs to the contact
where a neighbouring cell does, for contact is closed, and is decided by its own points where neither does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property, cmp_to_key

from flint import fmpq, fmpz_mpoly, fmpz_poly

from firstcontact.contact.signs.conditions import Range, SignConditions
from firstcontact.contact.signs.exclusion import ParameterBox, Span, clusters, survivors
from firstcontact.contact.signs.shared_points import WIDE, FieldPoint, NearContact, shared_points
from firstcontact.contact.signs.sheets import (
    FARTHEST,
    Reach,
    Sheet,
    between,
    candidates,
    instants,
    samples,
    sheets,
)
from firstcontact.errors import UnsupportedPair
from firstcontact.exact.fields.number_field import NumberField
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots, root_bound, roots_in
from firstcontact.exact.numbers import dyadic, precision
from firstcontact.exact.polynomials.trivariate import at, exchanged, univariate
from firstcontact.work import Work

BITS = 64
AFTER, MOST_EXACT = 160, 4
COVER_VISITS, COVER_DEPTH = 200, 30


class Times:
    """The search over the closed span of the motion's parameter; work counts decided cells and instants.

    Raises TooLarge where elimination would lead to equations beyond `reach`.
    """

    def __init__(
        self, conditions: SignConditions, span: Span, work: Work | None = None, reach: Reach = FARTHEST
    ) -> None:
        self.conditions, self.span, self.work = conditions, span, work or Work()
        self.sheets, self.reach = sheets(conditions, reach), reach
        flat = instants(conditions)
        self._special = {str(p) for p in flat}
        """Polynomials of instants at which Delta vanishes for all u and v."""
        self.candidates = candidates([*(p for sheet in self.sheets for p in sheet.times), *flat], *span)
        boxes = survivors(conditions, span, COVER_VISITS, COVER_DEPTH)
        self._maybe = _joined([box.t for box in boxes])
        """Outside these times there is no contact."""
        self._near: dict[int, fmpq] = {}
        self._boxes: tuple[AlgebraicRoot, list[ParameterBox]] | None = None

    @cached_property
    def steps(self) -> int:
        """What the decision of a time counts as."""
        return self.reach.steps(self.sheets)

    def windows(self) -> Iterator[tuple[AlgebraicRoot, AlgebraicRoot]]:
        """The closed windows of contact, in order, disjoint."""
        start: AlgebraicRoot | None = None
        for wall, touched, after in self.states():
            if touched and start is None:
                start = wall
            if start is not None and not after:
                yield start, wall
                start = None

    def states(self) -> Iterator[tuple[AlgebraicRoot, bool, bool]]:
        """For every time at which contact may change, and both ends: (time, contact then, contact just after)."""
        lo, hi = (AlgebraicRoot.of(x) for x in self.span)
        inner = [x for x in self.candidates if x.compare(lo) > 0 and x.compare(hi) < 0]
        walls = [lo, *inner] if lo.compare(hi) == 0 else [lo, *inner, hi]
        before = False
        for k, wall in enumerate(walls):
            after = k + 1 < len(walls) and self._cell(wall, walls[k + 1])
            special = len(walls) == 1 or 0 < k < len(walls) - 1 or self._is_candidate(wall)
            yield wall, before or after or (special and self.at(wall)), after
            before = after

    def _is_candidate(self, wall: AlgebraicRoot) -> bool:
        return any(wall.compare(x) == 0 for x in self.candidates)

    def at(self, t: AlgebraicRoot) -> bool:
        """Whether there is a contact at the instant."""
        return bool(self.contacts(t, 1))

    def contacts(self, t: AlgebraicRoot, most: int = 8) -> list[FieldPoint]:
        """Some shared points at the instant, none where there is none."""
        if not self._may_hold(t, t):
            return []
        self.work.step()
        c = self.conditions
        if t.rational is not None:
            c = c.at(t.rational)
        elif str(t.polynomial) in self._special:
            raise UnsupportedPair(
                f"all rulings meet all others at an irrational time near {float(t)!r}, which exact arithmetic does not "
                "decide"
            )
        found: list[FieldPoint] = []
        for contact in shared_points(c, t, self._near_instant(t)):
            found.append(contact)
            if len(found) >= most:
                break
        return found

    def contacts_from(self, t: AlgebraicRoot, lasts: bool) -> list[FieldPoint]:
        """Some shared points at the instant, from which on there is contact if it `lasts`.

        Fields of high degree take long: there they are places in contact within 2^-AFTER after it, where there are.
        """
        if lasts and t.rational is None and t.polynomial.degree() > MOST_EXACT:
            with precision(2 * AFTER):
                late = dyadic(t.enclosure(2 * AFTER).upper()) + fmpq(1, 2**AFTER)
            if found := self._open_contacts(late):
                return found
        return self.contacts(t)

    def _open_contacts(self, t: fmpq) -> list[FieldPoint]:
        """One on every fibre between borders at the rational time, rounded to 2^-AFTER and less."""
        c, field = self.conditions, NumberField(AlgebraicRoot.of(t))
        found: list[FieldPoint] = []
        now = c.at(t)
        for sheet in self.sheets:
            for x in between_borders(sheet, t):
                y = _place_on_fibre(c, sheet, x, t, True)
                if y is not None:
                    with precision(2 * AFTER):
                        u, v = field(x), field(dyadic(y.enclosure(2 * AFTER).mid()))
                    place = (v, u) if sheet.exchanged else (u, v)
                    found.append(NearContact(now, (False, False), (c.u, c.v), *place, field(t)))
        return found

    def is_isolated(self, t: AlgebraicRoot) -> bool:
        """True where contacts at the instant are in narrow boxes only, so that none is part of a longer curve."""
        ranges = [r for pair in clusters(self._near_instant(t)) for r in pair]
        return all(hi - lo <= WIDE for lo, hi in ranges)

    def _near_instant(self, t: AlgebraicRoot) -> list[ParameterBox]:
        """Where contacts may be at the instant; those of the one asked for last are kept."""
        if self._boxes is None or self._boxes[0] is not t:
            self._boxes = t, survivors(self.conditions, enclosed(t))
        return self._boxes[1]

    def contact_at_start(self) -> list[FieldPoint]:
        """One shared point at a rational start: any on a fibre between the borders, for that is cheapest."""
        t = self.span[0]
        now = self.conditions.at(t)
        for sheet in sheets(now):
            for x in between_borders(sheet, t):
                y = _place_on_fibre(now, sheet, x, t, True)
                if y is not None:
                    field = NumberField(y)
                    first, second, time = field(x), field.generator(), field(t)
                    u, v = (second, first) if sheet.exchanged else (first, second)
                    return [FieldPoint(now, (False, False), (now.u, now.v), u, v, time)]
        return self.contacts(AlgebraicRoot.of(t))

    def _may_hold(self, x: AlgebraicRoot, y: AlgebraicRoot) -> bool:
        """False proves that no time from x to y has a contact."""
        return any(y.compare(lo) >= 0 and x.compare(hi) <= 0 for lo, hi in self._maybe)

    def _cell(self, x: AlgebraicRoot, y: AlgebraicRoot) -> bool:
        """Whether there is contact at the times strictly between x and y, at all or at none of which there is."""
        if not self._may_hold(x, y) or not self._may_hold_throughout(x, y):
            return False
        self.work.step(self.steps)
        t = between(x, y)
        return decide(self.conditions, self.sheets, t, self._near)

    def _may_hold_throughout(self, x: AlgebraicRoot, y: AlgebraicRoot) -> bool:
        """False proves that some time between x and y is free."""
        return any(x.compare(lo) >= 0 and y.compare(hi) <= 0 for lo, hi in self._maybe)


def decide(c: SignConditions, own: Sequence[Sheet], t: fmpq, near: dict[int, fmpq] | None = None) -> bool:
    """Whether there is a contact at the rational time t; own: sheets of which t is no critical time.

    near: for the number of a sheet a parameter to look at first; kept up to date.
    """
    near = {} if near is None else near
    if any(_on_fibre(c, own[k], x, t, False) for k, x in near.items()):
        return True
    boxes = survivors(c, (t, t))
    if not boxes:
        return False
    for k, sheet in enumerate(own):
        for x in between_borders(sheet, t):
            # nothing changes up to the next border: a cell without contact at one parameter has none
            if any(_holds(box, sheet, x) for box in boxes) and _on_fibre(c, sheet, x, t, True):
                near.clear()
                near[k] = x
                return True
    return any(True for _ in shared_points(c.at(t), AlgebraicRoot.of(t), boxes))


def _holds(box: ParameterBox, sheet: Sheet, x: fmpq) -> bool:
    """Whether the first parameter of a sheet is in the range of the box."""
    index = 1 if sheet.exchanged else 0
    lo, hi = box.v if sheet.exchanged else box.u
    if box.inverse[index]:
        return bool(x != 0 and lo <= 1 / x <= hi)
    return bool(lo <= x <= hi)


def between_borders(sheet: Sheet, t: fmpq) -> list[fmpq]:
    """A rational parameter in every cell between the borders at the time."""
    return samples(roots_of([univariate(at(b, 2, t), 0) for b in sheet.borders], sheet.first), sheet.first)


def roots_of(walls: Sequence[fmpz_poly], ends: Range) -> list[AlgebraicRoot]:
    """The real roots of all of them, each once, ascending.

    One by one: a factor is found much sooner in its wall than in the product of all.
    """
    different = list({str(p): p for p in walls if p.degree() > 0}.values())
    if ends is None:
        bound = max(map(root_bound, different), default=fmpq(0))
        ends = -bound, bound
    found: list[AlgebraicRoot] = []
    for root in sorted((x for p in different for x in real_roots(p, *ends)), key=cmp_to_key(AlgebraicRoot.compare)):
        if not found or found[-1].compare(root) != 0:
            found.append(root)
    return found


def _on_fibre(c: SignConditions, sheet: Sheet, x: fmpq, t: fmpq, off_borders: bool) -> bool:
    """Whether a contact of the sheet has this first parameter; only certain ones where x is on a border."""
    return _place_on_fibre(c, sheet, x, t, off_borders) is not None


def _place_on_fibre(c: SignConditions, sheet: Sheet, x: fmpq, t: fmpq, off_borders: bool) -> AlgebraicRoot | None:
    """The second parameter of such a contact."""
    known: dict[int, fmpz_poly] = {}

    def holds(y: AlgebraicRoot) -> bool:
        def sign(f: fmpz_mpoly) -> int:
            if id(f) not in known:
                known[id(f)] = _restricted(exchanged(f) if sheet.exchanged else f, x, t)
            return y.sign_of(known[id(f)])

        if off_borders and sheet.pairs is not None:
            return all(sign(g) * sign(h) <= 0 for g, h in sheet.pairs)
        return c.holds(sign, sheet.f is not None)

    if sheet.f is not None:
        f = _restricted(sheet.f, x, t)
        return None if f.is_zero() else next((y for y in roots_in(f, sheet.second) if holds(y)), None)
    critical = roots_of([_restricted(g, x, t) for g in sheet.clips], sheet.second)
    places = [*map(AlgebraicRoot.of, samples(critical, sheet.second)), *critical]
    return next((y for y in places if holds(y)), None)


def _restricted(f: fmpz_mpoly, x: fmpq, t: fmpq) -> fmpz_poly:
    """A positive multiple of f(x, ., t)."""
    return univariate(at(at(f, 2, t), 0, x), 1)


def enclosed(t: AlgebraicRoot) -> Span:
    """Rational numbers around the root, that itself where it is one."""
    if t.rational is not None:
        return t.rational, t.rational
    with precision(BITS):
        ball = t.enclosure(BITS)
        return dyadic(ball.lower()), dyadic(ball.upper())


def _joined(spans: Sequence[Span]) -> list[Span]:
    found: list[Span] = []
    for lo, hi in sorted(spans):
        if found and lo <= found[-1][1]:
            found[-1] = found[-1][0], max(hi, found[-1][1])
        else:
            found.append((lo, hi))
    return found

