"""The curves in which two surfaces of a solid meet, exactly (Choi et al. 2014, section 2; the splitting test by
rank-2 members of the pencil is from Tu et al. 2009, section 3)."""

from __future__ import annotations

from itertools import combinations

from flint import fmpq, fmpq_poly

from firstcontact.body.solid.carriers import (
    ONE,
    ZERO,
    Conic,
    Curve,
    Line,
    Plane,
    Quadric,
    QuarticCurve,
    Rows,
    Surface,
    Vector,
    bilinear,
    columns,
    diagonalised,
    dot,
    null_space,
    primitive,
    primitive_rows,
    restricted,
    times,
    upright,
)
from firstcontact.exact.rigid import rational_sqrt
from firstcontact.exact.vectors import cross


def common_curves(first: Surface, second: Surface) -> list[Curve]:
    """The real finite curves common to two different surfaces; isolated common points are left out."""
    if isinstance(first, Plane) and isinstance(second, Plane):
        return plane_plane(first, second)
    if isinstance(first, Plane):
        assert isinstance(second, Quadric)
        return plane_quadric(first, second)
    if isinstance(second, Plane):
        return plane_quadric(second, first)
    return quadric_quadric(first, second)


def plane_plane(first: Plane, second: Plane) -> list[Curve]:
    n, m = first.normal[:3], second.normal[:3]
    direction = cross(n, m)
    if not any(direction):
        return []
    square = dot(direction, direction)
    p, q = cross(m, direction), cross(direction, n)
    point = tuple((-first.normal[3] * a - second.normal[3] * b) / square for a, b in zip(p, q, strict=True))
    return [line(direction, point)]


def line(direction: Vector, point: Vector) -> Line:
    """The line in one form, whichever of its points and directions describe it: by its point nearest the origin."""
    d = upright(direction)
    shift = dot(d, point) / dot(d, d)
    foot = tuple(p - shift * x for p, x in zip(point, d, strict=True))
    return Line(columns((*d, ZERO), (*foot, ONE)))


def plane_quadric(plane: Plane, quadric: Quadric) -> list[Curve]:
    """A conic, one or two lines, or nothing."""
    plane = Plane(upright(plane.normal))
    basis = plane.basis
    form = restricted(quadric.form, basis)
    parts = [(value, vector) for value, vector in diagonalised(form) if value]
    signs = {value > 0 for value, _ in parts}
    if len(parts) == 3:
        return [Conic(basis, upright_form(form))] if len(signs) == 2 else []
    lines = linear_factors(form)
    if lines is None:
        return [Conic(basis, upright_form(form))] if len(signs) == 2 else []
    return [curve for factor in lines if (curve := _line_in_plane(basis, factor)) is not None]


def _line_in_plane(basis: Rows, factor: Vector) -> Line | None:
    """The line of the plane's points y with factor.y = 0; None at infinity."""
    a, b, c = factor
    if a == b == 0:
        return None
    square = a * a + b * b
    ends = times(basis, columns((-b, a, ZERO), (-a * c / square, -b * c / square, ONE)))
    direction, point = zip(*ends[:3], strict=True)
    return line(direction, point)


def linear_factors(form: Rows) -> list[Vector] | None:
    """The distinct rational linear factors of a form of rank 1 or 2; None when they are irrational or complex."""
    squares = [(value, vector) for value, vector in diagonalised(form) if value]
    duals = [(value, tuple(dot(row, vector) / value for row in form)) for value, vector in squares]
    if len(duals) == 1:
        return [upright(duals[0][1])]
    (p, u), (q, v) = duals
    ratio = -q / p  # form = p (u^2 - ratio v^2)
    root = rational_sqrt(ratio) if ratio > 0 else None
    if root is None:
        return None
    return [upright(tuple(a + s * root * b for a, b in zip(u, v, strict=True))) for s in (1, -1)]


def upright_form(form: Rows) -> Rows:
    """The multiple with coprime integers that has two positive squares and a negative one, or one of each."""
    form = primitive_rows(form)
    values = [value for value, _ in diagonalised(form)]
    if sum(v < 0 for v in values) > sum(v > 0 for v in values):
        form = tuple(tuple(-x for x in row) for row in form)
    return form


def quadric_quadric(first: Quadric, second: Quadric) -> list[Curve]:
    """Conics and lines where the pencil holds rational plane pairs, otherwise one QuarticCurve; or nothing."""
    members = [member(first, second, root) for root in rank_two_members(first, second)]
    pairs = [(form, linear_factors(form)) for form in members]
    for _, factors in sorted((p for p in pairs if p[1] is not None), key=lambda p: len(p[1] or ())):
        assert factors is not None
        planes = [Plane(primitive(factor)) for factor in factors if any(factor[:3])]
        return [curve for plane in planes for curve in plane_quadric(plane, first)]
    for form in members:
        if len({value > 0 for value, _ in diagonalised(form) if value}) == 1:  # only its singular line is real
            return _contained_line(null_space(form), first)
    return [QuarticCurve(first, second)]


def _contained_line(ends: list[Vector], quadric: Quadric) -> list[Curve]:
    """The line through two points when it lies on the quadric and is finite."""
    p, q = ends
    if any(bilinear(quadric.form, x, y) for x, y in ((p, p), (p, q), (q, q))):
        return []
    if p[3] == 0:
        p, q = q, p
    if p[3] == 0:
        return []
    direction = tuple(a * p[3] - b * q[3] for a, b in zip(q, p, strict=True))[:3]
    return [line(direction, tuple(x / p[3] for x in p[:3]))]


def member(first: Quadric, second: Quadric, root: fmpq) -> Rows:
    pairs = zip(first.form, second.form, strict=True)
    return tuple(tuple(root * a - b for a, b in zip(*rows, strict=True)) for rows in pairs)


def rank_two_members(first: Quadric, second: Quadric) -> list[fmpq]:
    """All rational l for which l A - B has rank <= 2: common roots of its 3x3 minors (A itself has rank >= 3)."""
    entries = [
        [fmpq_poly([-second.form[i][j], first.form[i][j]]) for j in range(4)] for i in range(4)
    ]
    triples = list(combinations(range(4), 3))
    common = fmpq_poly(0)
    for rows in triples:
        for cols in triples:
            common = common.gcd(_minor(entries, rows, cols))
            if not common.is_zero() and common.degree() == 0:
                return []
    return [root for root, _ in common.roots()]


def _minor(m: list[list[fmpq_poly]], rows: tuple[int, ...], cols: tuple[int, ...]) -> fmpq_poly:
    (a, b, c), (d, e, f), (g, h, i) = ([m[r][k] for k in cols] for r in rows)
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
