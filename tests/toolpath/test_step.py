"""A tool against an exact part of a STEP file: its cylinder and its planes, by closed formulas."""

import csv
from pathlib import Path

import pytest

from firstcontact.cli import run

pytest.importorskip("OCP")
FRAME = Path(__file__).resolve().parents[2] / "examples" / "frame.stp"
"""A block with x in [-43, -13], y in [8, 68] and z in [-2, 82], and a pin of radius 1.9 about the axis z."""
SCENE = f"""
[tool.mill]
segments = [
    {{ name = "flutes", kind = "cutter", diameter = 6, length = 20 }},
    {{ name = "collet", kind = "holder", diameter = [10, 30], length = 30 }},
]
[body.frame]
shape = "step"
file = "{FRAME.as_posix()}"
"""


def test_a_pin_and_a_block_of_a_step_file(tmp_path, capsys):
    (tmp_path / "setup.toml").write_text(SCENE, encoding="utf-8")
    program = "G0 X40 Y0 Z70\nG1 X-60\nG0 Z100\nX0 Y30\nZ75\nG1 X-20\n"
    (tmp_path / "job.nc").write_text(program, encoding="utf-8")
    rows = tmp_path / "out.csv"
    code = run(["toolpath", str(tmp_path / "job.nc"), "--scene", str(tmp_path / "setup.toml"), "--csv", str(rows)])
    with rows.open(encoding="utf-8", newline="") as file:
        met = [row for row in csv.DictReader(file) if row["part"]]
    assert code == 1, capsys.readouterr()
    first = {(row["line"], row["part"]): float(row["fraction"]) for row in met}
    assert first["2", "flutes"] == pytest.approx((40 - 3 - 1.9) / 100, abs=1e-12)  # the pin, across its axis
    # the collet from z = 90 on: above the pin and the block, which end at 82
    assert ("2", "collet") not in first
    assert first["6", "flutes"] == pytest.approx((13 - 3) / 20, abs=1e-12)  # the block's side
    assert {line for line, _ in first} == {"2", "6"}
