"""Topology of plane curves: known curves by hand, random ones against root counts, and against their own images."""

from __future__ import annotations

import random

import pytest
from flint import fmpq, fmpz_poly

from firstcontact.exact.curves.plane_curves import Graph, RootEdge, reciprocal, topology
from firstcontact.exact.polynomials.bivariate import U, V, factors, polynomial, restrict, sign_at

u, v = U, V
BOX = {"u": (fmpq(-2), fmpq(2)), "v": (fmpq(-2), fmpq(2))}


def kinds(graph: Graph) -> list[str]:
    return sorted(c.kind for c in graph.components)


def tally(graph: Graph, *names: str) -> list[int]:
    found = [n.kind for n in graph.nodes]
    return [found.count(name) for name in names]


def invariants(graph: Graph) -> tuple:
    """What every homeomorphism keeps: pieces, cycles, and the valences other than 2."""
    cycles = len(graph.edges) - len(graph.nodes) + len(graph.components)
    return kinds(graph), cycles, sorted(len(n.edges) for n in graph.nodes if len(n.edges) != 2)


# curve, components in the box [-2, 2]^2, numbers of (isolated, boundary, extreme, cusp, node)
IN_BOX = {
    "circle": (u**2 + v**2 - 1, ["loop"], [0, 0, 2, 0, 0]),
    "alpha curve": (v**2 - u**2 * (u + 1), ["branched"], [0, 2, 1, 0, 1]),
    "cusp": (v**2 - u**3, ["arc"], [0, 2, 0, 1, 0]),
    "cusp, upright": (u**2 - v**3, ["arc"], [0, 2, 0, 1, 0]),
    "isolated point": (v**2 - u**2 * (u - 1), ["arc", "point"], [1, 2, 1, 0, 0]),
    "nothing but a point": (u**2 + v**2, ["point"], [1, 0, 0, 0, 0]),
    "tacnode": (v**2 - u**4 + u**6, ["branched"], [0, 0, 2, 0, 1]),
    "tangent parabola": (v * (v - u**2), ["branched"], [0, 4, 0, 0, 1]),
    "tacnode and node": (2 * u**4 - 3 * u**2 * v + v**2 - 2 * v**3 + v**4, ["branched"], [0, 4, 4, 0, 2]),
    "lemniscate": ((u**2 + v**2) ** 2 - 2 * (u**2 - v**2), ["branched"], [0, 0, 2, 0, 1]),
    "rose": ((u**2 + v**2) ** 3 - 4 * u**2 * v**2, ["branched"], [0, 0, 4, 0, 1]),
    "asymptotes": (u * v - 1, ["arc", "arc"], [0, 4, 0, 0, 0]),
    "pole of even order": (u**2 * v - 1, ["arc", "arc"], [0, 4, 0, 0, 0]),
    "inflection with vertical tangent": (v**3 - u, ["arc"], [0, 2, 0, 0, 0]),
    "line through a node": (u * (v**2 - u**2 * (u + 1)), ["branched"], [0, 4, 1, 0, 1]),
    "repeated factors": ((u**2 + v**2 - 1) ** 3 * (u - v) ** 2, ["branched"], [0, 2, 2, 0, 2]),
    "lines only": (u * (u - 1) * v, ["branched"], [0, 6, 0, 0, 2]),
    "lines on the border": ((u - 2) * (v + 2), ["arc"], [0, 3, 0, 0, 0]),
    "tangent to the border from outside": (v - 2 - u**2, ["point"], [1, 0, 0, 0, 0]),
    "tangent to the border from inside": (v - 2 + u**2, ["arc"], [0, 3, 0, 0, 0]),
    "corner only": (u + v - 4, ["point"], [1, 0, 0, 0, 0]),
    "outside": (u**2 + v**2 - 100, [], [0, 0, 0, 0, 0]),
}


@pytest.mark.parametrize("name", IN_BOX)
def test_known_curves_in_a_box(name):
    f, components, counts = IN_BOX[name]
    graph = topology(f, **BOX)
    assert kinds(graph) == components
    assert tally(graph, "isolated", "boundary", "extreme", "cusp", "node") == counts
    check_incidence(graph)


def check_incidence(graph: Graph) -> None:
    """Nodes and samples of edges lie on their curves, exactly; samples lie on no other curve."""
    for node in graph.nodes:
        assert node.curves and all(node.sign(graph.curves[i]) == 0 for i in node.curves)
    for edge in graph.edges:
        assert [i for i, f in enumerate(graph.curves) if edge.sign(f) == 0] == [edge.curve]
        for end in (edge.start, edge.end):
            assert edge.curve in graph.nodes[end].curves and edge.index in graph.nodes[end].edges


ON_LINES = {
    "circle: closes, and has a point at infinity twice": (u**2 + v**2 - 1, ["loop", "point"]),
    "hyperbola: one loop through both infinities": (u * v - 1, ["loop"]),
    "line": (u - v, ["loop"]),
    "cusp, and one at infinity": (v**2 - u**3, ["loop"]),
    "two loops, irreducible": (u**2 * v**2 + 4 * u**2 * v + u**2 - v**2 + 4 * v - 1, ["loop", "loop"]),
    "two loops that cross twice": ((u * v + u - v + 1) * (u * v + u + v - 1), ["branched"]),
    "figure eight": (2 * u**2 * v - (v - 1) ** 2, ["branched"]),
    "no real point": (7 * u**2 * v**2 + 4 * u**2 * v + 7 * u**2 + 3 * v**2 + 4 * v + 3, []),
    "axis and border of the charts": (u * (v - 1), ["branched"]),
    "a line v = 1": (v - 1, ["loop"]),
    "no curve": (u * 0 + 5, []),
}


@pytest.mark.parametrize("name", ON_LINES)
def test_known_curves_on_projective_lines(name):
    f, components = ON_LINES[name]
    graph = topology(f)
    assert kinds(graph) == components
    check_incidence(graph)


def test_two_extremes_over_one_u():
    """Two multiple zeros on one fibre: rational u, irrational u, and one opening to each side."""
    graph = topology((u - v**2) * (u - (v - 3) ** 2), (fmpq(-1), fmpq(2)), (fmpq(-2), fmpq(5)))
    assert kinds(graph) == ["arc", "arc"] and tally(graph, "extreme") == [2]
    graph = topology((v**2 - 1) ** 2 - u**2 + 2, (fmpq(-4), fmpq(4)), (fmpq(-4), fmpq(4)))
    assert kinds(graph) == ["arc", "arc"] and tally(graph, "extreme") == [6]
    over_sqrt_2 = [n for n in graph.nodes if n.x.polynomial == fmpz_poly([-2, 0, 1])]
    assert [n.y.number() for n in over_sqrt_2] == [-1, 1, -1, 1]
    assert [(n.left, n.right) for n in over_sqrt_2] == [(2, 0), (2, 0), (0, 2), (0, 2)]
    graph = topology((v - 1) ** 2 * (v + 1) ** 2 - u * v, (fmpq(-1), fmpq(1)), (fmpq(-2), fmpq(2)))
    assert [(n.left, n.right) for n in graph.nodes if n.kind == "extreme"] == [(2, 0), (0, 2)]


def test_double_zeros_on_the_border():
    """At u = sqrt 2 the curve turns back on v = 1: where charts meet, and on the border of a box."""
    f = (v - 1) ** 2 * (v + 3) + u**2 - 2
    root = fmpz_poly([-2, 0, 1])
    (turn,) = [n for n in topology(f).nodes if n.u is not None and n.u.polynomial == root and float(n.u) > 0]
    assert (turn.v.rational, turn.kind, turn.left, turn.right) == (1, "extreme", 0, 2)  # of the chart 1/u
    for v_range in ((fmpq(-2), fmpq(1)), (fmpq(1), fmpq(3))):
        (turn,) = [n for n in topology(f, (fmpq(0), fmpq(2)), v_range).nodes if n.x.polynomial == root]
        assert (turn.v.rational, turn.kind, turn.left, turn.right) == (1, "boundary", 1, 0)


def test_singular_points_at_infinity_over_irrational_numbers():
    root = fmpz_poly([-2, 0, 1])

    def over_root(graph):
        return [n for n in graph.nodes if n.u is not None and n.u.polynomial == root]

    pole = topology((u**2 - 2) ** 2 * (u**2 + 1) * v**2 - 1)  # v = oo is a double zero of one curve
    assert [(n.kind, n.v, n.left, n.right) for n in over_root(pole)] == [("node", None, 2, 2)] * 2
    poles = topology([(u**2 - 2) * v - 1, (u**2 - 2) * (u**2 - 1) * v - 1])  # two curves touch at v = oo
    assert [(n.kind, n.v, n.left, n.right) for n in over_root(poles)] == [("node", None, 2, 2)] * 2


def test_common_points_over_irrational_numbers():
    """Two over one u; one tangency; in each the resultant has a double root."""
    crossing = topology([u**2 + v**2 - 3, u**2 - v**2 - 1], **BOX)
    assert [(float(n.u), float(n.v)) for n in crossing.nodes if n.kind == "node"] == [
        (x, y) for x in (-(2**0.5), 2**0.5) for y in (-1, 1)
    ]
    tangent = topology([v - 3 * (u**2 - 2) ** 2, v * (u - v + 3)], **BOX)
    assert [(float(n.u), float(n.v)) for n in tangent.nodes if n.kind == "node" and n.v.rational == 0] == [
        (-(2**0.5), 0), (2**0.5, 0)
    ]  # fmt: skip


def test_coordinates_and_signs_in_reversed_charts():
    turns = [n for n in topology((v + 3) ** 2 - u**3 + 2).nodes if n.kind == "extreme"]
    (turn,) = turns
    assert turn.chart == (True, True)
    assert turn.u.polynomial == fmpz_poly([-2, 0, 0, 1]) and turn.v.rational == -3
    assert [turn.sign(c) for c in (u, v, u * v, u**3 + v + 1, u**3 * v + 7, u - 1)] == [1, -1, -1, 0, 1, 1]
    assert turn.sign(10**30 * (u**3 + v + 1) + v) == -1


@pytest.mark.parametrize("w", [u, u**2 - 2])
def test_double_zeros_next_to_each_other(w):
    """Two turning points at distance 2e-30 over one u, rational and irrational."""
    f = (10**60 * v**2 - 1) ** 2 - w * (1 + v)
    graph = topology(f, (fmpq(-1), fmpq(2)), (fmpq(-1, 2), fmpq(1, 2)))
    folds = [n for n in graph.nodes if (n.kind, n.left, n.right) == ("extreme", 0, 2)]
    assert [n.v.rational * 10**30 for n in folds] == [-1, 1]
    check_incidence(graph)


def test_an_edge_passes_the_turning_points_of_others():
    """v^3 - 3v = u turns at (2, -1) and (-2, 1); the third branch passes, and is found there too."""
    graph = topology(v**3 - 3 * v - u, (fmpq(-3), fmpq(3)), (fmpq(-3), fmpq(3)))
    (passing,) = [e for e in graph.edges if e.limits[-1].rational == 3]
    assert [x.rational for x in passing.limits] == [-2, 2, 3]
    assert passing.at(fmpq(2)).rational == 2
    assert passing.at(fmpq(0)).polynomial == fmpz_poly([-3, 0, 1]) and [k for _, k in passing.slabs] == [2, 0]
    for outside in (fmpq(-2), fmpq(-5, 2), fmpq(3), fmpq(4)):
        with pytest.raises(ValueError):
            passing.at(outside)


def test_node_coordinates_are_exact():
    graph = topology((u**2 - 2) * (v**2 - u) * (v - 1), **BOX)
    crossings = sorted((float(n.u), float(n.v)) for n in graph.nodes if n.kind == "node")
    assert crossings == [(-(2**0.5), 1), (1, 1), (2**0.5, -(2**0.25)), (2**0.5, 1), (2**0.5, 2**0.25)]
    for node in graph.nodes:
        assert node.x_ball(80).overlaps(node.x.enclosure(80)) and node.y_ball(80).overlaps(node.y.enclosure(80))
        assert all(sign_at(graph.curves[i], node.u, node.v) == 0 for i in node.curves)
    (corner,) = [n for n in graph.nodes if float(n.v) == 2**0.25]
    assert corner.v.polynomial == fmpz_poly([-2, 0, 0, 0, 1])
    assert corner.sign(v**4 - 2) == 0 and corner.sign(v**2 + u) == 1 and corner.sign(10**40 * (v**2 - u) - 1) == -1


# bidegree (2, 5): two cylinders of a published example, with its u-extreme points
CURVE = polynomial(
    {
        (2, 4): 300, (2, 3): -1800, (2, 2): 3300, (2, 1): -1795, (2, 0): 295, (1, 5): 1, (1, 4): -6, (1, 3): 11,
        (1, 2): -16, (1, 1): -590, (0, 4): 300, (0, 3): -1800, (0, 2): 3300, (0, 1): -1805, (0, 0): -295,
    }
)  # fmt: skip


def test_published_curve_of_bidegree_2_5():
    graph = topology(CURVE)
    assert kinds(graph) == ["loop", "loop"]
    extreme = sorted(float(n.u) for n in graph.nodes if n.kind == "extreme")
    published = [-70.0772006, -2.982482751, -0.3812232383, -0.1356823218, 1.960965051, 200.1125027]
    assert extreme == pytest.approx(published, rel=1e-8)
    assert tally(graph, "extreme", "regular") == [6, 8]
    boxed = topology(CURVE, (fmpq(-1000), fmpq(1000)), (fmpq(-10), fmpq(10)))
    assert kinds(boxed) == ["arc", "arc"] and tally(boxed, "extreme") == [6]


def test_extras_cut_edges_where_their_sign_changes():
    clips = [u - 2 * v, u * v - 1, u**2 + v**2 - 1, v**2 - 2]
    graph = topology(u**2 + v**2 - 4, (fmpq(-3), fmpq(3)), (fmpq(-3), fmpq(3)), extras=[*clips, fmpz_poly([-1, 1])])
    assert kinds(graph) == ["loop"]
    for clip in clips:
        for edge in graph.edges:
            signs = set()
            lo, hi = edge.limits[0], edge.limits[-1]
            for k in range(1, 64):
                x = fmpq(k, 16) - 2
                if lo.compare(x) < 0 < hi.compare(x):
                    signs.add(edge.at(x).sign_of(restrict(clip, "u", x)))
            assert signs <= {edge.sign(clip)}
    assert edge.sign(u**2 + v**2 - 4) == 0
    zeros = [sum(n.sign(c) == 0 for n in graph.nodes) for c in clips]
    assert zeros == [2, 4, 0, 4]
    assert sum(n.x.rational == 1 for n in graph.nodes) == 2


def test_extras_at_infinity_and_on_the_borders_of_charts():
    graph = topology(u * v - 1, extras=[u - 4 * v, v - 1, u * 0 + u - 3])
    assert kinds(graph) == ["loop"]
    cuts = {(float(n.u), float(n.v)) for n in graph.nodes if n.u is not None and n.v is not None}
    assert cuts == {(2.0, 0.5), (-2.0, -0.5), (1.0, 1.0), (-1.0, -1.0), (3.0, 1 / 3)}
    graph = topology((u + 2 * v - 2) * (v - 1) * (v + 2), (fmpq(-2), fmpq(2)), (fmpq(-2), fmpq(1)), extras=[u - v, u])
    check_incidence(graph)
    on_border = sorted(float(n.u) for n in graph.nodes if n.v.rational == 1)
    assert on_border == [-2, 0, 1, 2]


def test_an_extra_may_be_a_border_of_charts():
    graph = topology(u * (u**2 - 3), extras=[v - 1, u * v + 1])
    assert kinds(graph) == ["loop"] * 3
    check_incidence(graph)
    cuts = [n for n in graph.nodes if n.sign(v - 1) == 0]
    assert sorted(float(n.u) for n in cuts) == [-(3**0.5), 0, 3**0.5]


def test_extras_cut_lines():
    graph = topology(u * (u**2 - 2), **BOX, extras=[u + v - 1, v**2 - 2, v - 1])
    assert all(e.vertical for e in graph.edges) and kinds(graph) == ["arc"] * 3
    cuts = [sorted(float(n.v) for n in graph.nodes if float(n.u) == x) for x in (-(2**0.5), 0.0, 2**0.5)]
    root = 2**0.5
    assert cuts[0] == pytest.approx([-2, -root, 1, root, 2])
    assert cuts[1] == pytest.approx([-2, -root, 1, root, 2])
    assert cuts[2] == pytest.approx([-2, -root, 1 - root, 1, root, 2])


def random_curve(generator: random.Random):
    def form(n, m, height, density=1.0):
        return polynomial(
            {
                (i, j): generator.randint(-height, height)
                for i in range(n + 1)
                for j in range(m + 1)
                if generator.random() < density
            }
        )

    kind = generator.randrange(6)
    if kind == 0:
        return form(generator.randint(1, 4), generator.randint(1, 4), 50)
    if kind == 1:
        return form(generator.randint(2, 4), generator.randint(2, 4), 2, 0.5)
    if kind == 2:
        return form(2, 2, 2, 0.6) * form(1, 2, 2, 0.6)
    if kind == 3:
        return form(2, 2, 2, 0.7).compose(u, v * v)
    if kind == 4:
        return form(1, 1, 1) * form(1, 1, 1) * form(1, 2, 1, 0.6)
    return form(2, 1, 2) ** 2 + generator.choice((1, -1, 0)) * form(1, 2, 2) ** 2 + form(1, 1, 1) ** 3


def swapped(f):
    return polynomial({(int(j), int(i)): c for (i, j), c in f.to_dict().items()})


def images(f):
    """The curve in other coordinates of P1 x P1: u and v swapped; -u, 1/u, u + 1, (u + 2) / (1 - u) for u."""
    n = int(f.degrees()[0])
    terms = {tuple(map(int, k)): c for k, c in f.to_dict().items()}
    yield swapped(f)
    yield polynomial({(i, j): c * (-1) ** i for (i, j), c in terms.items()})
    yield polynomial({(n - i, j): c for (i, j), c in terms.items()})
    yield f.compose(u + 1, v)
    yield sum((c * (u + 2) ** i * (1 - u) ** (n - i) * v**j for (i, j), c in terms.items()), u * 0)


def has_factor_in_one_variable(f) -> bool:
    found = factors(f)
    return bool(found.in_u or found.in_v)


@pytest.mark.share(15)
@pytest.mark.parametrize("seed", range(40))
def test_random_curves(seed):
    f = random_curve(random.Random(seed))
    if f.is_zero() or f.is_constant() or has_factor_in_one_variable(f):
        f = f + u * v**2 + u**2 * v + 1
    if has_factor_in_one_variable(f):
        f = f * (u * v - 3) + u**3 * v - 1
    assert not has_factor_in_one_variable(f)
    graph = topology(f)
    expected = invariants(graph)
    for image in images(f):
        assert invariants(topology(image)) == expected
    box = ((fmpq(-2), fmpq(1)), (fmpq(-1), fmpq(3)))
    boxed = topology(f, *box)
    assert invariants(boxed) == invariants(topology(swapped(f), box[1], box[0]))
    assert invariants(topology(f, box[0], None)) == invariants(topology(swapped(f), None, box[0]))
    check_incidence(graph)
    check_counts(graph, f, None)
    check_counts(boxed, f, box)


def check_counts(graph: Graph, f, box) -> None:
    """On sampled lines u = x: as many edges as certified complex roots say, and each at one of these roots."""
    for k in range(-8, 9):
        x = fmpq(k) / 3 + fmpq(1, 97)
        if box is not None and not box[0][0] < x < box[0][1]:
            continue
        p = restrict(f, "u", x)
        roots = [z.real for z, _ in p.complex_roots() if z.imag == 0]
        if box is not None:
            roots = [z for z in roots if z > box[1][0] and z < box[1][1]]
        met = 0
        for edge in graph.edges:
            assert isinstance(edge, RootEdge)
            at = 1 / x if edge.chart[0] else x
            if edge.limits[0].compare(at) < 0 < edge.limits[-1].compare(at):
                y = edge.at(at)
                root = reciprocal(y) if edge.chart[1] else y
                assert root is not None and sum(z.overlaps(root.enclosure(40)) for z in roots) == 1
                met += 1
        assert met == len(roots)


def test_two_double_zeros_over_numbers_of_high_degree():
    """Even in v: critical fibres have two double zeros; over numbers of degree 16 the exact decomposition decides."""
    generator = random.Random(7)
    f = polynomial({(i, 2 * j): generator.randint(-99, 99) for i in range(5) for j in range(4)})
    graph = topology(f)
    extreme = [n for n in graph.nodes if n.kind == "extreme" and n.x.polynomial.degree() == 16]
    assert extreme and all(sum(n.x is other.x for other in extreme) == 2 for n in extreme)
    assert invariants(graph) == invariants(topology(swapped(f)))
    check_counts(graph, f, None)


def test_bad_ranges_and_the_zero_polynomial():
    with pytest.raises(ValueError):
        topology(u, (fmpq(1), fmpq(1)), None)
    with pytest.raises(ValueError):
        topology(u * 0)
