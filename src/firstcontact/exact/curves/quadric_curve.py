"""The common curve of two quadrics, swept by planes: every branch of it, however short, with proof.

In coordinates x = T (u, v, w) the planes of constant u meet the quadrics in two conics A(u), B(u).

*   Two common points of the conics come together only where the discriminant of det(l A - B) vanishes (degree 8);
    between its roots the number of real ones stays the same.
*   The member of the pencil without w^2 is L1 w + L0, so w = -L0 / L1, and v is a root of a polynomial of degree 4.
    Two points have one v only where L1 and L0 vanish together (degree 2); between, branches keep their order in v.
*   A third quadric meets the curve only where the resultant of three conics vanishes (Sylvester's determinant, of
    degree 8).

So between neighbouring roots of all these, the *events*, every branch is a graph over u on which no other form changes
its sign: one rational plane tells all about it.  Branches are joined across an event by those points beside it that
come together as the planes approach it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cmp_to_key
from itertools import combinations, product
from typing import Any, NamedTuple

from flint import acb, arb, arb_poly, fmpq, fmpq_mat, fmpq_poly, fmpz, fmpz_mat, fmpz_poly

from firstcontact.exact.curves.fibres import simple_between
from firstcontact.exact.fields.roots import AlgebraicRoot, real_roots
from firstcontact.exact.numbers import Undecidable, dyadic, precision
from firstcontact.exact.pencils.pencils import characteristic, discriminant
from firstcontact.exact.polynomials.inertia import dot
from firstcontact.exact.polynomials.polynomial_matrix import congruent, constant
from firstcontact.exact.vectors import cross

Rows = Sequence[Sequence[Any]]
Ball3 = tuple[arb, arb, arb]

FIRST_BITS = 128
MOST_BITS = 2**14
"""Points of one plane that this precision does not part stay undecided."""
NEAR, NEARER = 40, 64
"""Planes beside an event are 2^-NEAR and 2^-NEARER of the way to the next one from it, or nearer if need be."""


class Degenerate(Exception):
    """No frame of the list is in general position: branches coincide, or another form vanishes on one of them."""


class QuadricBranch(NamedTuple):
    """One branch between two events; signs: of the other forms, none of them zero."""

    cell: int
    order: int
    signs: tuple[int, ...]


class QuadricEnd(NamedTuple):
    """An end of a branch, towards larger u or not; point: (x, y, z) near it."""

    branch: QuadricBranch
    upper: bool
    point: list[arb]


class BranchSweep:
    """All branches with lo <= u <= hi; cells[k]: those between event k - 1 and event k (none before the first)."""

    def __init__(self, first: Rows, second: Rows, others: Sequence[Rows], frame: Rows, span: tuple[fmpq, fmpq]) -> None:
        self.frame = frame
        self.curve = _Fibres(_in_frame(first, frame), _in_frame(second, frame))
        self.others = [_in_frame(form, frame) for form in others]
        polynomials = [self.curve.meeting, self.curve.hidden]
        polynomials += [_meeting_three(self.curve.forms, form) for form in self.others]
        if not all(polynomials):
            raise Degenerate
        self.events = _distinct([root for p in polynomials for root in real_roots(p, *span)], *span)
        ends = [AlgebraicRoot.of(span[0]), *self.events, AlgebraicRoot.of(span[1])]
        self._gaps = [_gap(a, b) for a, b in zip(ends, ends[1:], strict=False)]
        self._ends = ends
        self.levels = [simple_between(*self._inner(k, 10)) for k in range(len(self._gaps))]
        self.cells = [self._branches(k) for k in range(len(self.levels))]

    def _branches(self, cell: int) -> list[QuadricBranch]:
        count = len(self.curve.points(self.levels[cell], FIRST_BITS))
        return [QuadricBranch(cell, k, self._signs(cell, k)) for k in range(count)]

    def _signs(self, cell: int, order: int) -> tuple[int, ...]:
        u, bits = self.levels[cell], FIRST_BITS
        while bits <= MOST_BITS:
            v, w = self.curve.points(u, bits)[order]
            with precision(bits):
                x = [arb(u), v, w, arb(1)]
                values: list[arb] = [dot(x, [dot(row, x) for row in form]) for form in self.others]  # type: ignore[misc]  # of balls
            if all(value > 0 or value < 0 for value in values):
                return tuple(1 if value > 0 else -1 for value in values)
            bits *= 2
        raise Undecidable

    def point(self, branch: QuadricBranch, bits: int) -> list[arb]:
        """The branch's point (x, y, z, 1) on its own rational plane; call within `precision(bits)`."""
        u = self.levels[branch.cell]
        return self._placed(u, self.curve.points(u, bits)[branch.order])

    def across(self, cell: int, share: float) -> list[list[arb]]:
        """The points of all branches of the cell on the plane at that share of it, 0 < share < 1."""
        lo, hi = self._inner(cell, NEAR)
        u = lo + (hi - lo) * fmpq(*share.as_integer_ratio())
        with precision(FIRST_BITS):
            found = [self._placed(u, p) for p in self.curve.points(u, FIRST_BITS)]
        if len(found) != len(self.cells[cell]):
            raise Undecidable
        return found

    def _placed(self, u: fmpq, p: tuple[arb, arb]) -> list[arb]:
        x = [dot(row, [arb(u), *p, arb(1)]) for row in self.frame]
        return [*(c / x[3] for c in x[:3]), arb(1)]

    # -- across events --------------------------------------------------------------------------------------

    def meeting(self, event: int) -> list[list[QuadricEnd]]:
        """How branches go on at an event: groups of ends that meet, each with where it is close to the event.

        Ends meet when they come together as the planes approach the event; others keep their distance.
        """
        for scale in (1, 4, 16, 64):
            ends, far = self._beside(event, NEAR * scale)
            _, near = self._beside(event, NEARER * scale)
            with precision(self._digits(event, NEARER * scale)):
                groups = _together(far, near)
            if groups is not None:
                return [[QuadricEnd(*ends[k], near[k]) for k in group] for group in groups]
        raise Undecidable

    def _beside(self, event: int, share: int) -> tuple[list[tuple[QuadricBranch, bool]], list[list[arb]]]:
        """The ends, and where they are on planes 2^-share of the cells' widths from the event."""
        ends, points = [], []
        bits = self._digits(event, share)
        for side in (0, 1):
            u = self._inner(event + side, share)[1 - side]
            here = self.curve.points(u, bits)
            if len(here) != len(self.cells[event + side]):
                raise Undecidable
            ends += [(branch, side == 0) for branch in self.cells[event + side]]
            with precision(bits):
                points += [[arb(c.mid()) for c in self._placed(u, p)[:3]] for p in here]
        return ends, points

    def _digits(self, event: int, share: int) -> int:
        """Bits that tell points apart whose distance is a small part of the gaps beside the event."""
        return 4 * share + 2 * max(_smallness(gap) for gap in self._gaps[event : event + 2])

    def _inner(self, cell: int, bits: int) -> tuple[fmpq, fmpq]:
        """Planes inside the cell, at most 2^-bits of its width from its ends."""
        gap = self._gaps[cell]
        room = gap / fmpq(2) ** bits
        digits = bits + 24 + _smallness(gap)
        lo, hi = (_bounds(end, digits) for end in self._ends[cell : cell + 2])
        return lo[1] + room / 2, hi[0] - room / 2


def swept(
    first: Rows, second: Rows, others: Sequence[Rows], box: tuple[Sequence[fmpq], Sequence[fmpq]]
) -> BranchSweep:
    """The sweep of the common curve of two forms over a box, in the first frame that is in general position."""
    for tilt in (fmpq(0), fmpq(1, 8)):
        for quaternion in _QUATERNIONS:
            frame, span = _frame(box, quaternion, tilt)
            try:
                return BranchSweep(first, second, others, frame, span)
            except Degenerate:
                continue
    raise Degenerate


# No special position relative to the usual axes, planes and angles.
_QUATERNIONS = ((23, 7, -11, 5), (19, -13, 4, 9), (17, 6, 14, -3), (29, -8, -5, 12))


def _frame(
    box: tuple[Sequence[fmpq], Sequence[fmpq]], quaternion: Sequence[int], tilt: fmpq
) -> tuple[Rows, tuple[fmpq, fmpq]]:
    """T, and the range of u over the box.

    The box comes to lie within a few units of the origin.  A tilt moves infinity too: no plane of constant u is then
    parallel to a line of the curve, whichever directions that has.
    """
    lo, hi = box
    centre = [(a + b) / 2 for a, b in zip(lo, hi, strict=True)]
    reach = max(b - a for a, b in zip(lo, hi, strict=True)) or fmpq(1)
    exponent = int(reach.p).bit_length() - int(reach.q).bit_length()
    size = fmpq(2) ** exponent if exponent >= 0 else 1 / fmpq(2) ** -exponent
    turned, norm = _turned(quaternion)
    rows = [[size * x / norm for x in row] + [c] for row, c in zip(turned, centre, strict=True)]
    last = [tilt, tilt / 3, -tilt / 2, fmpq(1)]
    frame = [[a + row[3] * b for a, b in zip(row[:3], last, strict=False)] + [row[3]] for row in rows] + [last]
    inverse = fmpq_mat(frame).inv()
    values = []
    for corner in product(*zip(lo, hi, strict=True)):
        image = [sum((inverse[i, j] * c for j, c in enumerate((*corner, fmpq(1)))), fmpq(0)) for i in (0, 3)]
        values.append(image[0] / image[1])
    room = fmpq(1, 64)
    return frame, (min(values) - room, max(values) + room)


def _turned(q: Sequence[int]) -> tuple[list[list[fmpq]], fmpq]:
    """The rotation matrix of an integer quaternion times its norm, and the norm."""
    a, b, c, d = q
    rows = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    return [[fmpq(x) for x in row] for row in rows], fmpq(a * a + b * b + c * c + d * d)


# -- one plane ----------------------------------------------------------------------------------------------

Form = list[list[fmpz]]
"""A symmetric 4x4 form in u, v, w, 1."""


def _in_frame(form: Rows, frame: Rows) -> Form:
    return [[fmpz(p[0]) for p in row] for row in constant(congruent(frame, form))]


class _Fibres:
    """The common points of two quadrics on the planes of constant u."""

    def __init__(self, first: Form, second: Form) -> None:
        if first[2][2] == 0:
            first, second = second, first
        if first[2][2] == 0:
            raise Degenerate
        self.forms = first, second
        scale, other = second[2][2], first[2][2]
        pairs = zip(first, second, strict=True)
        linear = [[scale * a - other * b for a, b in zip(*rows, strict=True)] for rows in pairs]
        a = _powers_of_w(first)
        self.top, self.rest = _powers_of_w(linear)[1::-1]  # L1, L0
        p, beta = self.top[0], self.top[1]
        l0, l1, l2 = self.rest
        self.hidden = beta * beta * l0 - beta * p * l1 + p * p * l2
        fibre = _plus(_times(a[0], _times(self.top, self.top)), _times(a[1], _times(self.top, self.rest)), -1)
        self.fibre = _plus(fibre, _times(a[2], _times(self.rest, self.rest)))
        self.meeting = discriminant(characteristic(_section(first), _section(second)))
        if beta.is_zero() or self.fibre[4].is_zero():
            raise Degenerate
        self._enough = FIRST_BITS
        self._known: dict[tuple[fmpq, int], list[tuple[arb, arb]]] = {}

    def points(self, u: fmpq, bits: int) -> list[tuple[arb, arb]]:
        """(v, w) of the real common points at a plane without coincidence, ascending in v; at least so many bits."""
        key = u, bits
        bits = max(bits, self._enough)
        while key not in self._known:
            if bits > MOST_BITS:
                raise Undecidable
            with precision(bits):
                found = self._points(u, bits)
            if found is None:
                self._enough = bits  # planes nearby ask for more too
                bits *= 2
            else:
                self._known[key] = found
        return self._known[key]

    def _points(self, u: fmpq, bits: int) -> list[tuple[arb, arb]] | None:
        roots = _complex_roots(fmpq_poly([p(u) for p in self.fibre]), bits)
        if roots is None:
            return None
        real = [r for r in roots if r.imag.contains(0)]
        for r in real:  # a ball that meets its mirror image, and no other ball does, holds a real root
            if any(s is not r and s.imag.overlaps(-r.imag) and s.real.overlaps(r.real) for s in roots):
                return None
        values = sorted((arb(r.real) for r in real), key=cmp_to_key(_by_middle))
        if any(x.overlaps(y) for x, y in zip(values, values[1:], strict=False)):
            return None
        found = []
        for v in values:
            below = _value(self.top, u, v)
            if below.contains(0):
                return None
            found.append((v, -_value(self.rest, u, v) / below))
        return found


def _complex_roots(f: fmpq_poly, bits: int) -> list[acb] | None:
    """Balls about the roots, as far as they are single."""
    try:
        return arb_poly(f).complex_roots(tol=arb(2) ** (-bits // 2))
    except ValueError:  # the iteration may go round in circles near double roots, at any precision
        found: list[Any] = f.complex_roots()
        return [root for root, _ in found] if all(count == 1 for _, count in found) else None


def _by_middle(x: arb, y: arb) -> int:
    return -1 if x.mid() < y.mid() else 1


def _value(f: list[fmpz_poly], u: fmpq, v: arb) -> arb:
    total = arb(0)
    for p in reversed(f):
        total = total * v + arb(p(u))
    return total


def _powers_of_w(form: Form) -> list[list[fmpz_poly]]:
    """The coefficients of 1, w, w^2, each by powers of v: polynomials in u."""
    f = form
    plain = [fmpz_poly([f[3][3], 2 * f[0][3], f[0][0]]), fmpz_poly([2 * f[1][3], 2 * f[0][1]]), fmpz_poly([f[1][1]])]
    return [plain, [fmpz_poly([2 * f[2][3], 2 * f[0][2]]), fmpz_poly([2 * f[1][2]])], [fmpz_poly([f[2][2]])]]


def _section(form: Form) -> list[list[fmpz_poly]]:
    """The conic on the plane, in v, w, 1: polynomials in u."""
    f = form
    last = [fmpz_poly([f[k][3], f[k][0]]) for k in (1, 2)]
    rows = [[fmpz_poly([f[i][j]]) for j in (1, 2)] + [last[i - 1]] for i in (1, 2)]
    return [*rows, [*last, fmpz_poly([f[3][3], 2 * f[0][3], f[0][0]])]]


def _times(f: list[fmpz_poly], g: list[fmpz_poly]) -> list[fmpz_poly]:
    found = [fmpz_poly()] * (len(f) + len(g) - 1)
    for i, a in enumerate(f):
        for j, b in enumerate(g):
            found[i + j] = found[i + j] + a * b
    return found


def _plus(f: list[fmpz_poly], g: list[fmpz_poly], sign: int = 1) -> list[fmpz_poly]:
    n = max(len(f), len(g))
    f, g = (h + [fmpz_poly()] * (n - len(h)) for h in (f, g))
    return [a + sign * b for a, b in zip(f, g, strict=True)]


# -- where three conics share a point -----------------------------------------------------------------------

_PLACES = range(-4, 5)
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


@cache
def _interpolation() -> fmpq_mat:
    return fmpq_mat([[fmpq(x) ** k for k in range(len(_PLACES))] for x in _PLACES]).inv()


def _meeting_three(forms: tuple[Form, Form], other: Form) -> fmpz_poly:
    """The resultant of three conics on the planes of constant u: of degree 8, by its values at nine planes."""
    sections = [_section(form) for form in (*forms, other)]
    values = fmpq_mat([[fmpq(_resultant([[[p(x) for p in row] for row in s] for s in sections]))] for x in _PLACES])
    coefficients = [row[0] for row in (_interpolation() * values).tolist()]
    found = fmpq_poly(coefficients).numer()
    return found if found.is_zero() else found // found.content()


def _resultant(conics: Sequence[list[list[fmpz]]]) -> fmpz:
    """Sylvester's determinant for three ternary quadratic forms: theirs and the derivatives of their Jacobian."""
    rows = [[m[i][j] * (1 if i == j else 2) for i, j in _PAIRS] for m in conics]
    for k in range(3):
        row = [fmpz(0)] * 6
        for n in range(3):
            p, q, s = conics[n][k], conics[(n + 1) % 3], conics[(n + 2) % 3]
            for at, (i, j) in enumerate(_PAIRS):
                row[at] += dot(p, cross(q[i], s[j])) + (dot(p, cross(q[j], s[i])) if i != j else 0)
        rows.append(row)
    return fmpz_mat(rows).det()


# -- events -------------------------------------------------------------------------------------------------


def _distinct(roots: list[AlgebraicRoot], lo: fmpq, hi: fmpq) -> list[AlgebraicRoot]:
    """Those between lo and hi, each once, ascending."""
    roots = [r for r in roots if r.compare(lo) > 0 and r.compare(hi) < 0]
    roots.sort(key=cmp_to_key(AlgebraicRoot.compare))
    return [r for k, r in enumerate(roots) if k == 0 or roots[k - 1].compare(r) != 0]


def _smallness(x: fmpq) -> int:
    """How many bits below 1 it is."""
    return max(0, int(x.q).bit_length() - int(x.p).bit_length())


def _bounds(root: AlgebraicRoot, bits: int) -> tuple[fmpq, fmpq]:
    """Rational bounds, as near as that many bits tell."""
    if root.lo == root.hi:
        return root.lo, root.hi
    ball = root.enclosure(bits)
    with precision(bits + 64):
        return dyadic(arb(ball.lower())), dyadic(arb(ball.upper()))


def _gap(first: AlgebraicRoot, second: AlgebraicRoot) -> fmpq:
    """A lower bound of the distance of two roots, less than twice too small."""
    bits = FIRST_BITS
    while True:
        (a, b), (c, d) = _bounds(first, bits), _bounds(second, bits)
        if 2 * (c - b) > d - a:
            return c - b
        bits *= 2


def _together(far: list[list[arb]], near: list[list[arb]]) -> list[list[int]] | None:
    """Groups of ends whose distances shrink between the two pairs of planes; None where that is not plain."""
    group = list(range(len(far)))
    for i, j in combinations(range(len(far)), 2):
        before, after = (_distance(p[i], p[j]) for p in (far, near))
        if after < before / 32:
            old, new = group[j], group[i]
            group = [new if g == old else g for g in group]
        elif not after > before * 3 / 4:
            return None
    return [[k for k, g in enumerate(group) if g == name] for name in dict.fromkeys(group)]


def _distance(p: list[arb], q: list[arb]) -> arb:
    return sum(((a - b) ** 2 for a, b in zip(p, q, strict=True)), arb(0)).sqrt()
