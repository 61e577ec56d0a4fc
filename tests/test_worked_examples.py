"""Examples 7 and 8 of Choi et al. 2014: the features that the paper counts, and the first contact on both paths."""

from collections import Counter

import pytest

import firstcontact as fc
from firstcontact.body.solid.carriers import Conic, Line, Plane, Quadric
from firstcontact.examples.choi import example_7, example_8


def census(solid):
    """How many cylinders, cones, planes, circles, lines and vertices bound the solid."""
    kinds = {Plane: "plane", Line: "line"}
    found = Counter(kinds[type(x.carrier)] for x in (*solid.faces, *solid.edges) if type(x.carrier) in kinds)
    for face in solid.faces:
        if isinstance(face.carrier, Quadric):
            found["cylinder" if face.carrier.apex is None else "cone"] += 1
    for edge in solid.edges:
        if isinstance(edge.carrier, Conic):
            centre, u, v = edge.frame[:3].T
            assert u @ u == pytest.approx(v @ v) and u @ v == pytest.approx(0)
            found["circle"] += 1
    return {**found, "vertex": len(solid.vertices)}


def test_example_8_has_the_features_of_the_paper():
    a, b = example_8()
    assert census(a.body) == {"cylinder": 4, "plane": 9, "circle": 10, "line": 14, "vertex": 8}
    assert census(b.body) == {"cylinder": 3, "cone": 1, "plane": 3, "circle": 6, "vertex": 0}
    assert not a.body.seams and not b.body.seams


@pytest.mark.share(2)
@pytest.mark.parametrize("method", ["auto", "algebraic"])
def test_example_8_touches_where_the_paper_says(method):
    hit = fc.first_contact(*example_8(), method=method)
    assert hit.status is fc.Status.CONTACT and hit.time == pytest.approx(0.31324460346078811, abs=1e-15)
    assert hit.time_interval[1] - hit.time_interval[0] < 1e-12
    assert hit.point == pytest.approx((-5.0960071557354650, -4.3163224810501394, 1.3394622037340629), abs=1e-12)
    assert (hit.element_a.label, hit.element_b.label) == ("latch.rod.rim.bottom", "pin.taper.side")


@pytest.mark.parametrize("method", ["auto", "algebraic"])
def test_example_7_touches_at_five_eighths(method):
    hit = fc.first_contact(*example_7(), method=method)
    assert hit.time == pytest.approx(0.625, abs=1e-15) and hit.point == pytest.approx((-7.5, 10, 0), abs=1e-9)
