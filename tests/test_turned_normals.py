"""Normals of polyhedra that turn, near and far from the origin: across what the elements span, from exact corners."""

from __future__ import annotations

from fractions import Fraction as F
from random import Random

import numpy as np

import firstcontact as fc

FACES = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]


def test_an_edge_that_turns_far_from_the_origin():
    a = fc.Polyhedron(
        [(-1048575.9975585938, 12345678.00390625, 0.001953125),
         (F(-10737418229, 10240), F(15802467851, 1280), 0.0029296875),
         (F(-10737418301, 10240), F(63209871381, 5120), 0), (-1048576.0004882812, 12345678, 0.00390625)],
        [], edges=[[0, 1], [1, 2], [3, 0]],
    )  # fmt: skip
    turn = fc.Rotation((2, -4, 0), (-1048575.9995117188, 12345678.002929688, 0.0009765625), turns=F(1, 3))
    b = fc.Polyhedron(
        [(-1048576.0029296875, 12345678, 0), (-1048576, 12345678, 0.0009765625), (-1048576, 12345678.00390625, 0),
         (-1048576.0029296875, 12345678.00390625, 0.0009765625)],
        [[0, 1, 2], [0, 2, 3]],
    )  # fmt: skip
    hit = fc.first_contact(a.moving(turn), b)
    assert (str(hit.element_a), str(hit.element_b)) == ("a edge 2", "b edge 0")
    assert abs(hit.normal @ (-0.3843350586210595, -0.6564058747531595, -0.6491670742607687)) < 1e-14
    assert abs(hit.normal @ (3.0, 0.0, 1.0)) < 1e-14


def test_normals_are_across_the_elements():
    assert sum(is_across(seed) for seed in range(300)) == 33


def is_across(seed: int) -> bool:
    """Small tetrahedra about an axis near by, all of them far away by powers of two or by numbers of many digits.

    Whether they meet; the normal is then across the elements, of several pairs across those of one.
    """
    rng = Random(seed)
    unit = F(1, rng.choice((1, 64, 1024, 2**20)))
    far = [F(rng.choice((0, 12345678, -(2**20), 7 * 10**5))) for _ in range(3)]

    def near(*reach: int) -> tuple[F, ...]:
        return tuple(o + unit * F(rng.randint(-r, r), 4) for o, r in zip(far, reach, strict=True))

    a, b = ([near(12, 12, 4) for _ in range(4)] for _ in "ab")
    b = [(x + unit * 5, y, z) for x, y, z in b]
    axis = rng.choice(((0, 0, 1), (1, 1, 4), (0, -1, 3)))
    motion = fc.Rotation(axis, near(2, 2, 2), turns=F(rng.choice((-1, 1)), rng.choice((1, 2, 3))))
    hit = fc.first_contact(fc.Polyhedron(a, FACES).moving(motion), fc.Polyhedron(b, FACES))
    if hit.status is not fc.Status.CONTACT:
        return False
    angle = 2 * np.pi * float(motion.angle.p) / float(motion.angle.q) * hit.time
    leans = []
    for pair in (hit, *hit.others):
        spans = [turned(axis, angle, d) for d in spanned(pair.element_a, a)] + spanned(pair.element_b, b)
        assert spans
        leans.append(max(abs(hit.normal @ d) / np.linalg.norm(d) for d in spans))
    assert min(leans) < 1e-13, seed
    return True


def spanned(element, corners) -> list[np.ndarray]:
    """Directions of the element, from exact differences."""
    if element.kind == "vertex":
        return []
    numbers = FACES[element.index] if element.kind == "face" else edges()[element.index]
    first = corners[numbers[0]]
    return [np.array([float(x - y) for x, y in zip(corners[k], first, strict=True)]) for k in numbers[1:]]


def edges() -> list[tuple[int, int]]:
    return [tuple(e) for e in fc.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], FACES).edges.tolist()]


def turned(axis, angle: float, d: np.ndarray) -> np.ndarray:
    h = np.array(axis) / np.linalg.norm(axis)
    return np.cos(angle) * d + np.sin(angle) * np.cross(h, d) + (1 - np.cos(angle)) * (h @ d) * h
