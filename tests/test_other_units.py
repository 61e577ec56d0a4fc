"""The same scene in units that are a power of two as long: the same answer, its lengths so many times as long."""

import numpy as np
import pytest
from flint import fmpq

import firstcontact as fc
from firstcontact import Rotation, Screw, Sequence, Translation

FACTORS = [2.0**40, 2.0**20, 2.0**-20, 2.0**-40]
SADDLE = [[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, -0.5], [0, 0, -0.5, 0]]


def larger(body, k):
    return body.transformed(np.diag([k, k, k, 1.0]))


def between(k):
    return fc.RationalMotion.between((0, 0, 4 * k), (0, k, -6 * k), quat_wxyz=((1, 0, 0, 0), (2, 1, 0, 0)))


SCENES = {
    "torus and box": (
        fc.torus(2, 1).translated((4, -5, 4)),
        lambda k: Screw((0, 3, 4), (-2 * k, -k / 2, -2 * k), degrees=30, advance=-2 * k),
        fc.box((5, 1, 5)).translated((2, "-3/2", "1/2")),
    ),
    "torus and ball": (fc.torus(2, 1), lambda k: Translation((20 * k, 0, 0)), fc.sphere(1).translated((10, 0, 0))),
    "triangle and ellipsoid": (
        fc.Polyhedron([[-4, -3, -6], [-4, -3, -4], [1, 2, -4]], [[0, 1, 2]]),
        lambda k: Screw((0, 1, 0), (-2 * k, 0, -k / 2), degrees=-200, advance=-k / 2),
        fc.ellipsoid((2, 2, 1)).translated(("1/2", -1, -2)),
    ),
    "cut saddle and box": (
        (fc.quadric(SADDLE) & fc.box((4, 4, 4))).translated((2, -5, -1)),
        lambda k: Screw((1, 0, 0), (-1.5 * k, -2 * k, 0), degrees=120, advance=-k),
        fc.box((1, 3, 1)).translated((2, "3/2", "1/2")),
    ),
    "drilled box and cylinder": (
        fc.box((4, 4, 4)) - fc.cylinder(1, 6), lambda k: Rotation((0, 1, 0), (3 * k, 0, 0), degrees=80),
        fc.cylinder("1/2", 6).translated((1, 0, 6)),
    ),
    "ball in steps": (
        fc.sphere(1).translated((0, 0, 6)),
        lambda k: Sequence([Rotation((1, 2, 2), (k, 0, 0), degrees=30), Translation((0, 0, -9 * k))], durations=[1, 2]),
        fc.box((2, 2, 2)) | fc.cylinder(3, 1),
    ),
    "cone between poses": (fc.cone(1, 2), between, fc.sphere(1)),
    "cylinder on a trajectory": (
        fc.cylinder(1, 3).translated((0, 0, 5)),
        lambda k: fc.Trajectory([0, 1, 2], [(0, 0, 0), (k, 0, -3 * k), (0, k, -6 * k)],
                                        quat_wxyz=[(1, 0, 0, 0), (3, 1, 0, 0), (3, 1, 1, 0)]),
        fc.box((2, 2, 2)),
    ),
    "saddle strip and ball": (
        fc.RuledSurface("(u, 0, 0)", "(u, 1, u)").translated((0, 0, 4)), lambda k: Translation((0, 0, -6 * k)),
        fc.sphere(1),
    ),
}  # fmt: skip


@pytest.mark.thorough
@pytest.mark.parametrize("k", FACTORS)
@pytest.mark.parametrize("name", SCENES)
def test_answers_in_other_units(name, k):
    a, motion, b = SCENES[name]
    span = (0, 2) if "trajectory" in name else None
    here = fc.first_contact(a.moving(motion(1.0)), b, span)
    there = fc.first_contact(larger(a, k).moving(motion(k)), larger(b, k), span)
    assert here.status is there.status is fc.Status.CONTACT
    assert there.time == pytest.approx(here.time, abs=2e-12)
    assert there.point / k == pytest.approx(here.point, abs=1e-9)
    if here.normal is not None:
        assert there.normal == pytest.approx(here.normal, abs=1e-6) and np.linalg.norm(there.normal) == pytest.approx(1)
    names = [(x.kind, x.index) for x in (here.element_a, here.element_b)]
    assert [(x.kind, x.index) for x in (there.element_a, there.element_b)] == names
    assert "body" not in there.to_dict() and there.a.body is not None  # the answer is about the bodies of the question
    assert there.a.body.bounds()[1] == pytest.approx(k * np.asarray(a.bounds()[1]), rel=1e-12, abs=1e-12 * k)


@pytest.mark.thorough
@pytest.mark.parametrize("k", [FACTORS[0], FACTORS[-1]])
@pytest.mark.parametrize("name", ["torus and ball", "drilled box and cylinder", "saddle strip and ball"])
def test_intervals_in_other_units(name, k):
    a, motion, b = SCENES[name]
    here = fc.contact_intervals(a.moving(motion(1.0)), b)
    there = fc.contact_intervals(larger(a, k).moving(motion(k)), larger(b, k))
    assert len(here) and [x.start for x in there] == pytest.approx([x.start for x in here], abs=1e-9)
    assert [x.end for x in there] == pytest.approx([x.end for x in here], abs=1e-9)


MOTIONS = {
    "translation": Translation((1, 2, "1/3")),
    "rotation": Rotation((1, 2, 3), (3, "1/7", 1), degrees=50),
    "screw": Screw((1, 2, 3), (3, 1, 1), radians=2, advance=5),
    "rational": between(1.0),
    "sequence": Sequence([Rotation((1, 1, 0), (1, 0, 0), turns="1/8"), Translation((1, 0, 0))]),
    "trajectory": fc.Trajectory(
        [0, "1/2", 1], [(0, 0, 0), (1, 0, -3), (0, 1, -6)], quat_wxyz=[(1, 0, 0, 0), (3, 1, 0, 0), (3, 1, 1, 0)]
    ),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_in_other_units(name):
    motion, k = MOTIONS[name], 2.0**30
    scale, back = np.diag([k, k, k, 1]), np.diag([1 / k, 1 / k, 1 / k, 1])
    there = motion.magnified(fmpq(2) ** 30)
    for t in np.linspace(0, 1, 9):
        assert back @ there(t) @ scale == pytest.approx(motion(t), rel=1e-13, abs=1e-13)


def test_a_mechanism_in_other_units():
    """A ball on an arm that turns and slides."""
    found = []
    for k in (1.0, 2.0**40, 2.0**-40):
        bored = fc.box((1, 1, 4)).translated((0, 5, 0)) - fc.cylinder("1/4", 9).translated((0, 5, 0))
        links = {"wall": larger(bored, k),
                 "arm": larger(fc.sphere("1/10").translated((0, 0, 9)), k),
                 "ball": larger(fc.sphere("1/2").translated((3, 0, 0)), k)}  # fmt: skip
        joints = [fc.Joint("turn", "revolute", "wall", "arm", axis=(0, 0, 1)),
                  fc.Joint("slide", "prismatic", "arm", "ball", axis=(1, 0, 0))]  # fmt: skip
        course = fc.Mechanism(links, joints, skip=[("arm", "ball"), ("wall", "arm")])
        (hit,) = course.course([0, 1], {"turn": [0, 90], "slide": [0, 2 * k]}).first_contacts()
        assert hit.status is fc.Status.CONTACT
        found.append((hit.time, *(hit.point / k), *(x.value / (k if x.name == "slide" else 1) for x in hit.joints)))
    assert found[1] == pytest.approx(found[0], abs=1e-9) and found[2] == pytest.approx(found[0], abs=1e-9)
