"""Two cubes in a scene file, and the command line run in this process."""

import os
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import pytest

import firstcontact
from firstcontact.cli import run

SOURCE = Path(firstcontact.__file__).parents[1]

Outcome = namedtuple("Outcome", "code out err")

CUBE = """
shape = "polyhedron"
vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
"""
SLIDE = '[body.left.motion]\ntype = "translation"\nvector = ["3/10", 0, 0]\n'


@pytest.fixture
def command(capfd):
    """Run the command line: command("check", path) -> (code, out, err)."""

    def call(*arguments):
        code = run([str(argument) for argument in arguments])
        captured = capfd.readouterr()
        return Outcome(code, captured.out, captured.err)

    return call


@pytest.fixture
def python():
    """Run a script in a new interpreter: python("print(1)", "argument") -> the completed process."""

    def call(script, *arguments):
        environment = {**os.environ, "PYTHONPATH": str(SOURCE)}
        command = [sys.executable, "-c", script, *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, env=environment)

    return call


@pytest.fixture
def cubes(scene):
    """A scene: the left cube slides by 3/10 towards the right one, whose left face lies at x = `face`.

    They meet at time (face - 1) / (3/10), a corner of each over a face of the other.
    """

    def write(face, more=""):
        place = f'at = ["{face}", "-1/3", "1/4"]\n'
        return scene(f"[body.left]{CUBE}{SLIDE}[body.right]{CUBE}{place}{more}")

    return write
