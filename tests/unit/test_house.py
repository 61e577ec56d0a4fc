"""What the house is like to live in stays as it was found good: counts over the sources (`benchmarks/house.py`)."""

import sys
from pathlib import Path

import firstcontact

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
import house  # noqa: E402

PACKAGE = Path(firstcontact.__file__).parent
FILES = 22
"""In one folder."""
ALIKE = {"Quadric", "Face", "Torus", "Subproblem", "_Room"}
"""Classes of one name that mean the same: a scene's table and the body it makes, faces of bodies, ..."""


def test_no_folder_is_a_heap():
    counted = {str(x.relative_to(PACKAGE)): len(list(x.glob("*.py"))) for x in [PACKAGE, *PACKAGE.rglob("*/")]}
    assert {name: n for name, n in counted.items() if n > FILES} == {}


def test_signatures_definitions_and_names():
    counted = house.counts()
    assert counted["signatures with Any"] < 200
    assert counted["files that catch UnsupportedPair"] <= 2
    assert counted["isinstance on motions"] <= 100
    assert counted["isinstance on bodies"] <= 61
    assert counted["foreign private reads"] <= 125
    assert counted["functions over 60 lines"] <= 14
    assert all(counted[f"definitions of {verb}"] <= 2 for verb in house.VERBS)
    assert counted["class names used twice"] <= len(ALIKE)
    assert house.names_used_twice() <= ALIKE
