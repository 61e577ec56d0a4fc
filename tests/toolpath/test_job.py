"""Long programs: what is finished is kept, streams, and is not done again; the command."""

import csv
import json
import tracemalloc
from pathlib import Path

import pytest

import firstcontact as fc
from firstcontact.cli import run
from firstcontact.toolpath import job
from firstcontact.toolpath.check import Setup

ROOT = Path(__file__).resolve().parents[2]
TOOL = fc.Tool([("flutes", "cutter", 6, 20)])
POST = fc.examples.box((10, 10, 30))
SETUP = """
[tool.mill]
segments = [{ name = "flutes", kind = "cutter", diameter = 6, length = 20 }]
[body.post]
shape = "box"
size = [10, 10, 30]
"""


def program(tmp_path, count, every=10):
    """There and back beside the post, through it in every tenth block."""
    lines = [f"G1 X{20 - 40 * (k % 2)} Y{0 if k % every == 5 else 12}" for k in range(count)]
    file = tmp_path / "job.nc"
    file.write_text("\n".join(lines), encoding="utf-8")
    return fc.ToolPath(file, start=(20, 12, 0))


class Counted(Setup):
    """How many blocks were asked about, and an interrupt before a chunk."""

    asked, stop = 0, None

    def of_chunk(self, blocks):
        if self.stop is not None and self.asked >= self.stop:
            raise KeyboardInterrupt
        self.asked += len(blocks)
        return super().of_chunk(blocks)


def counted(stop=None):
    setup = Counted(TOOL, {"post": POST}, workers=1)
    setup.stop = stop
    return setup


def test_an_interrupted_job_goes_on_where_it_was(tmp_path):
    path, kept = program(tmp_path, 100), tmp_path / "kept.jsonl"
    whole = list(job.verdicts(path, counted(), chunk=16))
    assert {x.status for x in whole} == {"FREE", "CONTACT"} and len(whole) == 100
    setup, told = counted(stop=48), []
    with pytest.raises(KeyboardInterrupt, match="48 of 100 blocks are done; they are kept in .*kept.jsonl"):
        for verdict in job.verdicts(path, setup, resume=kept, chunk=16):
            told.append(verdict)
    assert told == whole[:48]
    setup = counted()
    seen = []
    again = list(job.verdicts(path, setup, resume=kept, chunk=16, progress=lambda *x: seen.append(x)))
    assert again == whole and setup.asked == 52
    assert seen[0] == (0, 100) and seen[1] == (48, 100) and seen[-1] == (100, 100)
    setup = counted()
    assert list(job.verdicts(path, setup, resume=kept)) == whole and setup.asked == 0


@pytest.mark.share(2)
@pytest.mark.parametrize("cut", [1, 30])
def test_a_torn_line_is_done_again(tmp_path, cut):
    path, kept = program(tmp_path, 60), tmp_path / "kept.jsonl"
    whole = list(job.verdicts(path, counted(), resume=kept, chunk=16))
    kept.write_bytes(kept.read_bytes()[:-cut])
    setup = counted()
    assert list(job.verdicts(path, setup, resume=kept, chunk=16)) == whole and setup.asked == 12


DAMAGED = ["{}", '{"blocks": 16}', "null", '{"blocks": 16, "found": {"0": [{"par', '{"blocks": 1, "found": []}']


@pytest.mark.share(6)
@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_line_is_named(tmp_path, damage):
    path, kept = program(tmp_path, 60), tmp_path / "kept.jsonl"
    list(job.verdicts(path, counted(), resume=kept, chunk=16))
    lines = kept.read_text().splitlines()
    kept.write_text("\n".join([*lines[:2], damage, *lines[3:], ""]))
    with pytest.raises(fc.InputError, match="kept.jsonl: line 3 is damaged; remove the file"):
        list(job.verdicts(path, counted(), resume=kept, chunk=16))


def test_the_blocks_of_another_job_are_refused(tmp_path):
    path, kept = program(tmp_path, 20), tmp_path / "kept.jsonl"
    list(job.verdicts(path, counted(), resume=kept))
    with pytest.raises(fc.InputError, match="another job .tools differ"):
        list(job.verdicts(path, Setup(fc.Tool([("thin", "cutter", 1, 20)]), {"post": POST}), resume=kept))
    with pytest.raises(fc.InputError, match="another job .bodies and allowed differ"):
        list(job.verdicts(path, Setup(TOOL, {"post": POST.translated((0, 1, 0))}, ()), resume=kept))
    path.path.write_text(path.path.read_text() + "\nX0")
    with pytest.raises(fc.InputError, match="another job .program differ"):
        list(job.verdicts(path, counted(), resume=kept))
    kept.write_text("a letter\n")
    with pytest.raises(fc.InputError, match="keeps no tool path"):
        list(job.verdicts(path, counted(), resume=kept))


def test_a_fault_ends_a_job_before_it_begins(tmp_path):
    path, setup = program(tmp_path, 40), counted()
    path.path.write_text(path.path.read_text() + "\nG1 A3")
    with pytest.raises(fc.InputError, match="line 41: A3"):
        next(job.verdicts(path, setup, chunk=4))
    assert setup.asked == 0


def test_chunks_do_not_change_what_is_told(tmp_path):
    path = program(tmp_path, 50)
    whole = list(job.verdicts(path, counted(), chunk=50))
    assert list(job.verdicts(path, counted(), chunk=7)) == whole
    assert list(job.verdicts(path, Setup(TOOL, {"post": POST}, workers=2))) == whole


@pytest.mark.thorough
def test_memory_does_not_grow_with_the_program(tmp_path):
    peaks, away = [], {"post": POST.translated((0, 90, 0))}
    for count in (400, 400, 2400):
        path = program(tmp_path, count)
        tracemalloc.start()
        for _ in job.verdicts(path, Setup(TOOL, away, workers=1), chunk=64):
            pass
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[2] < 1.5 * peaks[1]


# -- the command ----------------------------------------------------------------------------------------------------


def command(tmp_path, *more, lines=20, start="20 12 0", every=10):
    scene = tmp_path / "setup.toml"
    scene.write_text(SETUP)
    path = program(tmp_path, lines, every).path
    return run(["toolpath", str(path), "--scene", str(scene), "--workers", "1",
                *(["--from", start] if start else []), *more])  # fmt: skip


def test_only_contacts_are_printed(tmp_path, capsys):
    assert command(tmp_path) == 1
    shown = capsys.readouterr().out.splitlines()
    assert [x for x in shown if x.startswith("line")] == [f"line {k}: {x}: CONTACT" for k, x in [
        (6, "G1 X-20 Y0"), (7, "G1 X20 Y12"), (16, "G1 X-20 Y0"), (17, "G1 X20 Y12")]]  # fmt: skip
    assert shown[-1] == "20 blocks that move the tool: 4 in contact, 16 free"
    assert command(tmp_path, "--all") == 1
    assert sum(x.startswith("line") for x in capsys.readouterr().out.splitlines()) == 20


def test_rows_and_lines(tmp_path, capsys):
    table, lines = tmp_path / "o.csv", tmp_path / "o.jsonl"
    assert command(tmp_path, "--csv", str(table), "--jsonl", str(lines), "--all") == 1
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == 20 and {x["status"] for x in rows} == {"FREE", "CONTACT"}
    hit = rows[5]
    named = [hit[key] for key in ("line", "part", "kind", "body", "move")]
    assert named == ["6", "flutes", "cutter", "post", "feed"]
    assert float(hit["lo"]) <= float(hit["fraction"]) <= float(hit["hi"])
    told = [json.loads(x) for x in lines.read_text().splitlines()]
    assert [x["line"] for x in told] == list(range(1, 21))
    assert told[5]["findings"][0]["fraction"] == float(hit["fraction"])
    capsys.readouterr()
    assert command(tmp_path, "--jsonl", "-") == 1
    assert [json.loads(x)["line"] for x in capsys.readouterr().out.splitlines()] == [6, 7, 16, 17]


def test_exit_codes(tmp_path, capsys):
    assert command(tmp_path, lines=3) == 0
    assert command(tmp_path, lines=3, start="") == 2
    assert "does not tell where they begin or end: line 1, 2, 3 (--from)" in capsys.readouterr().out
    assert command(tmp_path, "--allow", "*:feed:post") == 0
    assert command(tmp_path, "--from", "1 2") == 3
    assert command(tmp_path, "--allow", "cutter") == 3
    assert command(tmp_path, "--allow", "*:*:*", "--strict") == 3
    assert command(tmp_path, "--csv", "-", "--jsonl", "-") == 3
    assert command(tmp_path, "--allow", "cutter:feed:pots*") == 3
    assert command(tmp_path, "--allow", "shank:feed:post") == 3
    assert command(tmp_path, lines=0) == 3
    err = capsys.readouterr().err.splitlines()
    assert "no body 'pots*'; the bodies are post" in err[4]
    assert "no part 'shank'; the parts are cutter, flutes" in err[5]
    assert "job.nc: nothing in it moves the tool" in err[6]
    assert len(err) == 7 and all(x.startswith("firstcontact: ") for x in err)


def test_a_scene_without_tool_and_one_with_a_wrong_one(tmp_path, capsys):
    file = tmp_path / "scene.toml"
    nc = program(tmp_path, 2).path
    file.write_text(SETUP[SETUP.index("[body") :])
    assert run(["toolpath", str(nc), "--scene", str(file)]) == 3
    file.write_text(SETUP.replace("diameter = 6", "diameter = -6"))
    assert run(["toolpath", str(nc), "--scene", str(file)]) == 3
    file.write_text(SETUP.replace("length = 20", "height = 20"))
    assert run(["toolpath", str(nc), "--scene", str(file)]) == 3
    first, second, third = capsys.readouterr().err.splitlines()
    assert "no tool; add a [tool.NAME]" in first
    assert "tool.mill: mill: segments[0] (flutes): diameters have to be positive" in second
    assert "tool.mill.segments[0]: unknown key 'height'; keys here are name, kind, diameter, length" in third


def test_an_interrupt_keeps_rows_and_blocks(tmp_path, capsys, monkeypatch):
    table, kept = tmp_path / "o.csv", tmp_path / "kept.jsonl"
    ask, calls = Setup.of_chunk, []

    def once(self, blocks):
        calls.append(len(blocks))
        if len(calls) == 2:
            raise KeyboardInterrupt
        return ask(self, blocks)

    monkeypatch.setattr(Setup, "of_chunk", once)
    given = "--csv", str(table), "--resume", str(kept)
    assert command(tmp_path, *given, lines=1100, every=100) == 130
    assert "interrupted; 1,024 of 1,100 blocks are done; they are kept in" in capsys.readouterr().err
    before = table.read_text().splitlines()
    assert len(before) == 23
    assert command(tmp_path, *given, lines=1100, every=100) == 1
    assert calls == [1024, 76, 76] and table.read_text().splitlines()[: len(before)] == before


def test_the_example(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    given = ["toolpath", "examples/pocket.nc", "--scene", "examples/setup.toml", "--from", "0 0 80"]
    assert run(given) == 1
    text = capsys.readouterr().out
    assert "line 19: N150 X34 Y24: CONTACT" in text and "collet (holder, feed) / clamp: meets" in text
    assert text.endswith("14 blocks that move the tool: 2 in contact, 12 free\n")
