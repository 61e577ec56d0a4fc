"""`firstcontact intervals`: all times of contact."""

import json

import pytest

CHECK = '[[check]]\npair = ["left", "right"]\n'


def test_the_passage_of_a_cube_is_one_interval(command, cubes):
    code, out, _ = command("intervals", cubes("1.1"), "--span", "0", "10")
    assert code == 1
    first, second = out.splitlines()
    assert first == "left and right: CONTACT"
    assert second == "  [0.3333333333333333, 7.0]"


def test_ends_are_exact_on_demand(command, cubes):
    out = command("intervals", cubes("1.1"), "--span", "0", "10", "--exact", "--json", "-").out
    (entry,) = json.loads(out)["checks"]
    (interval,) = entry["intervals"]
    assert (interval["start_exact"], interval["end_exact"]) == ("1/3", "7")
    assert interval["start_interval"][0] <= interval["start"] == pytest.approx(1 / 3, abs=1e-15)


def test_free_returns_0_and_a_spent_budget_2(command, cubes):
    assert command("intervals", cubes("1.5")).code == 0
    code, out, _ = command("intervals", cubes("1.1", CHECK + "budget = 1\n"))
    assert code == 2 and "UNDECIDED (budget)" in out


def test_the_page_shows_the_intervals(command, cubes, tmp_path):
    page = tmp_path / "page.html"
    command("intervals", cubes("1.1"), "--html", page)
    assert "<html" in page.read_text(encoding="utf-8")
