"""Random trees of joints, and what is known of them without the library: poses by hand, separating axes."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import firstcontact as fc

KINDS = "revolute", "revolute", "prismatic", "screw"
PER_TURN = {"deg": 360.0, "rad": 2 * np.pi, "turn": 1.0}
BOX = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
BOX_SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


class Tree:
    """A mechanism of 2 to 4 joints with one convex body on each link, and its course.

    coarse: places on a grid, axes along those of the world, round angles: much is parallel, or touches.
    """

    def __init__(self, seed):
        rng = self.rng = np.random.default_rng(seed)
        self.coarse = seed % 3 == 0
        count = int(rng.integers(2, 5))
        self.parents = [int(rng.integers(max(0, k - 1), k + 1)) for k in range(count)]  # of link k + 1
        self.bodies = [self._body(np.zeros(3))]
        self.joints, self.rows, self.given = [], [], []
        self.times = np.arange(int(rng.integers(2, 5))) * 0.5 + float(rng.integers(-2, 3))
        self.cubic = bool(rng.random() < 0.4)
        places = [np.zeros(3)]
        for k in range(count):
            places.append(places[self.parents[k]] + self._vector(1.1))
            self.bodies.append(self._body(places[-1]))
            self._joint(k, 0.5 * (places[-1] + places[self.parents[k]]))
        links = {f"l{k}": body for k, body in enumerate(self.bodies)}
        values = {f"q{k}": row for k, row in enumerate(self.rows) if row is not None}
        self.mechanism = fc.Mechanism(links, self.joints)
        self.course = self.mechanism.course(self.times, values, interpolation="cubic" if self.cubic else "linear")

    def _vector(self, size):
        v = self.rng.uniform(-1, 1, 3) * size
        return np.round(v * 2) / 2 if self.coarse else v.round(4)

    def _body(self, place):
        if self.rng.random() < 0.5:
            size = self.rng.choice([0.25, 0.5, 1.0], 3) if self.coarse else self.rng.uniform(0.1, 1.0, 3)
            return fc.Polyhedron(BOX * size + place, BOX_SIDES)
        corners = self.rng.uniform(-0.7, 0.7, (4, 3))
        corners = np.round(corners * 4) / 4 if self.coarse else corners
        if abs(np.linalg.det(corners[1:] - corners[0])) < 0.02:
            corners = np.array([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]])
        return fc.Polyhedron(corners + place, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], solid=True)

    def _joint(self, k, point):
        rng = self.rng
        kind = KINDS[int(rng.integers(len(KINDS)))]
        axis = np.eye(3)[int(rng.integers(3))] if self.coarse else rng.normal(size=3).round(3)
        given = {"axis": axis.tolist()}
        if kind != "prismatic":
            given["point"] = point.tolist()
            units = ("deg", "turn") if kind == "screw" else tuple(PER_TURN)
            given["unit"] = units[int(rng.integers(len(units)))]
        if kind == "screw":
            given["lead"] = round(float(rng.uniform(-2, 2)), 2)
        leaders = [i for i, row in enumerate(self.rows) if row is not None]
        turns = rng.uniform(-0.6, 0.6, len(self.times))
        if self.coarse:
            turns = np.round(turns * 12) / 12
        row = turns * (PER_TURN[given["unit"]] if "unit" in given else 1.5)
        if leaders and rng.random() < 0.25:
            leader = int(rng.choice(leaders))
            ratio = float(rng.choice([-1.0, 2.0, 0.5])) * PER_TURN.get(given.get("unit"), 1.0)
            ratio /= PER_TURN.get(self.joints[leader].unit, 1.0)
            given["mimic"], row = (f"q{leader}", ratio, 0.125), None
        self.joints.append(fc.Joint(f"q{k}", kind, f"l{self.parents[k]}", f"l{k + 1}", **given))
        self.rows.append(row)
        self.given.append((kind, given))

    def values(self, times):
        """(joints, n) values, by NumPy and SciPy."""
        found = []
        for row, (_, given) in zip(self.rows, self.given, strict=True):
            if row is None:
                leader, ratio, offset = given["mimic"]
                found.append(ratio * found[int(leader[1:])] + offset)
            elif self.cubic:
                found.append(CubicSpline(self.times, row, bc_type="natural")(times))
            else:
                found.append(np.interp(times, self.times, row))
        return np.array(found)

    def poses(self, times):
        """[(n, 4, 4)] of each link: that of its parent, then the joint."""
        found = [np.broadcast_to(np.eye(4), (len(times), 4, 4))]
        for k, value in enumerate(self.values(times)):
            kind, given = self.given[k]
            found.append(found[self.parents[k]] @ moved(kind, given, value))
        return found

    def gaps(self, a, b, times):
        """(n,) how far two links' bodies are apart along the best axis; at most 0 where they share a point."""
        times = np.atleast_1d(times)
        poses = self.poses(times)
        return separation(self.bodies[a], poses[a], self.bodies[b], poses[b])


def moved(kind, given, value):
    """(n, 4, 4) of a joint at its values."""
    axis = np.asarray(given["axis"]) / np.linalg.norm(given["axis"])
    pose = np.tile(np.eye(4), (len(value), 1, 1))
    if kind == "prismatic":
        pose[:, :3, 3] = value[:, None] * axis
        return pose
    turns = value / PER_TURN[given["unit"]]
    point = np.asarray(given["point"])
    pose[:, :3, :3] = Rotation.from_rotvec(2 * np.pi * turns[:, None] * axis).as_matrix()
    pose[:, :3, 3] = point - pose[:, :3, :3] @ point + (given.get("lead", 0.0) * turns)[:, None] * axis
    return pose


def separation(a, pose_a, b, pose_b):
    """Of convex polyhedra, by the normals of faces and the products of edges [Gottschalk, Lin, Manocha 1996]."""
    corners, normals, edges = [], [], []
    for body, pose in ((a, pose_a), (b, pose_b)):
        turn, x = pose[:, :3, :3], body.vertices
        t = x[body.triangles]
        corners.append(np.einsum("nij,kj->nki", turn, x) + pose[:, None, :3, 3])
        normals.append(np.einsum("nij,kj->nki", turn, np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])))
        sides = np.concatenate([t[:, (k + 1) % 3] - t[:, k] for k in range(3)])
        edges.append(np.einsum("nij,kj->nki", turn, sides))
    products = np.cross(edges[0][:, :, None], edges[1][:, None]).reshape(len(pose_a), -1, 3)
    axes = np.concatenate([*normals, products], axis=1)
    length = np.linalg.norm(axes, axis=2)
    axes = axes / np.where(length > 1e-9, length, 1.0)[..., None]
    p, q = (np.einsum("nki,nci->nkc", axes, c) for c in corners)
    between = np.maximum(p.min(axis=2) - q.max(axis=2), q.min(axis=2) - p.max(axis=2))
    return np.where(length > 1e-9, between, -np.inf).max(axis=1)
