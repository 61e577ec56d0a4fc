"""Long courses part by part: the answers of one question about all of it, kept where a run is stopped."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.batch import courses
from firstcontact.batch.courses import CourseSearch
from firstcontact.cli import progress, run

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
LAMP, DESK = EXAMPLES / "lamp.urdf", EXAMPLES / "desk.toml"


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    monkeypatch.setattr(courses, "STRETCHES", 4)


def arm():
    """Two limbs along 21 waypoints beside a post, a wheel that turns by itself and a box that they touch at first."""
    links = {
        "base": fc.examples.box((0.5, 0.5, 0.5)).translated((0, 0, -3)),
        "upper": fc.examples.box((1, 0.2, 0.2)).translated((0.5, 0, 0)),
        "fore": fc.examples.box((1, 0.2, 0.2)).translated((1.75, 0, 0)),
    }
    joints = [
        fc.Joint("q0", "revolute", "base", "upper", axis=(0, 0, 1)),
        fc.Joint("q1", "revolute", "upper", "fore", axis=(0, 0, 1), point=(1.125, 0, 0)),
    ]
    course = fc.Mechanism(links, joints).course(
        np.arange(21) * 0.125, {"q0": np.linspace(0, 90, 21), "q1": np.linspace(0, 60, 21)}, interpolation="cubic"
    )
    post = fc.examples.box((0.25, 0.25, 0.5)).translated((0.75, 1.5, 0)).named("post")
    wheel = fc.examples.box((2, 0.1, 0.1)).translated((2.5, 1, 0)).named("wheel")
    wheel = wheel.moving(fc.Rotation((0, 0, 1), (2.5, 1, 0), degrees=-40))
    seat = fc.examples.box((0.5, 0.5, 0.5)).translated((0.5, 0, -0.35)).named("seat")
    return course, [post, wheel, seat]


@pytest.mark.filterwarnings("ignore:the motions have the spans")
def test_parts_tell_what_one_question_does():
    course, things = arm()
    whole = course.first_contacts(things)
    following = CourseSearch(course, things)
    found = [x for part in following.parts() for x in part.found]
    times = [-1 if x.hit.time is None else x.hit.time for x in found]
    assert times == sorted(times) and {x.hit.status for x in found} >= {fc.Status.CONTACT, fc.Status.INITIAL_CONTACT}
    found += following.free()
    assert sorted(x.pair for x in found) == list(range(len(whole)))
    for pair, hit in found:
        expected = whole[pair]
        assert (hit.a, hit.b, hit.span, hit.status) == (expected.a, expected.b, expected.span, expected.status)
        assert hit.time == pytest.approx(expected.time, abs=1e-12) and hit.initial == expected.initial
        assert (hit.element_a, hit.element_b) == (expected.element_a, expected.element_b)
        assert hit.free_until == pytest.approx(expected.free_until, abs=1e-11) or hit.status is not fc.Status.FREE
        if hit.time is not None:
            lo, hi = hit.time_interval
            assert lo <= expected.time_interval[1] and expected.time_interval[0] <= hi
    assert {x.hit.status for x in found} >= {fc.Status.FREE}


def trajectory(folder, name="q.csv", shift=0.0):
    """The lamp bends down on the books in 30 steps."""
    rows = [f"{k / 10},{k / 30 + shift},{k / 35},{-k / 100}" for k in range(31)]
    path = folder / name
    path.write_text("\n".join(["time,turn,bend,tilt", *rows]) + "\n")
    return path


def command(folder, *more, path=None):
    return run(["robot", str(LAMP), "--trajectory", str(path or trajectory(folder)), "--scene", str(DESK), *more])


def stop_after(monkeypatch, count):
    """As Ctrl-C does, within the question after that many."""
    asked, original = [], courses.query.first_contact

    def ask(*arguments, **named):
        if len(asked) == count:
            raise KeyboardInterrupt
        asked.append(arguments)
        return original(*arguments, **named)

    monkeypatch.setattr(courses.query, "first_contact", ask)
    return asked


def lines(path):
    """Rows without what depends on the clock."""
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    return [{key: x for key, x in row.items() if key != "stats"} for row in rows]


@pytest.fixture
def whole(tmp_path, capsys):
    """The rows of a run that nothing stopped, as JSON lines and CSV, and what it says."""
    assert command(tmp_path, "--jsonl", str(tmp_path / "whole.jsonl"), "--csv", str(tmp_path / "whole.csv")) == 1
    assert not [x for x in tmp_path.iterdir() if "parts" in x.name]
    told = capsys.readouterr().out
    return lines(tmp_path / "whole.jsonl"), (tmp_path / "whole.csv").read_text(), told


def test_rows_name_waypoints_and_joints(tmp_path, whole):
    rows, table, told = whole
    assert [row["status"] for row in rows] == ["CONTACT"] + 11 * ["FREE"]
    (hit, *free), (first, *_) = list(csv.DictReader(table.splitlines())), rows
    k = int(hit["waypoint"])
    assert first["waypoints"] == [k, k + 1] and k / 10 <= first["time"] <= (k + 1) / 10
    assert f"between waypoints {k} and {k + 1}" in told and "12 pairs, 11 of them FREE from waypoint 0 to 30" in told
    share = 10 * first["time"]
    assert [float(hit[name]) for name in ("turn", "bend", "tilt")] == pytest.approx(
        [share / 30, share / 35, -share / 100], abs=1e-12
    )
    assert {row["waypoint"] for row in free} == {""}


@pytest.mark.share(3)
@pytest.mark.parametrize("count", [3, 30, 70])
def test_a_run_that_is_stopped_goes_on(tmp_path, whole, capsys, monkeypatch, count):
    """12 pairs are asked in each of 8 parts, one fewer from the contact on."""
    out, table = tmp_path / "out.jsonl", tmp_path / "out.csv"
    with monkeypatch.context() as patch:
        stop_after(patch, count)
        assert command(tmp_path, "--jsonl", str(out), "--csv", str(table)) == 130
    done = 4 * (count // 12)
    told = capsys.readouterr().err
    assert f"decided from waypoint 0 to {done} of 30, kept in {out}.parts; the same command with --resume" in told
    contact = [row for row in whole[0] if row["status"] == "CONTACT" and row["waypoints"][1] <= done]
    assert lines(out) == contact
    with monkeypatch.context() as patch:
        asked = stop_after(patch, 1000)
        assert command(tmp_path, "--jsonl", str(out), "--csv", str(table), "--resume") == 1
        first = min(float(span[0]) for _, _, span in asked)
    assert first == pytest.approx(done / 10)
    assert lines(out) == whole[0] and table.read_text() == whole[1]
    assert capsys.readouterr().out == whole[2]
    assert not [x for x in tmp_path.iterdir() if "parts" in x.name]


def test_a_torn_part_is_done_again(tmp_path, whole, monkeypatch):
    out = tmp_path / "out.jsonl"
    with monkeypatch.context() as patch:
        stop_after(patch, 70)
        assert command(tmp_path, "--jsonl", str(out)) == 130
    parts = sorted(tmp_path.glob("out.jsonl.parts/rows-*"))
    assert len(parts) >= 4
    parts[1].write_text(parts[1].read_text().replace("rows", "row"))
    asked = stop_after(monkeypatch, 1000)
    assert command(tmp_path, "--jsonl", str(out), "--resume") == 1
    assert min(float(span[0]) for _, _, span in asked) == pytest.approx(0.4)
    assert lines(out) == whole[0]


def test_what_is_not_the_same_run_is_refused(tmp_path, capsys, monkeypatch):
    out = str(tmp_path / "out.jsonl")
    assert command(tmp_path, "--jsonl", out, "--resume") == 3
    assert "nothing is left to go on with; leave --resume out" in capsys.readouterr().err
    assert command(tmp_path, "--resume") == 3
    assert "--resume: give the --csv or --jsonl file" in capsys.readouterr().err
    with monkeypatch.context() as patch:
        stop_after(patch, 30)
        assert command(tmp_path, "--jsonl", out) == 130
    capsys.readouterr()
    other = trajectory(tmp_path, "other.csv", shift=0.125)
    assert command(tmp_path, "--jsonl", out, "--resume", path=other) == 3
    assert "holds parts of another job (trajectory differ)" in capsys.readouterr().err
    assert command(tmp_path, "--jsonl", out, "--resume", "--cubic") == 3
    assert "(interpolation differ)" in capsys.readouterr().err
    assert command(tmp_path, "--jsonl", out) == 1  # anew
    assert not (tmp_path / "out.jsonl.parts").exists()


def test_it_tells_how_far_it_is(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(progress, "LOG_TICK", 0.001)
    assert command(tmp_path, "--progress") == 1
    told = capsys.readouterr().err.splitlines()
    assert any(" of 30, " in line and "a second" in line and "left" in line for line in told), told
    assert "lamp.urdf: waypoints: 30 of 30" in told[-1]


def test_an_interrupted_json_says_so(tmp_path, monkeypatch):
    target = tmp_path / "out.json"
    with monkeypatch.context() as patch:
        stop_after(patch, 90)
        assert command(tmp_path, "--json", str(target)) == 130
    found = json.loads(target.read_text())
    assert found["interrupted"] is True and [x["status"] for x in found["checks"]] == ["CONTACT"]
    assert command(tmp_path, "--json", str(target)) == 1
    assert json.loads(target.read_text())["robot"] == "lamp"
