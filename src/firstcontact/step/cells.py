"""Solids of planes, cylinders, cones, spheres and tori as pieces with these very surfaces.

What is next to tori is cut off first, see `rounds`; the solid here is the rest.

The box around a solid is halved until few surfaces have faces in a cell.  In a cell the solid is a tree of decisions:
on which side of a surface a point is, until no face is left between what may be inside and what may not.  Faces that
meet smoothly are parted by the plane across them through their seam.  Which side is the solid is asked of OpenCASCADE;
that nothing is lost, and nothing added, is asked again of many points afterwards, and of all edges of the pieces.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from firstcontact.body.solid.carriers import (
    Plane,
    Quadric,
    QuarticCurve,
    Surface,
    Vector,
    doubles,
    primitive,
)
from firstcontact.body.solid.composite_quadric import CompositeQuadric, _key
from firstcontact.body.solid.csg import And, Leaf, Not, Or, Tree, conjunction, renumbered, surfaces_of
from firstcontact.body.solid.intersections import common_curves
from firstcontact.body.solid.regions import halved, parts
from firstcontact.errors import InputError
from firstcontact.exact.numbers import exact_value
from firstcontact.step.asking import Asking
from firstcontact.step.carriers import Carrier, NotExact, carrier_of, is_on_torus, plane, through_tips
from firstcontact.step.rims import rims
from firstcontact.step.rough import Rough, rough
from firstcontact.step.rounds import TANGENT, AskingRest, TorusRound, joined
from firstcontact.step.solids import StepSolid
from firstcontact.step.trims import Trims

if TYPE_CHECKING:
    from OCP.gp import gp_Dir, gp_Pnt

FEW, MOST, DEEPEST = 6, 26, 9
"""Surfaces in a cell: what is asked for, and what is taken where halving does not help; how often cells are halved."""
SHARES, MIDDLE = np.array([0.5, 0.4375, 0.5625, 0.375, 0.625]), 0.26
"""Of a cell: where a wall may halve it, beside the places between faces; and how far from the middle at most."""
SURELY, CLOSELY = 1e-6, 1e-9
"""Of the solid's size: how far a point is from a surface whose side counts; and what an edge is off by rounding."""
TIPS = 1e-12
"""Of the solid's size: how far a plane passes a tip that goes through it."""
OFF = 2e-4
"""Of the solid's size: how far from a face the points are of which one is inside and one outside."""
RANDOM = 24
"""Points of a cell at first that are asked of OpenCASCADE."""
ROOM = 1e-3
"""Of the solid's size: how far the walls of the outermost cells are from it."""
ROUGH = 2e-3
ROUNDS, NEAR, MOST_SAMPLES, EDGE_POINTS = 6, 8, 4000, 9
"""How often pieces are corrected; points in each cell, and next to faces, that are asked each time; and on edges."""
ROUND = -1
"""Instead of a carrier's number, of faces on tori."""
ENOUGH, HALVINGS = 12, 4
"""Points of a face in a cell, below which it is looked at again; how often the cell is halved for that."""
MOST_OFF = 1e-4
"""Of the solid's size: how far the file's edges may be from where surfaces meet."""


@dataclass
class SolidCell:
    """body: of the solid in the box; own: of each of its surfaces the faces of the file that lie on it."""

    body: CompositeQuadric
    own: list[tuple[int, ...]]
    box: tuple[np.ndarray, np.ndarray]


@dataclass
class _Problem:
    """surfaces: carriers, then planes to cut by, with forms; nappes: of those that are cones, which of theirs count.
    sheets: of carriers those that stand for rounds, with the planes where these end, which decide first: beyond them a
    sheet is all but where other faces are.

    samples (n, 3) on faces of carriers `carrier` (n,), with outward normals, and up to which depth points on both sides
    are as these tell; labelled points (m, 3), whether each is inside.
    """

    solid: StepSolid
    cut: Rough
    surfaces: list[Surface]
    nappes: dict[int, Carrier]
    forms: np.ndarray
    round_: np.ndarray
    carriers: int
    sheets: dict[int, set[int]]
    of_face: list[int]
    faces_on: list[tuple[int, ...]]
    samples: np.ndarray
    normals: np.ndarray
    carrier: np.ndarray
    labelled: np.ndarray
    inside: np.ndarray
    depth: np.ndarray
    asking: Asking | AskingRest
    trims: Trims
    rounds: list[TorusRound]
    rng: Any = field(default_factory=lambda: np.random.default_rng(0))

    def distances(self, points: np.ndarray, near: Sequence[int] | None = None) -> np.ndarray:
        """(surfaces, n) signed distances, to first order, of those surfaces that are near, else 0; of cones positive on
        the side of the other nappe."""
        found = np.zeros((len(self.surfaces), len(points)))
        own = np.arange(len(self.surfaces)) if near is None else np.array(near, int)
        found[own] = _distances(self.forms[own], points, self.round_[own])
        for k in set(own.tolist()) & self.nappes.keys():
            carrier = self.nappes[k]
            assert carrier.nappe is not None
            n = np.array(doubles((carrier.nappe.normal,))[0])
            found[k] = np.maximum(found[k], (points @ n[:3] + n[3]) / np.linalg.norm(n[:3]))
        return found

    def passing(self, lo: np.ndarray, hi: np.ndarray) -> list[int]:
        """The surfaces that pass a box, or may do so."""
        x, h = np.append(0.5 * (lo + hi), 1.0), np.append(0.5 * (hi - lo), 0.0) * 1.000001
        image, sizes = self.forms @ x, np.abs(self.forms)
        spread = 2.0 * np.abs(image) @ h + (sizes @ h) @ h + 1e-12 * (sizes @ np.abs(x)) @ np.abs(x)
        return [int(k) for k in np.flatnonzero(np.abs(image @ x) <= spread)]


def _round(forms: np.ndarray) -> np.ndarray:
    """Of each form the coefficient of the square of the distance from the axis: the middle eigenvalue is across it."""
    found: np.ndarray = np.abs(np.linalg.eigvalsh(forms[:, :3, :3])[:, 1:2])
    return found


def _distances(forms: np.ndarray, points: np.ndarray, round_: np.ndarray) -> np.ndarray:
    return np.concatenate([_near_ones(forms, points[k], round_) for k in parts(len(points), len(forms))], axis=1)


def _near_ones(forms: np.ndarray, points: np.ndarray, round_: np.ndarray) -> np.ndarray:
    x = np.vstack([points.T, np.ones(len(points))])
    image = (forms.reshape(-1, 4) @ x).reshape(len(forms), 4, len(points))
    value = (image * x).sum(axis=1)
    slope = 2.0 * np.sqrt((image[:, :3] ** 2).sum(axis=1))
    # |radius^2 - r^2| = c is |radius - r| <= sqrt(c), which is less near the tip of a cone, where the slope vanishes
    with np.errstate(over="ignore"):  # of planes, which are round nowhere
        nearer = np.sqrt(np.abs(value) / np.maximum(round_, 1e-300))
        found: np.ndarray = np.sign(value) * np.minimum(np.abs(value) / np.maximum(slope, 1e-300), nearer)
    return found


@dataclass(frozen=True)
class Cut:
    """A solid as pieces: cells, and rounds, whose sectors are others; off: how far their edges are from the file's."""

    cells: list[SolidCell]
    rounds: list[TorusRound]
    off: float
    rough: Rough


def cells_of(solid: StepSolid, most: int | None = None) -> Cut:
    """Raises NotExact.

    most: pieces that may be made, those that are made again counted anew.

    Points of all kinds are put to the pieces and to OpenCASCADE; what is learned of those of which they think
    differently, and of those around edges that the file has not, goes into the pieces, until none is left.
    """
    problem = _problem(solid)
    off = _off_at_edges(problem)
    if off > MOST_OFF * solid.size:
        raise NotExact(f"its edges are up to {off:.2g} off the surfaces that meet there")
    if not len(problem.samples):
        return Cut([], problem.rounds, off if problem.carriers else problem.rounds[0].askew, problem.cut)
    lo, hi = solid.box
    room = ROOM * solid.size
    boxes = list(_boxes(problem, _even(lo - room, solid.size), _even(hi + room, solid.size), 0))
    solved: list[SolidCell | None] = [None] * len(boxes)
    todo = list(range(len(boxes)))
    doubtful, near, made = set(todo), dict[int, float](), 0
    for _ in range(ROUNDS):
        made += len(todo)
        if most is not None and made > most:
            raise NotExact(f"it takes more than {most} pieces")
        for k in todo:
            solved[k] = _solved(problem, *boxes[k])
            doubtful.add(k)
        cells = [cell for cell in solved if cell is not None]
        points, inside = _asked(problem, boxes)
        wrong = contains(cells, points) != inside
        points, inside = points[wrong], inside[wrong]
        if not wrong.any():
            asked = {k: cell for k in sorted(doubtful) if (cell := solved[k]) is not None}
            found, thin = _strays(problem, asked, off)
            near |= thin
            doubtful = {k for k, strays in found.items() if len(strays)}
            if not doubtful:
                return Cut(cells, problem.rounds, max([off, *near.values()]), problem.cut)
            points = np.concatenate([found[k] for k in sorted(doubtful)])
            points, inside = _around(problem, points)
        problem.labelled = np.concatenate([problem.labelled, points])
        problem.inside = np.concatenate([problem.inside, inside])
        todo = [k for k, (a, b) in enumerate(boxes) if ((points >= a) & (points <= b)).all(axis=1).any()]
    raise NotExact(f"near {points[0].round(4).tolist()} its pieces are not as OpenCASCADE has them")


def _strays(
    problem: _Problem, cells: dict[int, SolidCell], off: float
) -> tuple[dict[int, np.ndarray], dict[int, float]]:
    """Of each cell (n, 3) points of its edges and vertices, not in walls alone, that are not on the file's faces; and
    how far others are from these at most.

    What is added to the solid, or lost, has such edges, however narrow it is, unless all of them are the file's.  Too
    thin to be cut away, it stays.
    """
    thin, surely = 2.0 * off + SURELY * problem.solid.size, 2.0 * off + CLOSELY * problem.solid.size
    near = dict.fromkeys(cells, 0.0)
    points, group, groups, owner = [np.empty((0, 3))], [np.empty(0, int)], list[tuple[int, ...]](), list[int]()
    for k, cell in cells.items():
        for pairs, here in rims(cell.body, *cell.box, 6):
            known, which = np.unique(pairs[:, 0] * len(cell.own) + pairs[:, 1], return_inverse=True)
            points.append(here)
            group.append(len(groups) + which)
            groups += [cell.own[pair // len(cell.own)] + cell.own[pair % len(cell.own)] for pair in known.tolist()]
            owner += [k] * len(known)
    all_, of = np.concatenate(points), np.concatenate(group)
    found: dict[int, list[list[float]]] = {k: [] for k in cells}
    for n in np.flatnonzero(problem.trims.outside(all_, of, groups)).tolist():
        point, k = all_[n].tolist(), owner[of[n]]
        far = problem.asking.off_faces(point, surely)
        if far > thin:
            found[k].append(point)
        else:
            near[k] = max(near[k], far)
    return {k: np.array(own).reshape(-1, 3) for k, own in found.items()}, near


def _around(problem: _Problem, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points near to these, and which of them are inside."""
    spread = problem.solid.size * np.array([0.1 * OFF, OFF, 10.0 * OFF, 100.0 * OFF])
    around = points[:, None, None] + spread[:, None, None] * problem.rng.normal(size=(len(points), len(spread), 6, 3))
    around = around.reshape(-1, 3)
    return around, problem.asking.inside(around)


def _asked(problem: _Problem, boxes: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """New points, and which of them are inside: anywhere, next to carriers anywhere in a cell and to walls between
    cells, on both sides, asked of OpenCASCADE; and on both sides of faces."""
    rng, size = problem.rng, problem.solid.size
    found = []
    for lo, hi in boxes:
        random = rng.uniform(lo, hi, (NEAR, 3))
        here = ((problem.samples >= lo) & (problem.samples <= hi)).all(axis=1)
        on = [_pulled(problem.forms[k], random) for k in sorted(set(problem.carrier[here].tolist()))]
        axis = rng.integers(0, 3, NEAR)
        wall = random.copy()
        wall[np.arange(NEAR), axis] = np.where(rng.random(NEAR) < 0.5, lo[axis], hi[axis])
        flat = np.concatenate([*on, wall]) if on else wall
        flat = flat[((flat >= lo) & (flat <= hi)).all(axis=1)]
        found += [random, flat + rng.normal(0.0, OFF * size, flat.shape)]
    asked = np.concatenate(found)
    known = rng.permutation(len(problem.samples))[:MOST_SAMPLES]
    shares = 10.0 ** rng.uniform(-5.5, np.log10(OFF), len(known)) / OFF
    step = problem.normals[known] * (problem.depth[known] * shares)[:, None]
    told = problem.asking.inside(asked)
    sure = np.abs(problem.distances(asked, range(problem.carriers))[: problem.carriers]).min(axis=0) > 1e-7 * size
    points = np.concatenate([asked[sure], problem.samples[known] - step, problem.samples[known] + step])
    inside = np.concatenate([told[sure], np.ones(len(known), bool), np.zeros(len(known), bool)])
    return points, inside


def _pulled(form: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The points on a surface near them, as far as a few steps go."""
    for _ in range(4):
        x = np.column_stack([points, np.ones(len(points))])
        image = x @ form
        slope = 2.0 * image[:, :3]
        square = np.maximum((slope**2).sum(axis=1), 1e-300)
        points = points - (np.einsum("ni,ni->n", image, x) / square)[:, None] * slope
    return points


def _off_at_edges(problem: _Problem) -> float:
    """How far the file's edges are from where the surfaces on their sides meet, to first order."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    solid, worst, seams = problem.solid, 0.0, set[tuple[int, int]]()
    tubes = [tube for each in problem.rounds for tube in (each, each.bore) if tube is not None]
    for number, edge in enumerate(solid.edges):
        if solid.is_degenerate(number):
            continue
        curve = BRepAdaptor_Curve(edge)
        times = np.linspace(curve.FirstParameter(), curve.LastParameter(), EDGE_POINTS)
        points = np.array([_numbers(curve.Value(float(t))) for t in times])
        beside = solid.incidence[0][number]
        own = sorted({problem.of_face[face] for face in beside} - {ROUND})
        rounds = [each for each in tubes if beside & set(each.numbers)]
        off = np.abs(_distances(problem.forms[own], points, problem.round_[own])).sum(axis=0)
        off = off + sum(each.distances(points) for each in rounds)
        if len(own) + len(rounds) == 2:
            x = np.column_stack([points, np.ones(len(points))])
            n = np.einsum("sij,nj->sni", problem.forms[own], x)[..., :3]
            n = np.concatenate([n, *(each.directions(points)[None] for each in rounds)])
            n /= np.maximum(np.linalg.norm(n, axis=2, keepdims=True), 1e-300)
            sine = np.linalg.norm(np.cross(n[0], n[1]), axis=1)
            if len(own) == 2 and (sine <= TANGENT).any():
                seams.add((own[0], own[1]))
            off = np.where(sine > TANGENT, off / np.maximum(sine, TANGENT), off)
        worst = max(worst, float(off.max()))
    worst += max((each.askew for each in tubes), default=0.0)
    for i, j in seams:
        curves = common_curves(problem.surfaces[i], problem.surfaces[j])
        if any(isinstance(curve, QuarticCurve) for curve in curves):  # a conic, twice, but for rounding errors
            raise NotExact("surfaces that are tangent but for rounding errors")
    return worst * (1.0 + 1e-6)


def _even(x: np.ndarray, size: float) -> np.ndarray:
    """Numbers of few binary digits near to them, as a solid of that size goes."""
    scale = 2.0 ** (14 - np.ceil(np.log2(size)))
    found: np.ndarray = np.round(x * scale) / scale
    return found


# -- what is asked ------------------------------------------------------------------------------------------------


def _problem(solid: StepSolid) -> _Problem:
    known = _Carriers()
    of_face, rounds = list[int](), list[TorusRound]()
    carriers = through_tips([carrier_of(face) for face in solid.faces], TIPS * solid.size)
    for number, (face, carrier) in enumerate(zip(solid.faces, carriers, strict=True)):
        if carrier is not None:
            of_face.append(known.number(carrier))
            known.faces_on[of_face[-1]] += (number,)
            continue
        if not is_on_torus(face):
            face_ = solid.named("face", number)
            raise NotExact(f"{face_} is on no plane, cylinder, sphere, torus or single nappe of a cone")
        of_face.append(ROUND)
        rounds.append(TorusRound(solid, number))
    asking, rounds = Asking(solid), joined(rounds)
    told = _sheets(rounds, known, of_face, asking)
    surfaces, count = known.surfaces, len(known.surfaces)
    sheets = dict[int, set[int]]()
    for each, k, *_ in told:
        if set(each.numbers) & set(known.faces_on[k]):
            ends = (plane(out, each.chart.origin) for _, out in each.ways_out())
            sheets.setdefault(k, set()).update(map(known.number, ends))
    for cut_plane in _cuts(solid, surfaces, of_face):
        if known.numbers.setdefault((_key(cut_plane), None), len(surfaces)) == len(surfaces):
            surfaces.append(cut_plane)
    forms = np.array([doubles(s.matrix()) for s in surfaces]).reshape(-1, 4, 4)
    cut = rough(solid, ROUGH * solid.size)
    samples, faces = _samples(solid, cut, forms, of_face)
    trims = Trims(solid)
    own = _in_faces(solid, trims, forms[:count], samples, faces, of_face)
    samples, faces = samples[own], faces[own]
    normals = _outward(solid, forms, samples, faces, of_face)
    off = OFF * solid.size
    on = np.array(of_face)[faces]
    depth = _depths(forms[:count], samples, normals, on, off)
    for each in rounds:  # ends of bent tubes
        own = ~each.removed(samples - off * normals)
        samples, normals, on, depth = samples[own], normals[own], on[own], depth[own]
    for each, k, x, n in told:
        samples, normals = np.concatenate([samples, x]), np.concatenate([normals, n])
        on, depth = np.append(on, np.full(len(x), k)), np.append(depth, np.full(len(x), min(off, each.depth)))
    labelled = np.concatenate([samples - depth[:, None] * normals, samples + depth[:, None] * normals])
    inside = np.repeat([True, False], len(samples))
    trims.faces |= {number: each for each in rounds for number in each.numbers}
    return _Problem(
        solid, cut, surfaces, known.nappes, forms, _round(forms), count, sheets, of_face, known.faces_on,
        samples, normals, on, labelled, inside, depth, AskingRest(asking, rounds) if rounds else asking, trims, rounds,
    )  # fmt: skip


class _Carriers:
    """Surfaces, each once; nappes: of cones; faces_on: of each the file's faces."""

    def __init__(self) -> None:
        self.surfaces: list[Surface] = []
        self.nappes: dict[int, Carrier] = {}
        self.numbers: dict[tuple[Any, ...], int] = {}
        self.faces_on: list[tuple[int, ...]] = []

    def number(self, carrier: Carrier) -> int:
        k = self.numbers.setdefault((_key(carrier.surface), carrier.nappe), len(self.surfaces))
        if k == len(self.surfaces):
            self.surfaces.append(carrier.surface)
            self.faces_on.append(())
            if carrier.nappe is not None:
                self.nappes[k] = carrier
        return k


def _sheets(
    rounds: list[TorusRound], known: _Carriers, of_face: list[int], asking: Asking
) -> list[tuple[TorusRound, int, np.ndarray, np.ndarray]]:
    """What bounds the rest instead of faces on tori: carriers, points, and normals.  Raises NotExact."""
    rng, found = np.random.default_rng(0), []
    for each in rounds:
        each.fit(asking, rng, {face: known.surfaces[k] for face, k in enumerate(of_face) if k != ROUND})
        for sheet in each.sheets():
            k = known.number(each.carrier(sheet)) if sheet.beside is None else of_face[sheet.beside]
            if sheet.beside is None and not set(each.numbers) & set(known.faces_on[k]):
                known.faces_on[k] += each.numbers
            found.append((each, k, *each.samples(sheet)))
    rest = AskingRest(asking, rounds)
    for each in (x for x in rounds if x.around is None):
        found += [(each, known.number(carrier), x, n) for carrier, x, n in each.caps(rest)]
    return found


def _samples(solid: StepSolid, cut: Rough, forms: np.ndarray, of_face: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Points inside faces, on their carriers, and the faces' numbers."""
    flat = np.array(of_face)[cut.face_of] != ROUND
    corners, owner = cut.corners[flat], cut.face_of[flat]
    step = 0.04 * solid.size
    for _ in range(12):
        sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
        wide = sides.max(axis=1) > step
        if not wide.any() or len(corners) > 40_000:
            break
        rows = np.flatnonzero(wide)
        at = sides[rows].argmax(axis=1)
        a, b, c = (corners[rows, (at + k) % 3] for k in range(3))
        middle = 0.5 * (a + b)
        corners = np.concatenate([corners[~wide], np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
        owner = np.concatenate([owner[~wide], owner[rows], owner[rows]])
    points = corners.mean(axis=1)
    for _ in range(4):
        x = np.column_stack([points, np.ones(len(points))])
        image = np.einsum("nij,nj->ni", forms[np.array(of_face)[owner]], x)
        value, slope = np.einsum("ni,ni->n", image, x), 2.0 * image[:, :3]
        points = points - (value / np.maximum((slope**2).sum(axis=1), 1e-300))[:, None] * slope
    return points, owner


def _in_faces(
    solid: StepSolid, trims: Trims, forms: np.ndarray, points: np.ndarray, faces: np.ndarray, of_face: list[int]
) -> np.ndarray:
    """(n,) which of the points of carriers are in their faces: middles of triangles along a bent border may not be."""
    off = np.abs(_distances(forms, points, _round(forms)))
    off[np.array(of_face)[faces], np.arange(len(points))] = np.inf
    doubtful = np.flatnonzero(off.min(axis=0, initial=np.inf) < 2.0 * ROUGH * solid.size)
    found = np.ones(len(points), bool)
    found[doubtful] = ~trims.outside(points[doubtful], faces[doubtful], [(k,) for k in range(len(solid.faces))])
    return found


def _outward(
    solid: StepSolid, forms: np.ndarray, points: np.ndarray, faces: np.ndarray, of_face: list[int]
) -> np.ndarray:
    """Unit normals at points of faces, away from the solid: by the normal that the file's face has there."""
    from OCP.BRep import BRep_Tool
    from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
    from OCP.GeomLProp import GeomLProp_SLProps
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_Orientation

    x = np.column_stack([points, np.ones(len(points))])
    slope = np.einsum("nij,nj->ni", forms[np.array(of_face)[faces]], x)[:, :3]
    normals: np.ndarray = slope / np.maximum(np.linalg.norm(slope, axis=1), 1e-300)[:, None]
    for number, face in enumerate(solid.faces):
        own = np.flatnonzero(faces == number)
        if not len(own):
            continue
        surface = BRep_Tool.Surface_s(face)
        found = GeomAPI_ProjectPointOnSurf(gp_Pnt(*points[own[0]].tolist()), surface)
        u, v = found.LowerDistanceParameters()
        at = GeomLProp_SLProps(surface, u, v, 1, 1e-9).Normal()
        n = np.array([at.X(), at.Y(), at.Z()])
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            n = -n
        if n @ normals[own[0]] < 0.0:
            normals[own] *= -1.0
    return normals


def _depths(forms: np.ndarray, points: np.ndarray, normals: np.ndarray, on: np.ndarray, off: float) -> np.ndarray:
    """(n,) how far one may go from points of carriers `on`, up to `off`, and cross no other one: next to an edge in
    which the solid is hollow it is inside beyond that."""
    round_, own = _round(forms), on == np.arange(len(forms))[:, None]
    here, share = _distances(forms, points, round_), np.ones(len(points))
    for way in (-off, off):
        there = _distances(forms, points + way * normals, round_)
        crossed = ~own & (here * there < 0.0)
        shares = np.where(crossed, here / np.where(crossed, here - there, 1.0), 1.0)
        share = np.minimum(share, shares.min(axis=0, initial=1.0))
    found: np.ndarray = np.where(share < 1.0, 0.5 * share, 1.0) * off
    return found


def _cuts(solid: StepSolid, surfaces: list[Surface], of_face: list[int]) -> Iterator[Surface]:
    """Planes through edges: of circles their own, of seams the one across both faces, else the two between them."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_CurveType as Kind

    forms = np.array([doubles(s.matrix()) for s in surfaces]).reshape(-1, 4, 4)
    beside = [{of_face[face] for face in faces} - {ROUND} for faces in solid.incidence[0]]
    for number, edge in enumerate(solid.edges):
        if solid.is_degenerate(number):
            continue
        curve = BRepAdaptor_Curve(edge)
        if curve.GetType() == Kind.GeomAbs_Circle:
            axis = curve.Circle().Axis()
            yield plane(_numbers(axis.Direction()), _numbers(axis.Location())).surface
        elif curve.GetType() == Kind.GeomAbs_Line and len(beside[number]) == 2:
            middle = _numbers(curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter())))
            x = np.append(middle, 1.0)
            a, b = (n / np.linalg.norm(n) for n in ((forms[k] @ x)[:3] for k in beside[number]))
            along = _numbers(curve.Line().Direction())
            if np.linalg.norm(np.cross(a, b)) < TANGENT:
                yield plane(np.cross(along, a), middle).surface
            elif any(isinstance(surfaces[k], Quadric) for k in beside[number]):
                yield plane(np.cross(along, a + b), middle).surface
                yield plane(np.cross(along, a - b), middle).surface


def _numbers(p: gp_Pnt | gp_Dir) -> np.ndarray:
    return np.array([p.X(), p.Y(), p.Z()])


# -- cells --------------------------------------------------------------------------------------------------------


def _boxes(
    problem: _Problem, lo: np.ndarray, hi: np.ndarray, depth: int
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Those of the cells."""
    here = ((problem.samples >= lo) & (problem.samples <= hi)).all(axis=1)
    near = set(problem.carrier[here].tolist())
    if len(near) > FEW and depth < DEEPEST:
        axis, at = _halving(problem, lo, hi)
        upper, lower = lo.copy(), hi.copy()
        upper[axis] = lower[axis] = at
        yield from _boxes(problem, lo, lower, depth + 1)
        yield from _boxes(problem, upper, hi, depth + 1)
        return
    if len(near) > MOST:
        raise NotExact(f"{len(near)} surfaces come together in one place")
    yield lo, hi


def _halving(problem: _Problem, lo: np.ndarray, hi: np.ndarray) -> tuple[int, float]:
    """The axis and the place of a wall, which runs along no face."""
    axis = int((hi - lo).argmax())
    width = float(hi[axis] - lo[axis])
    flat = []
    for surface in problem.surfaces[: problem.carriers]:
        if isinstance(surface, Plane):
            n = np.array(doubles((surface.normal,))[0])
            if np.abs(n[:3]).argmax() == axis and np.delete(np.abs(n[:3]), axis).max() < 1e-6 * abs(n[axis]):
                flat.append(-n[3] / n[axis])
    here = ((problem.samples >= lo) & (problem.samples <= hi)).all(axis=1)
    at, carrier = problem.samples[here, axis], problem.carrier[here]
    ends = np.array([(at[carrier == k].min(), at[carrier == k].max()) for k in np.unique(carrier)])
    edges = np.sort(ends.ravel())
    shares = np.concatenate([SHARES, (0.5 * (edges[1:] + edges[:-1]) - lo[axis]) / width])
    places = _even(lo[axis] + shares[np.abs(shares - 0.5) < MIDDLE] * width, width)
    gaps = [min((abs(x - f) for f in flat), default=width) for x in places.tolist()]
    cut = ((ends[:, 0] < places[:, None]) & (places[:, None] < ends[:, 1])).sum(axis=1)
    middle = 0.5 * (lo[axis] + hi[axis])
    best = min(range(len(places)), key=lambda k: (gaps[k] <= 0.02 * width, cut[k], abs(places[k] - middle)))
    return axis, float(places[best])


def _solved(problem: _Problem, lo: np.ndarray, hi: np.ndarray) -> SolidCell | None:
    """The solid in a cell, None where there is none of it."""
    here = ((problem.samples >= lo) & (problem.samples <= hi)).all(axis=1)
    near = problem.passing(lo, hi)
    more, of, beside = _missed(problem, lo, hi, near, problem.carrier[here])
    samples, carrier = np.concatenate([problem.samples[here], more]), np.append(problem.carrier[here], of)
    asked = np.concatenate([problem.rng.uniform(lo, hi, (RANDOM, 3)), beside])
    own = ((problem.labelled > lo) & (problem.labelled < hi)).all(axis=1)
    points = np.concatenate([problem.labelled[own], asked])
    inside = np.concatenate([problem.inside[own], problem.asking.inside(asked)])
    task = _Task(problem, near, problem.distances(samples, near), carrier, problem.distances(points, near), inside)
    tree = task.tree(np.ones(len(samples), bool), np.ones(len(points), bool), frozenset(), 0)
    if tree is False:
        return None
    used = [] if isinstance(tree, bool) or tree is None else sorted(surfaces_of(tree))
    surfaces, leaves = _Surfaces(), {}
    for k in used:
        cone = problem.nappes.get(k)
        leaves[k] = surfaces.leaf(problem.surfaces[k], problem.faces_on[k] if k < problem.carriers else ())
        if cone is not None and cone.beyond(lo, hi):
            assert cone.nappe is not None
            leaves[k] = And(leaves[k], surfaces.leaf(cone.nappe))
    whole: Tree = conjunction([surfaces.leaf(wall) for wall in _walls(lo, hi)])
    if used:
        assert tree is not None and not isinstance(tree, bool)
        whole = And(renumbered(tree, [leaves.get(k, Leaf(0)) for k in range(len(problem.surfaces))]), whole)
    corners = tuple(tuple(exact_value(x) for x in side.tolist()) for side in (lo, hi))
    at = next((tuple(exact_value(x) for x in p) for p in points[inside][:1].tolist()), None)
    try:
        body = CompositeQuadric(surfaces.known, whole, box=corners, witness=at)  # type: ignore[arg-type]
    except InputError:
        return None
    return SolidCell(body, surfaces.faces, (lo, hi))


def _missed(
    problem: _Problem, lo: np.ndarray, hi: np.ndarray, near: list[int], carrier: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of faces of which a cell has little more than a corner, their carriers, and points on both sides."""
    found, of, beside = [np.empty((0, 3))], [np.empty(0, int)], [np.empty((0, 3))]
    for k in near:
        if k >= problem.carriers or (carrier == k).sum() >= ENOUGH:
            continue
        points = problem.trims.within(_on_surface(problem.forms[k], lo, hi), problem.faces_on[k])
        x = np.column_stack([points, np.ones(len(points))])
        normal = (x @ problem.forms[k])[:, :3]
        step = OFF * problem.solid.size * normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        found.append(points)
        of.append(np.full(len(points), k))
        beside += [points[:ENOUGH] - step[:ENOUGH], points[:ENOUGH] + step[:ENOUGH]]
    return np.concatenate(found), np.concatenate(of), np.concatenate(beside)


def _on_surface(form: np.ndarray, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """(n, 3) points of a surface in a box, all over it."""
    centre, half = (0.5 * (lo + hi))[None], 0.5 * (hi - lo)
    for _ in range(HALVINGS):
        centre, half = halved(centre, half)
        x, h = np.column_stack([centre, np.ones(len(centre))]), np.append(half, 0.0)
        image = x @ form
        spread = 2.0 * np.abs(image) @ h + (np.abs(form) @ h) @ h
        centre = centre[np.abs(np.einsum("ni,ni->n", image, x)) <= spread]
    points = _pulled(form, centre)
    found: np.ndarray = points[((points >= lo) & (points <= hi)).all(axis=1)]
    return found


def _walls(lo: np.ndarray, hi: np.ndarray) -> Iterator[Plane]:
    for axis in range(3):
        for sign, side in ((-1, lo), (1, hi)):
            n = [exact_value(sign * (i == axis)) for i in range(3)]
            yield Plane(primitive((*n, -sign * exact_value(float(side[axis])))))


class _Surfaces:
    """The surfaces of a piece, each once; faces: of each the file's on it."""

    def __init__(self) -> None:
        self.known: list[Surface] = []
        self.faces: list[tuple[int, ...]] = []
        self.numbers: dict[Vector, int] = {}

    def leaf(self, surface: Surface, faces: tuple[int, ...] = ()) -> Tree:
        """Where its form is <= 0."""
        k = self.numbers.setdefault(_key(surface), len(self.known))
        if k == len(self.known):
            self.known.append(surface)
            self.faces.append(())
        self.faces[k] += faces
        return Leaf(k) if self.known[k] == surface else Not(Leaf(k))


@dataclass
class _Task:
    """A cell: the surfaces near it, and signed distances from them of samples (surfaces, n) and labelled points."""

    problem: _Problem
    near: list[int]
    samples: np.ndarray
    carrier: np.ndarray
    points: np.ndarray
    inside: np.ndarray

    def tree(
        self, faces: np.ndarray, points: np.ndarray, used: frozenset[int], depth: int
    ) -> Tree | bool | None:
        """What is inside of a region, of which `faces` and `points` are told; None where nothing is known of it."""
        sure = SURELY * self.problem.solid.size
        if depth > 24:
            raise NotExact("its faces are too entangled")
        crossing = sorted(set(self.carrier[faces].tolist()) - used)
        if not crossing:
            labels = self.inside[points]
            if len(labels) == 0:
                return None
            if labels.all() or not labels.any():
                return bool(labels[0])
            crossing = self._parting(points, used)
        best = min(crossing, key=lambda k: self._cost(k, faces, points, used))
        first = sorted((self.problem.sheets.get(best, set()) & set(self.near)) - used)
        best = first[0] if first else best
        below, above = (
            self.tree(
                faces & (sign * self.samples[best] > sure) & (self.carrier != best),
                points & (sign * self.points[best] > 0.0), used | {best}, depth + 1,
            )
            for sign in (-1.0, 1.0)
        )  # fmt: skip
        return _joined(best, below, above)

    def _cost(self, k: int, faces: np.ndarray, points: np.ndarray, used: frozenset[int]) -> tuple[int, bool, int]:
        """How many faces a surface cuts in two, whether it is curved, and how badly it parts what is inside."""
        sure = SURELY * self.problem.solid.size
        own = self.samples[k][faces]
        carriers = self.carrier[faces]
        cut = sum(
            1 for c in set(carriers.tolist()) - {k}
            if (own[carriers == c] > sure).any() and (own[carriers == c] < -sure).any()
        )  # fmt: skip
        return cut, isinstance(self.problem.surfaces[k], Quadric), k

    def _parting(self, points: np.ndarray, used: frozenset[int]) -> list[int]:
        """The cut that parts inside from outside best; a sheet, which beside its end is all but where a face is, where
        nothing else does."""
        labels = self.inside[points]
        scores = []
        for k in self.near:
            if k in used:
                continue
            side = self.points[k][points] < 0.0
            a, b = labels[side], labels[~side]
            if not len(a) or not len(b):
                continue
            doubt = _doubt(a) + _doubt(b)
            if doubt < (1.0 - 1e-6) * _doubt(labels):
                scores.append((k in self.problem.sheets, doubt, k))
        if not scores:
            raise NotExact("no plane through its edges parts what is inside from what is outside")
        return [min(scores)[2]]


def _doubt(labels: np.ndarray) -> float:
    """How many answers it takes to know which of them are inside: their number times the entropy."""
    n, k = len(labels), int(labels.sum())
    return -sum(x * float(np.log2(x / n)) for x in (k, n - k) if x)


def _joined(k: int, below: Tree | bool | None, above: Tree | bool | None) -> Tree | bool | None:
    """Of the decision on which side of surface k a point is; what is not known of one side is as the other is."""
    if below is None or above is None or below == above:
        return above if below is None else below
    leaf: Tree = Leaf(k)
    if isinstance(below, bool) and isinstance(above, bool):
        return leaf if below else Not(leaf)
    if isinstance(below, bool):
        return Or(leaf, above) if below else And(Not(leaf), above)  # type: ignore[arg-type]
    if isinstance(above, bool):
        return Or(Not(leaf), below) if above else And(leaf, below)
    return Or(And(leaf, below), And(Not(leaf), above))


def contains(cells: Sequence[SolidCell], points: np.ndarray) -> np.ndarray:
    """(n,) whether the points are in one of the cells."""
    found = np.zeros(len(points), bool)
    for cell in cells:
        lo, hi = cell.box
        near = np.flatnonzero(((points >= lo) & (points <= hi)).all(axis=1) & ~found)
        if len(near):
            found[near] = cell.body.contains(points[near])
    return found
