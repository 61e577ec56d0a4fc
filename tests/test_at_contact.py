"""What exact arithmetic tells of a proved contact from what is near it, against all that it tells of everything."""

from __future__ import annotations

import random

import pytest

import firstcontact as fc
from firstcontact.contact.models.at_contact import surfaces_there

SLOT = fc.box((2, 1, 1)) | fc.cylinder("1/2", 1).translated((1, 0, 0)) | fc.cylinder("1/2", 1).translated((-1, 0, 0))
HOLE = fc.cylinder("1/2", 2)
PLATE = fc.box((8, 8, 1)) - HOLE.translated((3, 3, 0)) - HOLE.translated((0, "5/8", 0))
WAY = "exactly, at the contact"


def pairs(hit) -> set[tuple[str, str]]:
    return {(str(p.element_a), str(p.element_b)) for p in (hit, *hit.others)}


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(2))
def test_what_is_near_tells_the_same_as_everything(seed):
    """Slots that land flat, over the edge of a hole or of the plate."""
    dice = random.Random(seed)
    x, y = dice.randint(-12, 12) / 8, dice.randint(-4, 4) / 8
    moving = SLOT.translated((x, y, 3)).moving(fc.Translation((dice.randint(-2, 2) / 4, 0, -4)))
    near, all_told = fc.first_contact(moving, PLATE), fc.first_contact(moving, PLATE, exact=True)
    assert WAY in [way.way for way in near.stats.ways]
    assert near.time == all_told.time and pairs(near) == pairs(all_told)
    assert str(near.contact_set) == str(all_told.contact_set) and near.multiplicity == all_told.multiplicity
    assert near.stats.exact_evaluations < all_told.stats.exact_evaluations


def test_a_hole_far_from_the_contact_is_not_asked():
    near, beside = surfaces_there((SLOT.translated((0, 0, 3)).moving(fc.Translation((0, 0, -4))), PLATE), (0.5, 0.5))
    forms = [PLATE.surfaces[k] for k in beside]
    assert len(forms) == 2  # the upper side and the near hole
    assert len(near) < len(SLOT.surfaces)
    turning = SLOT.moving(fc.Rotation((0, 0, 1), degrees=30))
    assert surfaces_there((turning, PLATE), (0.5, 0.5)) is None
