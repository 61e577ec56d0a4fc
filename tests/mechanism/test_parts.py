"""Parts of CAD files as links: what is said of the bodies as built is said of them too."""

from math import asin, degrees, hypot

import pytest

pytest.importorskip("OCP")

import firstcontact as fc  # noqa: E402
import step_shapes as shapes  # noqa: E402

DOOR = fc.from_shape(
    shapes.cut(shapes.box((10, 1, 10)), shapes.cylinder(1, 3, (5, -1, 5), (0, 1, 0))), name="door", unit="mm"
)
"""Hung at the z axis."""
STOP = fc.from_shape(shapes.cylinder(0.5, 10), name="stop", unit="mm")
"""Round, of radius 1/2."""
FRAME = fc.box((1, 1, 1)).translated((0, 0, -20))
OPENED = fc.Mechanism({"frame": FRAME, "door": DOOR}, [fc.Joint("hinge", "revolute", "frame", "door", axis=(0, 0, 1))])


@pytest.mark.share(2)
@pytest.mark.parametrize(
    ("x", "y", "status"), [(8, 3, "CONTACT"), (50, 50, "FREE"), (20, 3, "FREE"), (4, 1, "INITIAL_CONTACT")]
)
def test_answers_about_links_tell_how_far_parts_are_from_their_files(x, y, status):
    door = OPENED.course([0, 1], {"hinge": [0, 90]}).bodies["door"][0]
    stop = STOP.translated((x, y, 0))
    found, resting = fc.first_contact(door, stop), fc.first_contact(DOOR.moving(fc.Translation((0, 0, 0))), stop)
    every = fc.contact_intervals(door, stop)
    assert found.status.name == every.status.name == status
    for answer in (found, every):
        assert answer.model_deviation == resting.model_deviation > 0 and answer.unit == "mm"
    if status == "CONTACT":  # the side y = 1 turns until it is 1/2 from the axis of the stop
        angle = degrees(asin(y / hypot(x, y)) - asin(1.5 / hypot(x, y)))
        assert found.joints[0].value == pytest.approx(angle, abs=1e-9)
    assert found.within_deviation is (False if status == "INITIAL_CONTACT" else None)
