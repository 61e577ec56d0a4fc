"""Scenes of a STEP assembly, for `step.py`: all of as1 with its bolts drawn out, and 300 bodies."""

from __future__ import annotations

from pathlib import Path

import firstcontact as fc

LIFT = 40.0


def _body(name: str, file: Path, part: str, more: str = "") -> str:
    return f'[body."{name}"]\nshape = "step"\nfile = "{file}"\npart = "{part}"\n{more}\n'


def _motion(name: str, kind: str, keys: str) -> str:
    return f'[body."{name}".motion]\ntype = "{kind}"\n{keys}\n'


def assembly_scene(file: Path, folder: Path) -> Path:
    """Every part of as1: the three bolts of the first bracket go up, the rod turns about its axis."""
    root = fc.load_step(file)
    text = 'unit = "mm"\n[[allow]]\ntouching = true\nwhy = "put together"\n'
    for part in root.parts:
        name = part.path.removeprefix(root.path + "/").replace("/", ".")
        text += _body(name, file, part.path)
        if name.startswith("l-bracket-assembly_1.") and ".bolt" in name:
            text += _motion(name, "translation", f"vector = [0, 0, {LIFT}]")
        if name.endswith("rod_1"):
            lo, hi = part.body.bounds()
            y, z = (0.5 * (lo + hi))[1:].round(6).tolist()
            text += _motion(name, "rotation", f"axis = [1, 0, 0]\npoint = [0, {y}, {z}]\nturns = 1")
    target = folder / "as1.toml"
    target.write_text(text)
    return target


def many_bodies(file: Path, folder: Path, count: int = 300) -> Path:
    """Nuts in a grid; every tenth goes three places on."""
    text = "rest = true\n"
    for k in range(count):
        at = [25.0 * (k % 10), 25.0 * (k // 10 % 10), 25.0 * (k // 100)]
        text += _body(f"nut{k}", file, "nut_1", f"at = {at}")
        if k % 10 == 0:
            text += _motion(f"nut{k}", "translation", "vector = [75, 10, 5]")
    target = folder / "many.toml"
    target.write_text(text)
    return target
