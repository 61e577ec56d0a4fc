"""`firstcontact batch`: what it reads, writes, refuses and takes up again."""

import csv
import json
import math
import os
import re
import signal
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
import pytest

import firstcontact as fc
from firstcontact.batch import files, kept_parts, query_files
from firstcontact.scene.load import load_scene
from one_by_one import answer

SCENE = """
[body.cube]
shape = "box"
size = [1, 1, 1]
[body.wall]
shape = "polyhedron"
vertices = [[3, -9, -9], [3, 9, -9], [3, 9, 9], [3, -9, 9]]
faces = [[0, 1, 2, 3]]
[body.tetra]
shape = "polyhedron"
vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
[body.train]
shape = "box"
size = [1, 1, 1]
at = [0, 20, 0]
motion = { type = "translation", vector = [4, 0, 0] }
"""
TURN = [0.0, -1.0, 0.0, 5.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
STAY = np.eye(4).ravel().tolist()
SUFFIXES = ".parquet", ".csv", ".jsonl"


@pytest.fixture
def bodies(scene):
    return scene(SCENE)


@pytest.fixture
def queries(tmp_path):
    """Write rows as a file of queries and give its path."""

    def write(rows, suffix=".jsonl"):
        path = tmp_path / f"queries{suffix}"
        if suffix == ".jsonl":
            path.write_text("".join(json.dumps(row) + "\n" for row in rows))
        elif suffix == ".parquet":
            pq.write_table(pa.Table.from_pylist(rows), path, row_group_size=5)
        else:
            with path.open("w", newline="") as file:
                table = csv.DictWriter(file, list(rows[0]))
                table.writeheader()
                table.writerows(rows)
        return path

    return write


@pytest.fixture
def batch(command, bodies, tmp_path):
    """Run it: batch(queries, *options) -> (outcome, rows of the answer)."""

    def call(path, *options, out="answers.jsonl"):
        outcome = command("batch", path, "--bodies", bodies, "--out", tmp_path / out, "--workers", 1, *options)
        return outcome, read(tmp_path / out) if (tmp_path / out).exists() else None

    return call


def read(path):
    """Rows as dictionaries, numbers as numbers."""
    if path.suffix == ".jsonl":
        return [json.loads(line) for line in path.read_text().splitlines()]
    if path.suffix == ".parquet":
        return pq.read_table(path).to_pylist()
    convert = pa.csv.ConvertOptions(strings_can_be_null=True)
    return pa.csv.read_csv(path, convert_options=convert).to_pylist()


def shifts(n, seed=0):
    rng = np.random.default_rng(seed)
    vectors = enumerate(rng.uniform([0, -2, -2], [4, 2, 2], (n, 3)).tolist())
    return [{"id": f"q{k}", "a": "tetra", "b": "wall", "vx": x, "vy": y, "vz": z} for k, (x, y, z) in vectors]


def expected(rows, scene):
    """The same by `first_contact`, one by one."""
    bodies = load_scene(scene).bodies
    return [
        {"id": row["id"], "a": row["a"], "b": row["b"]} | answer(fc.first_contact(
            bodies[row["a"]].moving(fc.Translation((row["vx"], row["vy"], row["vz"]))), bodies[row["b"]]))
        for row in rows
    ]  # fmt: skip


@pytest.mark.share(3)
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("out", SUFFIXES)
def test_all_formats_give_the_answers_of_first_contact(batch, queries, bodies, suffix, out):
    rows = shifts(23)
    outcome, answers = batch(queries(rows, suffix), out=f"answers{out}")
    assert outcome.code == 1 and outcome.err == ""
    assert answers == expected(rows, bodies)


MOTIONS = {
    "vector": ({"vector": [4, 0, 0]}, fc.Translation((4, 0, 0))),
    "apart": ({"vx": 4, "vy": 0.5, "vz": 0}, fc.Translation((4, 0.5, 0))),
    "degrees": ({"axis": [0, 0, 1], "point": [3, 0.25, 0], "degrees": 100},
                fc.Rotation((0, 0, 1), (3, 0.25, 0), degrees=100)),
    "radians": ({"ax": 0, "ay": 1, "az": 0, "px": 2, "py": 0, "pz": 1, "radians": 3.0},
                fc.Rotation((0, 1, 0), (2, 0, 1), radians=3.0)),
    "turns": ({"axis": [0, 1, 0], "point": [2, 0, 0], "turns": 0.75}, fc.Rotation((0, 1, 0), (2, 0, 0), turns=0.75)),
    "origin": ({"axis": [0, 1, 0], "turns": 0.75}, fc.Rotation((0, 1, 0), turns=0.75)),
    "poses": ({"pose0": STAY, "pose1": TURN},
              fc.RationalMotion.between(np.eye(4), np.reshape(TURN, (4, 4)))),
    "square poses": ({"pose0": np.eye(4).tolist(), "pose1": np.reshape(TURN, (4, 4)).tolist()},
                     fc.RationalMotion.between(np.eye(4), np.reshape(TURN, (4, 4)))),
    "none": ({}, None),
}  # fmt: skip


@pytest.mark.share(4)
@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_motions(batch, queries, bodies, name, suffix):
    columns, motion = MOTIONS[name]
    outcome, (row,) = batch(queries([{"a": "tetra", "b": "wall"} | columns], suffix))
    shapes = load_scene(bodies).bodies
    tetra = shapes["tetra"] if motion is None else shapes["tetra"].moving(motion)
    assert row == {"a": "tetra", "b": "wall"} | answer(fc.first_contact(tetra, shapes["wall"]))


def test_rows_of_all_kinds_in_one_file(batch, queries, bodies):
    """With spans of their own, and a body that moves in the scene."""
    twice = "vector", "axis", "point"
    empty = dict.fromkeys(key for columns, _ in MOTIONS.values() for key in columns if key not in twice)
    rows, hits = [], []
    shapes = load_scene(bodies).bodies
    for name in ("apart", "radians", "none", "poses", "apart"):
        columns, motion = MOTIONS[name]
        tetra = shapes["tetra"] if motion is None else shapes["tetra"].moving(motion)
        for span in (None, [0, 0.75]):
            rows.append({"a": "tetra", "b": "wall"} | empty | columns | {"span": span})
            hits.append(fc.first_contact(tetra, shapes["wall"], span))
    rows.append({"a": "train", "b": "cube"} | empty | {"span": [0, 10]})
    hits.append(fc.first_contact(shapes["train"], shapes["cube"], (0, 10)))
    rows.append({"a": "cube", "b": "train"} | empty | {"vx": 0, "vy": 15, "vz": 0, "span": [0, math.inf]})
    hits.append(fc.first_contact(shapes["cube"].moving(fc.Translation((0, 15, 0))), shapes["train"], (0, math.inf)))
    outcome, answers = batch(queries(rows))
    assert [{k: v for k, v in row.items() if k not in "ab"} for row in answers] == [
        answer(hit) | ({"free_until": "inf"} if hit.free_until == math.inf else {}) for hit in hits
    ]


@pytest.mark.parametrize("columns", [
    {"vx": pa.array([4, 2], pa.int32()), "vy": pa.array([0, 0.5], pa.float32()), "vz": pa.array([0, 0], pa.int8())},
    {"vx": pa.array(["4", "2"]).cast(pa.decimal128(5, 2)), "vy": pa.array(["0", " 0.5"]), "vz": pa.array([0.0, 0.0])},
    {"vector": pa.array([[4, 0, 0], [2, 0.5, 0]], pa.list_(pa.float32(), 3))},
    {"vector": pa.array([[4, 0, 0], [2, 0.5, 0]], pa.large_list(pa.float64()))},
    {"vector": pa.chunked_array([[[4, 0, 0]], [[2, 0.5, 0]]], pa.list_(pa.float64()))},
], ids=["small", "texts", "fixed", "large", "chunks"])  # fmt: skip
def test_parquet_of_all_types(batch, bodies, tmp_path, columns):
    keys = {"a": pa.array(["tetra", "tetra"]).dictionary_encode(), "b": pa.array(["wall", "wall"], pa.large_string())}
    pq.write_table(pa.table(keys | columns), tmp_path / "queries.parquet")
    _, answers = batch(tmp_path / "queries.parquet", out="answers.parquet")
    shapes = load_scene(bodies).bodies
    tetra, vectors = shapes["tetra"], ((4, 0, 0), (2, 0.5, 0))
    hits = [fc.first_contact(tetra.moving(fc.Translation(v)), shapes["wall"]) for v in vectors]
    assert answers == [{"a": "tetra", "b": "wall"} | answer(hit) for hit in hits]


def test_columns_are_carried_along(batch, queries):
    rows = [row | {"tag": [k, None], "weight": None if k % 2 else k / 4} for k, row in enumerate(shifts(5))]
    _, answers = batch(queries(rows, ".parquet"), out="answers.parquet")
    assert [(x["id"], x["tag"], x["weight"]) for x in answers] == [(x["id"], x["tag"], x["weight"]) for x in rows]
    assert "vx" not in answers[0]
    outcome, _ = batch(queries(rows, ".parquet"), out="answers.csv")
    assert outcome.code == 3 and "column tag holds lists" in outcome.err


def test_json_lines_whose_kinds_change_from_chunk_to_chunk(batch, queries, monkeypatch):
    vectors = [[4, 0, 0], [4, 0, 0], [4, 0.5, 0], None, None, [4, 0, 0]]
    extra = [{}, {"n": 1}, {"n": None}, {"n": 0.5}, {"tag": "x"}, {}]
    rows = [{"a": "tetra", "b": "wall", "vector": v} | more for v, more in zip(vectors, extra, strict=True)]
    _, whole = batch(queries(rows), out="whole.jsonl")
    assert [row["n"] for row in whole] == [None, 1, None, 0.5, None, None]
    assert [row["status"] for row in whole] == ["CONTACT"] * 3 + ["FREE"] * 2 + ["CONTACT"]
    for chunk in (1, 2, 4):
        monkeypatch.setattr(query_files, "CHUNK", chunk)
        for size in (1, 2, 5):
            monkeypatch.setattr(files, "FIRST_ROWS", size)
            monkeypatch.setattr(files, "MOST_ROWS", size)
            outcome, answers = batch(queries(rows))
            assert answers == whole, outcome
    outcome, _ = batch(queries([*rows, rows[0] | {"n": "text"}]))
    assert outcome.code == 3 and outcome.err.count("\n") == 1


def test_an_error_of_one_query_is_its_row(batch, queries, bodies):
    rows = shifts(3)
    rows[1] |= {"t0": 1, "t1": 0}
    outcome, answers = batch(queries([{"t0": None, "t1": None} | row for row in rows]))
    good = expected([rows[0], rows[2]], bodies)
    assert [answers[0], answers[2]] == good
    assert answers[1]["status"] is None and "span" in answers[1]["error"] and answers[1]["time"] is None
    assert "1 error" in outcome.out and "  error: row 1: " in outcome.out


def test_exit_codes_and_summary(batch, queries):
    rows = [row | {"vx": -1.0} for row in shifts(5)]
    outcome, _ = batch(queries(rows))
    assert outcome.code == 0 and "5 queries in" in outcome.out and outcome.out.rstrip().count("5 FREE") == 1
    rows[3]["vx"] = 4.0
    outcome, answers = batch(queries(rows))
    assert outcome.code == 1 and "4 FREE, 1 CONTACT" in outcome.out
    assert f"most work: row 3 ({answers[3]['work']} steps)" in outcome.out
    outcome, answers = batch(queries(rows), "--budget", 5)
    assert outcome.code == 2 and "1 UNDECIDED" in outcome.out and "undecided: row 3\n" in outcome.out
    assert answers[3]["reason"] == "budget"
    bad = {"t0": 1, "t1": 0}
    outcome, _ = batch(queries([row | bad for row in rows]))
    assert outcome.code == 2 and "5 error" in outcome.out and outcome.out.count("error: row") == 3


def test_exact(batch, queries):
    outcome, (row,) = batch(queries([{"a": "tetra", "b": "wall", "vector": [6, 0, 0]}]), "--exact")
    assert outcome.code == 1 and row["lo"] <= 1 / 3 <= row["hi"]


GOOD = {"a": "tetra", "b": "wall", "vx": 4, "vy": 0, "vz": 0}
SECOND = {  # what is wrong with row 1, and what the line says of it
    "key": ({"b": "wal"}, "row 1, column b: no body 'wal'; the bodies are cube, wall, tetra, train"),
    "no key": ({"a": None}, "row 1, column a: no body None"),
    "text": ({"vy": "x"}, "row 1, column vy: "),
    "not finite": ({"vz": math.inf}, "row 1, column vz: "),
    "half a vector": ({"vz": None}, "row 1, column vz: null beside vx"),
    "moves already": ({"a": "train"}, "row 1, column a: this body moves in the scene already"),
}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", SECOND)
def test_a_bad_row_stops_it_with_one_line(batch, queries, suffix, name):
    wrong, line = SECOND[name]
    if suffix == ".parquet" and name == "text":
        pytest.skip("a column of a Parquet file has one type")
    path = queries([GOOD, GOOD | wrong], suffix)
    outcome, answers = batch(path)
    assert outcome.code == 3 and answers is None and outcome.out == ""
    assert outcome.err.startswith(f"firstcontact: {path}: {line}") and outcome.err.count("\n") == 1


@pytest.mark.parametrize("rows, line", [
    ([{"a": "tetra"}], "column b is missing"),
    ([{"a": "tetra", "b": "wall", "vx": 1, "vz": 1}], "column vy is missing beside vx"),
    ([GOOD | {"vector": [1, 0, 0]}], "columns vector and vx say the same"),
    ([{"a": "tetra", "b": "wall", "vector": [1, 0]}], "row 0, column vector: [1, 0] is no list of 3 numbers"),
    ([{"a": "tetra", "b": "wall", "vector": 7}], "row 0, column vector: 7 is no list of 3 numbers"),
    ([{"a": "tetra", "b": "wall", "vector": [1, None, 0]}], "row 0, column vector: None is no finite number"),
    ([{"a": "tetra", "b": "wall", "pose0": STAY}], "column pose0 needs pose1"),
    ([{"a": "tetra", "b": "wall", "pose0": STAY, "pose1": STAY[:8]}], "row 0, column pose1: "),
    ([{"a": "tetra", "b": "wall", "degrees": 3}], "column degrees needs axis"),
    ([{"a": "tetra", "b": "wall", "axis": [0, 0, 1]}], "column axis needs degrees or radians or turns"),
    ([{"a": "tetra", "b": "wall", "axis": [0, 0, 0], "turns": 1}], "row 0, column axis: zero"),
    ([GOOD | {"axis": [0, 0, 1], "turns": 1}], "row 0, column axis: a second motion of one query"),
    ([{"a": "tetra", "b": "wall", "axis": [0, 0, 1], "turns": 1, "degrees": 1}], "row 0, column axis: give one of"),
    ([GOOD | {"vx": True}], "row 0, column vx: True is no double"),
    ([GOOD | {"vx": 2**53 + 1}], "row 0, column vx: 9007199254740993 is no double"),
    ([GOOD | {"time": 3}], "column time is to be carried along, but answers have one"),
    ([GOOD | {"id": 3}, GOOD | {"id": "x"}], "row 1, column id: 'x' is of several kinds, or of another one than"),
    ([GOOD | {"span": [0, "x"]}], "row 0, column span: [0, 'x'] is of several kinds"),
    ([], "holds no query"),
])  # fmt: skip
def test_bad_columns_stop_it_with_one_line(batch, queries, rows, line):
    path = queries(rows)
    outcome, _ = batch(path)
    assert outcome.code == 3 and outcome.out == "" and outcome.err.count("\n") == 1
    assert line in outcome.err and str(path) in outcome.err


def test_a_fault_far_down_stops_it_before_the_work_begins(batch, queries, monkeypatch):
    monkeypatch.setattr(query_files, "CHUNK", 4)
    rows = shifts(11)
    rows[9]["vy"] = math.nan
    for suffix in SUFFIXES:
        outcome, _ = batch(queries(rows, suffix))
        assert outcome.code == 3 and re.search("row 9, column vy: '?nan'? is no finite number", outcome.err)


@pytest.mark.parametrize("name, content, line", [
    ("q.parquet", b"", "no parquet file that can be read"),
    ("q.parquet", b"PAR1 is what it begins with", "no parquet file that can be read"),
    ("q.csv", b"", "empty"),
    ("q.csv", b"a,b\n", "holds no query"),
    ("q.csv", b"a,b\ntetra,wall\ntetra\n", "no csv file that can be read"),
    ("q.csv", b"a,a\n1,2\n", "two columns are called a"),
    ("q.csv", b"a,b\ntetra,\xff\n", "no csv file that can be read"),
    ("q.jsonl", b"", "holds no query"),
    ("q.jsonl", b"\xff\xfe", "not text"),
    ("q.jsonl", b'{"a": 1}\n{"a": \n', "row 1 is no JSON"),
    ("q.jsonl", b"[1]\n", "row 0 is [1]"),
    ("q.txt", b"", "queries stand in files that end with .parquet, .csv, .jsonl"),
])  # fmt: skip
def test_bad_files_stop_it_with_one_line(batch, tmp_path, name, content, line):
    path = tmp_path / name
    path.write_bytes(content)
    outcome, _ = batch(path)
    assert outcome.code == 3 and outcome.err.count("\n") == 1 and f"{path}: {line}" in outcome.err


def test_a_truncated_parquet_file_and_files_that_are_not_there(batch, queries, tmp_path):
    path = queries(shifts(50), ".parquet")
    path.write_bytes(path.read_bytes()[:-30])
    assert batch(path)[0].err.startswith(f"firstcontact: {path}: no parquet file")
    (tmp_path / "answers.jsonl").touch()
    for name in ("none.parquet", "none.csv", "none.jsonl"):
        outcome, _ = batch(tmp_path / name)
        assert outcome.code == 3 and f"{name}: no such file" in outcome.err
    (tmp_path / "folder.parquet").mkdir()
    assert "folder.parquet: is a directory" in batch(tmp_path / "folder.parquet")[0].err


def test_bad_outputs(batch, queries):
    path = queries([GOOD])
    assert "end with .parquet, .csv, .jsonl" in batch(path, out="answers.txt")[0].err
    assert "cannot be written" in batch(path, out="none/answers.csv")[0].err
    outcome, _ = batch(path, out="queries.jsonl")
    assert outcome.code == 3 and "is read for this answer" in outcome.err
    outcome, _ = batch(path, "--budget", 2**60 + 1)
    assert outcome.code == 3 and "budget is " in outcome.err


# -- going on ---------------------------------------------------------------------------------------------------------


class Killed(BaseException):
    """What a kill looks like from within: nothing after it runs."""


@pytest.fixture
def small_parts(monkeypatch):
    monkeypatch.setattr(files, "FIRST_ROWS", 2)
    monkeypatch.setattr(files, "MOST_ROWS", 4)
    monkeypatch.setattr(query_files, "CHUNK", 3)


def kill_at(monkeypatch, moment):
    """End the job just before, or just after, the change of a name."""
    original, changes = os.replace, []

    def replace(*names):
        changes.append(names)
        if len(changes) == (moment + 2) // 2:
            if moment % 2:
                original(*names)
            raise Killed
        original(*names)

    monkeypatch.setattr(kept_parts.os, "replace", replace)


@pytest.mark.thorough
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_it_goes_on_after_a_kill_at_any_moment(batch, queries, bodies, tmp_path, monkeypatch, small_parts, suffix):
    path = queries(shifts(9), suffix)
    _, whole = batch(path, out=f"whole{suffix}")
    for moment in range(40):
        with monkeypatch.context() as patch:
            kill_at(patch, moment)
            try:
                batch(path, out=f"answers{suffix}")
            except Killed:
                pass
            else:
                break
        outcome, answers = batch(path, out=f"answers{suffix}")
        assert answers == whole, moment
        assert not [x for x in tmp_path.iterdir() if "parts" in x.name]
        (tmp_path / f"answers{suffix}").unlink()
    assert moment == 12  # job.json, three parts, the answers, the folder's end


def test_finished_parts_are_not_asked_again(batch, queries, tmp_path, monkeypatch, small_parts):
    asked = []
    original = files.answered

    def answered(questions, *arguments, **named):
        asked.append(len(questions))
        return original(questions, *arguments, **named)

    monkeypatch.setattr(files, "answered", answered)
    path = queries(shifts(20), ".parquet")
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_at(patch, 6)  # before the third part
        batch(path)
    assert asked == [2, 4, 4]
    del asked[:]
    (tmp_path / "answers.jsonl.parts" / "rows-000000000000-000000000002.parquet").unlink()
    batch(path)
    assert sum(asked) == 16 and asked[0] == 2


@pytest.fixture
def harmed(batch, queries, tmp_path, monkeypatch, small_parts):
    """A job that was killed, and has a harmed part: its questions, and what it would have told as a whole."""

    def made(harm):
        path = queries(shifts(20))
        _, whole = batch(path, out="whole.jsonl")
        with monkeypatch.context() as patch, pytest.raises(Killed):
            kill_at(patch, 8)
            batch(path)
        part = tmp_path / "answers.jsonl.parts" / "rows-000000000002-000000000006.parquet"
        data = bytearray(part.read_bytes())
        if harm == "truncated":
            data = data[:-9]
        else:
            data[60] ^= 0xFF
        part.write_bytes(data)
        return path, whole

    return made


@pytest.mark.share(2)
@pytest.mark.parametrize("harm", ["truncated", "swapped byte"])
def test_a_torn_part_is_done_again(batch, harmed, harm):
    path, whole = harmed(harm)
    assert batch(path)[1] == whole


def test_a_part_that_is_torn_meanwhile_is_named(batch, harmed, monkeypatch):
    path, whole = harmed("swapped byte")
    with monkeypatch.context() as patch:
        patch.setattr("firstcontact.batch.kept_parts.KeptParts._is_whole", lambda *_: True)
        outcome, _ = batch(path)
    assert outcome.code == 3 and "damaged, and removed; the same command does it again" in outcome.err
    assert batch(path)[1] == whole


def test_another_job_is_not_mixed_in(batch, queries, bodies, monkeypatch, small_parts):
    path = queries(shifts(9))
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_at(patch, 4)
        batch(path)
    assert "(options differ); finish that one, or remove the folder" in batch(path, "--exact")[0].err
    queries(shifts(9, seed=1))
    outcome, _ = batch(path)
    assert outcome.code == 3 and "(queries differ)" in outcome.err and outcome.err.count("\n") == 1
    queries(shifts(9))
    bodies.write_text(SCENE.replace("[1, 1, 1]", "[1, 1, 2]"))
    assert "(bodies differ)" in batch(path)[0].err
    bodies.write_text(SCENE + "# no matter\n")
    assert batch(path)[0].code == 1


def test_a_full_disk_is_told_and_what_is_finished_is_kept(batch, queries, monkeypatch, small_parts):
    """It was told of standard output."""
    path = queries(shifts(20))
    _, whole = batch(path, out="whole.jsonl")
    original, written = pq.write_table, []

    def write_table(table, target, **options):
        written.append(target)
        if len(written) == 3:
            raise OSError(28, "No space left on device")
        original(table, target, **options)

    with monkeypatch.context() as patch:
        patch.setattr(pq, "write_table", write_table)
        outcome, _ = batch(path)
    assert outcome.code == 3 and outcome.err.count("\n") == 1
    assert "rows-000000000006-000000000010.parquet: no space left on device; what is finished is kept" in outcome.err
    assert batch(path)[1] == whole


def test_an_interrupt_keeps_what_is_finished_and_says_how_to_go_on(batch, queries, monkeypatch, small_parts):
    path = queries(shifts(20))
    _, whole = batch(path, out="whole.jsonl")
    original, asked = files.answered, []

    def answered(*arguments, **named):
        asked.append(arguments)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return original(*arguments, **named)

    with monkeypatch.context() as patch:
        patch.setattr(files, "answered", answered)
        outcome, _ = batch(path)
    assert outcome.code == 130 and outcome.out == "" and outcome.err.count("\n") == 1
    assert "interrupted; 6 of 20 rows are kept in " in outcome.err
    assert "answers.jsonl.parts; the same command goes on from there" in outcome.err
    assert batch(path)[1] == whole


KILLED = """
import os, signal, sys
from firstcontact.batch import files, kept_parts
from firstcontact.cli import main
files.MOST_ROWS = 64
add = kept_parts.KeptParts.add
def add_and_die(self, begin, table):
    add(self, begin, table)
    if begin == 64:
        os.kill(os.getpid(), signal.SIGKILL)
kept_parts.KeptParts.add = add_and_die
main()
"""


@pytest.mark.thorough
def test_a_process_that_is_killed_leaves_what_it_has_done(batch, queries, bodies, tmp_path):
    path, out = queries(shifts(200), ".parquet"), tmp_path / "answers.parquet"
    arguments = ["batch", path, "--bodies", bodies, "--out", out, "--workers", "1"]
    process = subprocess.run([sys.executable, "-c", KILLED, *map(str, arguments)], timeout=60)
    assert process.returncode == -signal.SIGKILL and not out.exists()
    assert len(list((tmp_path / "answers.parquet.parts").glob("rows-*"))) == 2
    _, whole = batch(path, out="whole.parquet")
    assert batch(path, out="answers.parquet")[1] == whole


# -- on the way -------------------------------------------------------------------------------------------------------


def test_progress_tells_rows_rate_and_the_time_left(batch, queries, monkeypatch):
    from firstcontact.cli import progress

    told = []
    rows = progress.RowsProgress.rows

    def tell(self, done, total):
        rows(self, done, total)
        told.append(self._line())

    monkeypatch.setattr(progress.RowsProgress, "rows", tell)
    monkeypatch.setattr(files, "FIRST_ROWS", 10)
    path = queries(shifts(20))
    batch(path, "--progress")
    assert told[0].startswith(f"{path}: 0 of 20; ")
    assert f"{path}: 10 of 20, " in told[1] and " a second; 0 s, about " in told[1] and told[1].endswith(" left")
    assert f"{path}: 20 of 20, " in told[-1] and "left" not in told[-1]


@pytest.mark.thorough
def test_answers_do_not_tell_where_parts_end(batch, queries, monkeypatch):
    """Not even by their work: in parts that are small boxes did not seem worth it."""
    pairs = [("cube", "train"), ("tetra", "wall"), ("train", "wall"), ("cube", "tetra")]
    rows = [{"a": a, "b": b, "span": [0, 1] if k == 5 else None} for k, (a, b) in enumerate(pairs * 5)]
    path = queries(rows)
    _, whole = batch(path, out="whole.jsonl")
    assert {row["work"] == 0 for row in whole} == {True, False}
    for size in (1, 3, 20):
        monkeypatch.setattr(files, "FIRST_ROWS", size)
        monkeypatch.setattr(files, "MOST_ROWS", size)
        assert batch(path)[1] == whole


def test_parquet_row_groups_are_not_those_of_the_parts(batch, queries, tmp_path, small_parts):
    batch(queries(shifts(20)), out="answers.parquet")
    assert pq.ParquetFile(tmp_path / "answers.parquet").num_row_groups == 1


def test_two_kinds_of_workers_are_refused(batch, queries):
    outcome, _ = batch(queries([GOOD]), "--scheduler", "tcp://127.0.0.1:1")
    assert outcome.code == 3 and "--workers and --scheduler" in outcome.err


def test_what_is_missing_is_named(batch, queries, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    outcome, _ = batch(queries([GOOD]))
    assert outcome.code == 3 and "pip install 'firstcontact[batch]'" in outcome.err
