"""Contacts under curved motions of which floats are sure: named by one root, as if they were looked for with balls."""

from __future__ import annotations

import numpy as np
import pytest

import firstcontact as fc
from amount import amount
from curved import pose, random_body
from firstcontact.contact.polyhedra.problems.curved_problem import CurvedProblem
from firstcontact.contact.polyhedra.problems.enclosed_problem import EnclosedProblem
from firstcontact.contact.polyhedra.problems.rational_problem import RationalProblem
from firstcontact.motion.relative import cells

BOX = fc.examples.box((1, 1, 1)).rotated((1, 2, 3), degrees=25)
WAYS = {
    "screw": fc.Screw((1, 0, 0), degrees=40, advance=3),
    "between": fc.RationalMotion.between((0, 0, 0), (3, 0, 0), quat_wxyz=((1, 0, 0, 0), (3, 1, 0, 0))),
}


@pytest.mark.parametrize("way", WAYS)
def test_no_condition_is_looked_at_for_a_sure_contact(way, monkeypatch):
    def refused(*_):
        raise AssertionError("looked for")

    for kind in (EnclosedProblem, RationalProblem):
        monkeypatch.setattr(kind, "contact", refused)
    hit = fc.first_contact(BOX.moving(WAYS[way]), BOX.translated((3, 0.2, 0.1)))
    assert hit.status is fc.Status.CONTACT and (hit.multiplicity, hit.element_a.kind) == (1, "edge")


@pytest.mark.share(2)
@pytest.mark.parametrize("generic", [False, True], ids=["degenerate", "random"])
@pytest.mark.parametrize("block", range(amount(2)))
def test_sure_contacts_are_those_that_are_looked_for(block, generic, monkeypatch):
    scenes = []
    for seed in range(20 * block, 20 * block + 20):
        rng = np.random.default_rng([7, seed, generic])
        a, b = random_body(rng, generic), random_body(rng, generic)
        axis, point = rng.integers(-2, 3, (2, 3)).tolist()
        screw = fc.Screw(axis if any(axis) else (0, 0, 1), point, radians=2, advance=int(rng.integers(-4, 5)))
        between = fc.RationalMotion.between(pose(), pose(rng.integers(-5, 6, 3).tolist(), (1, 2, int(seed))))
        scenes += [(a.moving(screw), b), (a.moving(between), b), (b, a.moving(between))]
    found = [fc.first_contact(*scene) for scene in scenes]
    for kind in (EnclosedProblem, RationalProblem):
        monkeypatch.setattr(kind, "contact_within", CurvedProblem.contact_within)
    for hit, scene in zip(found, scenes, strict=True):
        sought = fc.first_contact(*scene)
        assert (hit.status, hit.time, hit.multiplicity) == (sought.status, sought.time, sought.multiplicity)
        if hit.status is fc.Status.CONTACT:
            assert (hit.element_a, hit.element_b) == (sought.element_a, sought.element_b)


def test_bodies_of_much_the_same_size_share_what_is_known_of_a_motion(monkeypatch):
    mover, asked = BOX.moving(fc.Screw((1, 0, 0), degrees=41, advance=3)), []

    def counted(*of):
        asked.append(of)
        return made(*of)

    made = cells._cells
    monkeypatch.setattr(cells, "_cells", counted)
    for size in (1.0, 0.9, 1.1):
        other = fc.examples.box((size, size, size)).translated((3, 0.2, 0.1))
        assert fc.first_contact(mover, other).status is fc.Status.CONTACT
    assert len(asked) == 1
