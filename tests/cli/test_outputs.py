"""Where answers go: every command, each of its outputs, by the same rules."""

import io
import json
import os
import shutil
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest

import firstcontact
from firstcontact.cli import outputs, run

SOURCE = Path(firstcontact.__file__).parents[1]
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
QUERIES = "".join(json.dumps({"a": "lid", "b": "box", "vx": x, "vy": 0, "vz": 0}) + "\n" for x in (0, 100))
OUTPUTS = {
    "check": (["check", "cubes.toml"], "jsonl csv json html"),
    "intervals": (["intervals", "cubes.toml"], "jsonl csv json html"),
    "check of meshes": (["check", "lid.stl", "box.stl", "--move", "0 0 -80"], "jsonl csv json html"),
    "curve": (["curve", "cone.toml", "--tolerance", "1/10"], "json html"),
    "sweep": (["sweep", "door.toml", "--joint", "slide"], "json html"),
    "toolpath": (["toolpath", "pocket.nc", "--scene", "setup.toml"], "jsonl csv"),
    "robot": (["robot", "lamp.urdf", "--trajectory", "lamp.csv", "--scene", "desk.toml"], "jsonl csv json"),
}
READ = {
    "check": ["cubes.toml"],
    "intervals": ["cubes.toml"],
    "check of meshes": ["lid.stl", "box.stl"],
    "curve": ["cone.toml"],
    "toolpath": ["pocket.nc", "setup.toml"],
    "robot": ["lamp.urdf", "lamp.csv", "desk.toml"],
}
"""What each command reads of the command line alone; what scenes name: below."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The examples, where commands are run."""
    for path in EXAMPLES.iterdir():
        shutil.copy(path, tmp_path)
    (tmp_path / "queries.jsonl").write_text(QUERIES)
    monkeypatch.chdir(tmp_path)
    return tmp_path


EXTRAS = {"robot": "yourdfpy", "a part": "OCP", "a scene's course in a batch": "pyarrow"}


def need_extra_of(name):
    if name in EXTRAS:
        pytest.importorskip(EXTRAS[name])


def run_without_a_reader(arguments):
    """The exit code where standard output is a pipe whose reader has left, as `head` does."""
    read, write = os.pipe()
    os.close(read)
    with open(write, "w") as out, redirect_stdout(out):
        return run(arguments)


def targets(kinds):
    return [x for kind in kinds.split() for x in (f"--{kind}", f"whole.{kind}")]


@pytest.mark.share(3)
@pytest.mark.parametrize("name", OUTPUTS)
def test_files_are_whole_though_the_reader_left(folder, name):
    need_extra_of(name)
    arguments, kinds = OUTPUTS[name]
    assert run_without_a_reader([*arguments, *targets(kinds)]) == 141
    for kind in kinds.split():
        text = (folder / f"whole.{kind}").read_text()
        if kind == "json":
            document = json.loads(text)
            assert document.get("checks") or document["sweeps"]
        assert text.endswith("\n") if kind != "html" else text.rstrip().endswith("</html>")
    if "csv" in kinds and name != "toolpath":  # of which one block makes several rows
        rows = (folder / "whole.jsonl").read_text().count("\n")
        assert rows > 0 and (folder / "whole.csv").read_text().count("\n") >= rows


def test_rows_that_are_printed_cost_no_file_when_the_reader_leaves(folder):
    assert run_without_a_reader(["check", "cubes.toml", "--jsonl", "-", "--csv", "whole.csv"]) == 141
    assert (folder / "whole.csv").read_text().count("\n") > 1


def test_a_full_disk_for_the_text_is_told_after_the_files_are_whole(folder, capsys):
    with open("/dev/full", "w") as out, redirect_stdout(out):
        assert run(["check", "cubes.toml", "--json", "whole.json"]) == 3
    assert json.loads((folder / "whole.json").read_text())["checks"]
    assert capsys.readouterr().err == "firstcontact: standard output: no space left on device; give it another place\n"


@pytest.mark.share(2)
@pytest.mark.parametrize("name", OUTPUTS)
def test_a_full_disk_is_told_of_the_option_and_the_file(folder, capsys, name):
    need_extra_of(name)
    arguments, kinds = OUTPUTS[name]
    for kind in kinds.split() if name == "check" else kinds.split()[:1]:
        assert run([*arguments, f"--{kind}", "/dev/full"]) == 3
        err = capsys.readouterr().err
        assert err.count("\n") == 1 and f"firstcontact: --{kind} /dev/full: no space left on device; " in err


@pytest.mark.parametrize("name", OUTPUTS)
def test_two_options_on_one_file_are_refused(folder, capsys, name):
    arguments, kinds = OUTPUTS[name]
    first, second, *_ = kinds.split()
    assert run([*arguments, f"--{first}", "same", f"--{second}", "./same"]) == 3
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and "give each a file of its own" in err
    assert not Path("same").exists() and f"--{first} and --{second}" in err or f"--{second} and --{first}" in err


def test_an_output_that_is_a_link_to_another_is_refused_and_no_place_may_be_named_twice(folder, capsys):
    Path("a.csv").touch()
    os.symlink("a.csv", "b.csv")
    assert run(["check", "cubes.toml", "--csv", "a.csv", "--jsonl", "b.csv"]) == 3
    assert "give each a file of its own" in capsys.readouterr().err
    assert run(["check", "cubes.toml", "--csv", os.devnull, "--jsonl", os.devnull]) == 1


@pytest.mark.parametrize("name", READ)
def test_what_is_read_is_not_written_over(folder, capsys, name):
    arguments, kinds = OUTPUTS[name]
    kind = kinds.split()[0]
    for file in READ[name]:
        assert run([*arguments, f"--{kind}", f"./{file}"]) == 3
        out, err = capsys.readouterr()
        assert out == "" and err == f"firstcontact: --{kind} {file}: is read for this answer; choose another file\n"
        assert Path(file).read_bytes() == (EXAMPLES / file).read_bytes()


NAMED = {
    "a mesh": (["check", "lid.toml", "--json", "lid.stl"], "lid.stl"),
    "a part": (["intervals", "hinge.toml", "--csv", "door.stp"], "door.stp"),
    "a scene that is swept": (["sweep", "door.toml", "--json", "door.toml"], "door.toml"),
    "a scene's course in a batch": (["batch", "queries.jsonl", "--bodies", "x.toml", "--out", "q.csv"], "q.csv"),
    "what a tool path keeps": (["toolpath", "pocket.nc", "--scene", "setup.toml", "--resume", "pocket.nc"],
                               "pocket.nc"),
}  # fmt: skip


@pytest.mark.share(2)
@pytest.mark.parametrize("name", NAMED)
def test_what_a_scene_names_is_not_written_over(folder, capsys, name):
    need_extra_of(name)
    arguments, file = NAMED[name]
    if name == "a scene's course in a batch":
        door = Path("door.toml").read_text()
        Path("x.toml").write_text(door.partition("[course]")[0] + '[course]\nfile = "q.csv"\n')
        Path("q.csv").write_text("time,hinge,slide\n0,0,0\n1,1,1\n")
    before = Path(file).read_bytes()
    assert run(arguments) == 3
    assert "is read for this answer; choose another file" in capsys.readouterr().err
    assert Path(file).read_bytes() == before


def test_a_robot_s_mesh_is_not_written_over(folder, capsys):
    need_extra_of("robot")
    mesh = '<link name="a"><collision><geometry><mesh filename="lid.stl"/></geometry></collision></link>'
    Path("r.urdf").write_text(f'<robot name="r">{mesh}</robot>')
    Path("t.csv").write_text("time\n0\n1\n")
    assert run(["robot", "r.urdf", "--trajectory", "t.csv", "--csv", "lid.stl"]) == 3
    assert "--csv lid.stl: is read for this answer" in capsys.readouterr().err


def test_pages_and_pictures_are_not_printed(folder, capsys):
    for option in ("--html", "--png"):
        assert run(["check", "cubes.toml", option, "-"]) == 3
        assert f"{option} -: is not for standard output; name a file." in capsys.readouterr().err
    assert not Path("-").exists()


class Short(io.RawIOBase):
    """Takes a few letters at a time, as a pipe whose reader is slow."""

    def __init__(self):
        self.taken = b""

    def writable(self):
        return True

    def write(self, data):
        self.taken += bytes(data[:100])
        return min(len(data), 100)


def test_unbuffered_output_is_written_whole(folder, monkeypatch):
    """With PYTHONUNBUFFERED a text goes to the system at once, and what it did not take was lost."""
    slow = Short()
    unbuffered = io.TextIOWrapper(slow, write_through=True)
    monkeypatch.setattr(sys, "stdout", unbuffered)
    outputs.write_whole()
    assert run(["check", "cubes.toml", "--json", "-"]) == 1
    assert json.loads(slow.taken)["checks"]


def test_errors_that_cannot_be_told_leave_the_exit_code(folder):
    """The line that Python would still write as it ends, and then end with 120, is gone, too."""
    script = "$FC check none.toml 2>/dev/full"
    called = script.replace("$FC", f"{sys.executable} -m firstcontact")
    assert subprocess.run(["sh", "-c", called], env={**os.environ, "PYTHONPATH": str(SOURCE)}).returncode == 3
