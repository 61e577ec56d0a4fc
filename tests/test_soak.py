"""A short run of the soak (`benchmarks/soak.py`), and proof that its oracles notice wrong answers."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import firstcontact as fc
from amount import THOROUGH

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
import soak  # noqa: E402
from soaks.brute import Mesh, contact_times, inside, start_of  # noqa: E402
from soaks.scene import Kind, Question, Scene  # noqa: E402
from soaks.shapes import box, check, corner_prism, frame, hollow, octahedron, ridge  # noqa: E402
from soaks.turning import Axis, Speed  # noqa: E402
from soaks.turning import first_contact as turned_contact  # noqa: E402

SEED = 20
SCENES = 1
LONG = {
    "meshes/screwed on a plate", "meshes/steps to a plate", "mixed/graze", "mixed/landing",
    "mixed/pin in a bore", "mixed/stairs and a pin", "solids/nested start", "solids/pin in a bore", "solids/two balls",
    "ruled/tips on solids", "ruled/trimmed disc",
}  # fmt: skip
"""Kinds that take seconds a scene: for the soak itself, and thorough tests."""


def family_kinds() -> list[Kind]:
    return list(soak.load(list(soak.FAMILIES)).values())


SHORT = [kind for kind in family_kinds() if THOROUGH or kind.name not in LONG]


@pytest.mark.share(10)
@pytest.mark.parametrize("kind", SHORT, ids=lambda kind: kind.name)
def test_short_soak(kind: Kind) -> None:
    for index in range(SCENES):
        for record in soak.try_scene(kind, SEED, index, share=0.5):
            assert record.wrong is None, record.snippet(SEED)


def answered(kind: Kind, index: int) -> list[tuple[Question, Any, dict[str, Any]]]:
    """The questions of a scene with the library's answers, and what the scene defines."""
    scene = kind.make(Random(f"{SEED}/{kind.name}/{index}"))
    names: dict[str, Any] = {"fc": fc, "F": soak.Fraction, "np": np}
    exec(scene.source, names)
    return [(question, eval(question.call, names), names) for question in scene.questions]


FIELDS = [field.name for field in dataclasses.fields(fc.FirstContact)]


def forged(hit: Any, **changes: Any) -> Any:
    """The answer with some fields changed."""
    return SimpleNamespace(**{**{name: getattr(hit, name) for name in FIELDS}, **changes})


def forgeries(hit: Any) -> dict[str, Any]:
    """Wrong answers beside a right one."""
    status = hit.status
    if status is fc.Status.UNDECIDED:
        return {}
    if status is fc.Status.FREE:
        start = hit.span[0]
        return {"contact": forged(hit, status=fc.Status.CONTACT, time=start, time_interval=(start, start))}
    lies = {"free": forged(hit, status=fc.Status.FREE, time=None, time_interval=None, initial=None)}
    late = forged(hit, status=fc.Status.UNDECIDED, time=None, time_interval=None, free_until=float("inf"))
    lies["free too long"] = late
    if status is fc.Status.INITIAL_CONTACT:
        lies["no start"] = forged(hit, status=fc.Status.CONTACT, initial=None)
        return lies
    later = hit.time + 1e-9 * max(1.0, abs(hit.time))
    lies["later"] = forged(hit, time=later, time_interval=(later, np.nextafter(later, np.inf)))
    lies["start"] = forged(hit, status=fc.Status.INITIAL_CONTACT, initial="touching")
    return lies


EXACT = [kind for kind in family_kinds() if kind.name.startswith(("meshes/translated", "meshes/turned"))]


@pytest.mark.share(4)
@pytest.mark.parametrize("kind", EXACT, ids=lambda kind: kind.name)
def test_forged_answers_are_noticed(kind: Kind) -> None:
    noticed = set()
    for index in range(4):
        for question, answer, _ in answered(kind, index):
            if not question.call.startswith("fc.first_contact"):
                continue
            for name, lie in forgeries(answer).items():
                assert question.judge(lie) is not None, f"{name}: {question.call} of scene {index}"
                noticed.add(name)
    assert len(noticed) >= 3


def test_point_and_normal_are_judged() -> None:
    """Of a corner that meets a face: the point beside it, the normal turned round, the wrong element."""
    kind = next(kind for kind in EXACT if kind.name == "meshes/translated solids")
    seen = 0
    for index in range(12):
        question, hit, _ = answered(kind, index)[0]
        if hit.status is not fc.Status.CONTACT or hit.normal is None:
            continue
        seen += 1
        assert question.judge(hit) is None
        assert "point" in question.judge(forged(hit, point=hit.point + 1e-6))
        assert "normal" in question.judge(forged(hit, normal=hit.normal * 1.001))
        assert "normal" in question.judge(forged(hit, normal=-hit.normal))
    assert seen >= 3


def test_intervals_and_pairs_are_judged() -> None:
    for kind in family_kinds():
        if kind.name not in ("meshes/translated solids", "meshes/pairs", "meshes/screwed on a plate"):
            continue
        for index in range(5):
            for question, answer, _ in answered(kind, index):
                if "intervals" in question.call and answer.status is fc.Status.CONTACT:
                    lie = SimpleNamespace(intervals=answer.intervals[1:], status=answer.status, free_until=None)
                    assert question.judge(lie) is not None
                if "pairs" in question.call and answer.pairs:
                    assert question.judge(SimpleNamespace(pairs=answer.pairs[1:])) is not None


def test_laws_notice_answers_that_differ() -> None:
    a = fc.examples.box((2, 2, 2)).moving(fc.Translation((0, 0, 8)))
    b = fc.examples.box((2, 2, 2)).translated((0.25, 0.5, 5))
    question = Question("fc.first_contact(a, b, span)", lambda hit: None)
    scene = Scene("", "translation", (question,))
    names = {"a": a, "b": b, "span": None, "fc": fc, "F": soak.Fraction, "np": np}
    laws = set()
    for n in range(20):
        for trial in soak.laws.trials(scene, names, Random(n)):
            own = dict(names)
            exec(trial.source, own)
            answers = [eval(call, own) for call in trial.calls]
            assert trial.judge(*answers) is None, trial.law
            laws.add(trial.law)
            if trial.law in ("budget", "time reversal", "split", "split at the contact", "intervals"):
                continue
            lie = forged(answers[-1], time_interval=(-9.0, -9.0), time=-9.0)
            if answers[-1].status is fc.Status.CONTACT:
                assert trial.judge(*answers[:-1], lie) is not None, trial.law
    assert len(laws) >= 10


def test_apexes_on_common_rulings_may_be_told() -> None:
    """An apex at the end of a common ruling is an isolated point by the documentation, no other point of it is."""
    kind = next(kind for kind in family_kinds() if kind.name == "curves/flat pieces")
    scene = kind.make(Random(f"32/{kind.name}/60"))
    names: dict[str, Any] = {"fc": fc, "F": soak.Fraction, "np": np}
    exec(scene.source, names)
    question = scene.questions[0]
    curve = eval(question.call, names)
    (apex,), ((other, end),) = curve.isolated_points, curve.overlap_lines
    assert np.array_equal(apex, end) and question.judge(curve) is None
    assert question.judge(dataclasses.replace(curve, isolated_points=np.empty((0, 3)))) is None
    for wrong in (other, (other + end) / 2):
        assert question.judge(dataclasses.replace(curve, isolated_points=wrong[None])) is not None


def test_a_finding_prints_as_a_program_that_runs() -> None:
    source = "a = fc.examples.box((1, 1, 1)).moving(fc.Translation((8, 0, 0)))\n"
    source += "b = fc.examples.box((1, 1, 1)).translated((3, 0, 0))\nspan = None\n"
    question = Question("fc.first_contact(a, b, span)", lambda hit: f"time {hit.time}")
    kind = Kind("tests/planted", "mesh, mesh", lambda rng: Scene(source, "translation", (question,)), "", "")
    records = list(soak.try_scene(kind, 1, 0, share=0.0))
    assert [record.wrong for record in records] == ["time 0.25"]
    tally = soak.Tally({kind.name: kind}, 1)
    assert tally.add(records[0]) and not tally.add(records[0])
    exec(compile(tally.findings().split("=\n", 1)[1].split("\n", 1)[1], "finding", "exec"), {})
    raised = Question("fc.first_contact(a, b, span, tolerance='none at all')", lambda hit: None)
    kind = dataclasses.replace(kind, make=lambda rng: Scene(source, "translation", (raised,)))
    assert [record.outcome for record in soak.try_scene(kind, 1, 0, share=0.0)] in (["raised"], ["refused"])


# ---- the oracles themselves, on answers worked out by hand ----


def placed(mesh: Mesh, x: Any, y: Any, z: Any) -> Mesh:
    return mesh.mapped(lambda p: (p[0] + x, p[1] + y, p[2] + z))


def test_brute_force_by_hand() -> None:
    F = soak.Fraction
    for mesh in (box(1, 2, 3), box(1, 1, 1, polygons=True), corner_prism(1, 1), frame(4, 2, 1), hollow(8, 1, 2),
                 octahedron(1, 1, 1), ridge(2, 2, 1, F(1, 2**60))):
        check(mesh)
    cube = box(1, 1, 1)
    times = contact_times(cube, placed(cube, 3, 0, 0), (F(8), F(0), F(0)), F(0), F(1))
    assert times == [(F(1, 4), F(1, 2))]
    # inside a void, through the wall
    times = contact_times(placed(cube, 3, 3, 3), hollow(8, 1), (F(0), F(0), F(9)), F(0), F(1))
    assert times == [(F(1, 3), F(5, 9))]
    assert start_of(cube, placed(cube, 1, 1, 1)) == "touching"
    assert start_of(cube, placed(cube, 1 - F(1, 2**60), 0, 0)) == "overlapping"
    assert start_of(placed(cube, 1, 1, 1), box(3, 3, 3)) == "containment"
    assert start_of(placed(cube, 3, 3, 3), hollow(8, 1)) is None
    assert inside((F(1, 2), F(1, 2), F(1, 2)), cube.vertices, cube.pieces)


def test_turning_by_hand() -> None:
    F = soak.Fraction
    axis = Axis((0, 0, 1), (F(0), F(0), F(0)))
    arm = placed(box(3, 1, 1), 1, 0, 0)
    wall = placed(box(1, 3, 1), -1, 1, 0)
    turn = turned_contact(arm, wall, axis, Speed(F(1, 4), "turns"), F(0), F(1))
    # the near upper corner (1, 1) comes to (0, sqrt(2)), on the wall's side, after an eighth of a turn
    assert turn is not None and (turn.time, turn.exact) == (F(1, 2), True)
    # a side through the axis lands flat on the wall behind after half a turn
    flush = placed(box(3, 1, 1), 1, -1, 0), placed(box(3, 1, 1), -4, -1, 0)
    landing = turned_contact(*flush, axis, Speed(F(1, 2), "turns"), F(0), F(1))
    assert landing is not None and (landing.time, landing.exact) == (F(1), True)
    short = turned_contact(*flush, axis, Speed(F(1, 2), "turns"), F(0), F(1023, 1024))
    assert short is not None and short.time is None


def test_kinds_have_equal_times(monkeypatch) -> None:
    """A scene of one kind takes ten times as long as one of the other, on a clock that only scenes move on."""
    now, taken = 0.0, {"long": 0, "short": 0}
    monkeypatch.setattr(soak.time, "monotonic", lambda: now)
    turns = soak.Turns(taken, range(1000))
    for _ in range(220):
        kind, index = turns.take()
        assert index == taken[kind]
        taken[kind] += 1
        now += 10.0 if kind == "long" else 1.0
        turns.done(kind, index)
    assert taken == {"long": 20, "short": 200}
    few = soak.Turns(["long", "short"], range(2))
    assert sorted(few.take() for _ in range(4)) == [("long", 0), ("long", 1), ("short", 0), ("short", 1)]
    assert few.take() is None
