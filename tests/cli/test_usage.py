"""Usage and errors of the whole command: one line, exit code 3; help without heavy imports."""

import pytest

import firstcontact as fc

HEAVY = ("numba", "numpy", "flint", "pydantic", "rich", "trimesh")
MAIN = "from firstcontact.cli import main; main()"
MODULE = "import runpy; runpy.run_module('firstcontact', run_name='__main__')"


def test_the_command_is_importable_without_heavy_modules(python):
    code = f"import sys, firstcontact.cli; print([m for m in {HEAVY!r} if m in sys.modules])"
    assert python(code).stdout == "[]\n"


def test_help_and_version(command):
    for subcommand in ([], ["check"], ["intervals"], ["curve"], ["info"], ["warmup"]):
        code, out, err = command(*subcommand, "--help")
        assert code == 0 and out.startswith("Usage: firstcontact") and err == ""
    assert command("--version").out == f"firstcontact, version {fc.__version__}\n"


@pytest.mark.share(2)
@pytest.mark.parametrize("main", [MAIN, MODULE], ids=["script", "python -m"])
def test_main_leaves_with_the_exit_code(python, tmp_path, main):
    done = python(main, "check", tmp_path / "none.toml")
    assert done.returncode == 3 and done.stdout == ""
    fault = "no such file or directory; give the path of a scene file (TOML)"
    assert done.stderr == f"firstcontact: {tmp_path / 'none.toml'}: {fault}\n"


def test_what_waits_for_the_end_of_the_process_is_done(python):
    """It leaves without taking itself apart: not before what was registered for the end, nor while a thread works."""
    done = python(f"import atexit; atexit.register(print, 'at the end', end=''); {MAIN}", "check", "none.toml")
    assert (done.returncode, done.stdout) == (3, "at the end")
    thread = "threading.Thread(target=lambda: [time.sleep(0.3), print('worked')]).start()"
    done = python(f"import threading, time; {thread}; {MAIN}", "--version")
    told = sorted(done.stdout.splitlines())  # a busy machine may take longer to begin than the thread sleeps
    assert (done.returncode, told) == (0, [f"firstcontact, version {fc.__version__}", "worked"])


@pytest.mark.share(3)
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_complete_commands_and_options(python, shell):
    assert "firstcontact" in python(completing(f"{shell}_source")).stdout
    if shell == "bash":
        asked = {"firstcontact war": "plain,warmup\n", "firstcontact check --htm": "plain,--html\n"}
        for words, told in asked.items():
            done = python(completing("bash_complete", COMP_WORDS=words, COMP_CWORD=str(words.count(" "))))
            assert (done.returncode, done.stdout) == (0, told)


def completing(instruction, **environment):
    """What the shell runs."""
    environment["_FIRSTCONTACT_COMPLETE"] = instruction
    return f"import os, sys; os.environ.update({environment!r}); sys.argv[:] = ['firstcontact']; {MAIN}"


BAD_USAGE = {
    "unknown command": (["chek"], "No such command 'chek'"),
    "unknown option": (["check", "SCENE", "--jsn"], "--jsn"),
    "no scene": (["check"], "SCENE"),
    "two scenes": (["check", "SCENE", "other.toml"], "other.toml"),
    "half a span": (["check", "SCENE", "--span", "0"], "--span"),
    "word in a span": (["check", "SCENE", "--span", "0", "soon"], "--span: 'soon' is not a number"),
    "nan in a span": (["check", "SCENE", "--span", "nan", "1"], "--span: 'nan' is not a number"),
    "json into nowhere": (["check", "SCENE", "--json", "/none/x.json"], "/none/x.json: cannot be written"),
    "html into nowhere": (["intervals", "SCENE", "--html", "/none/x.html"], "x.html: cannot be written"),
    "png into nowhere": (["check", "SCENE", "--png", "/none/x.png"], "/none/x.png: cannot be written"),
    "json into a folder": (["check", "SCENE", "--json", "/"], "cannot be written"),
    "a scene that is a folder": (["check", "/"], "/: is a directory"),
    "a mesh that is a scene": (["info", "scene.tml"], "unknown mesh format '.tml'"),
}


@pytest.mark.parametrize("case", BAD_USAGE)
def test_bad_usage_is_one_line_and_3(command, cubes, case):
    arguments, says = BAD_USAGE[case]
    scene = str(cubes("1.1"))
    code, out, err = command(*[scene if a == "SCENE" else a for a in arguments])
    assert code == 3 and out == ""
    assert err.count("\n") == 1 and err.startswith("firstcontact: ") and says in err


def test_no_command_shows_the_help_and_returns_3(command):
    code, out, err = command()
    assert code == 3 and "Commands:" in out and err.count("\n") == 1 and "warmup" in err


def test_a_scene_with_one_body_says_what_is_missing(command, scene):
    path = scene('[body.a]\nshape = "polyhedron"\nvertices = [[0, 0, 0]]\n')
    code, _, err = command("check", path)
    assert code == 3 and "add a second [body.NAME]" in err


@pytest.mark.thorough
def test_damaged_meshes_give_one_line_in_spite_of_reader_warnings(python, tmp_path):
    mesh = tmp_path / "damaged.glb"
    mesh.write_bytes(b"glTF" + bytes(40))
    done = python(MAIN, "info", mesh)
    assert done.returncode == 3 and done.stderr.count("\n") == 1 and str(mesh) in done.stderr


def test_a_reader_that_leaves_early_gets_neither_an_answer_nor_a_complaint(python, command, cubes):
    command("info", cubes("1.1"))  # compiled, so that nothing is said about that
    # The pipe's reading end is closed before anything is printed, as `head` does after its last line.
    closed = f"import os; read, write = os.pipe(); os.close(read); os.dup2(write, 1); {MAIN}"
    done = python(closed, "info", cubes("1.1"))
    assert done.returncode == 141 and done.stderr == ""


@pytest.mark.thorough
def test_a_scene_in_which_nothing_moves_warns(python, tmp_path):
    path = tmp_path / "still.toml"
    path.write_text(
        "[body.a]\nshape = 'sphere'\nradius = 1\n[body.b]\nshape = 'sphere'\nradius = 1\nat = [3, 0, 0]\n"
        "[[check]]\npair = ['a', 'b']\n"
    )
    done = python(MAIN, "check", path)
    assert done.returncode == 0 and "FREE" in done.stdout.upper()
    (warning,) = [line for line in done.stderr.splitlines() if "kernels" not in line]
    assert warning.startswith(f"firstcontact: {path}: nothing that is checked moves") and "motion]" in warning


@pytest.mark.thorough
def test_a_surface_that_deforms_is_not_said_to_rest(python, tmp_path):
    path = tmp_path / "deforming.toml"
    path.write_text(
        "[body.a]\nshape = 'ruled'\nfirst = '(u, 0, 2 - T)'\nsecond = '(u, 1, 2 - T)'\n"
        "[body.b]\nshape = 'ruled'\nfirst = '(u, 0, 0)'\nsecond = '(u, 1, 1/2)'\n"
        "[[check]]\npair = ['a', 'b']\nspan = [0, 2]\n"
    )
    done = python(MAIN, "check", path)
    assert done.returncode == 1 and "CONTACT at time 1.5" in done.stdout
    assert not [line for line in done.stderr.splitlines() if "kernels" not in line]
