"""What is to be looked at: a scene file, or mesh and STEP files and a motion of the first one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from firstcontact.errors import InputError

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.body.compound.compound import Compound
    from firstcontact.body.polyhedron.polyhedron import Polyhedron
    from firstcontact.motion.rotation import Rotation
    from firstcontact.motion.translation import Translation
    from firstcontact.scene.load import Scene


STEP = (".stp", ".step", ".p21")


def is_step(file: str) -> bool:
    """By its name."""
    return Path(file).suffix.lower() in STEP


def given_scene(
    files: tuple[str, ...], move: str | None, turn: str | None, about: str | None, degrees: str | None, triangles: bool
) -> Scene:
    """The scene; of mesh and STEP files the first one moves, by what the options say."""
    from firstcontact.io.meshes import FORMATS
    from firstcontact.scene.load import load_scene

    asked = [x for x in (move, turn, about, degrees) if x is not None]
    if triangles and not any(is_step(file) for file in files):
        raise click.UsageError("--triangles is for STEP files: a scene says it by surfaces = false.")
    if len(files) == 1:
        if is_step(files[0]):
            raise click.UsageError(f"{files[0]}: is one STEP file: name another one, too, or a scene.")
        if asked:
            raise click.UsageError("--move and --turn are for mesh and STEP files: a scene says how its bodies move.")
        if Path(files[0]).suffix.lower() in FORMATS:
            raise click.UsageError(f"{files[0]}: is one mesh: name another one, too, or a scene.")
        return load_scene(files[0])
    if any(Path(file).suffix.lower() == ".toml" for file in files):
        raise click.UsageError(f"{' '.join(files[1:])} is one too many: give one scene, or two or more other files.")
    return _of_files(files, _motion(move, turn, about, degrees), triangles)


def _motion(
    move: str | None, turn: str | None, about: str | None, degrees: str | None
) -> Translation | Rotation | None:
    """None where none is given."""
    from firstcontact.motion.rotation import Rotation
    from firstcontact.motion.translation import Translation

    if move is not None and (turn, about, degrees) != (None, None, None):
        raise click.UsageError("--move and --turn: choose one.")
    if move is not None:
        return Translation(_numbers("--move", move, 3))
    if turn is None:
        if about is not None or degrees is not None:
            raise click.UsageError('--about and --degrees go with --turn "AXIS".')
        return None
    if degrees is None:
        raise click.UsageError("--turn: say how far by --degrees D.")
    point = (0, 0, 0) if about is None else _numbers("--about", about, 3)
    return Rotation(_numbers("--turn", turn, 3), point, degrees=_numbers("--degrees", degrees, 1)[0])


def _numbers(option: str, text: str, count: int) -> list[float | int | Fraction]:
    from firstcontact.scene.values import parse_number

    parts = text.replace(",", " ").split()
    try:
        numbers = [parse_number(x) for x in parts]
    except ValueError as error:
        raise InputError(f"{option}: {error}") from error
    if len(numbers) != count:
        wanted = 'one number' if count == 1 else 'three numbers, as in "0 0 -10"'
        raise InputError(f"{option} {text!r}: give {wanted}")
    return numbers


def _body(file: str, key: str, triangles: bool) -> Polyhedron | Compound:
    if is_step(file):
        from firstcontact.step.assembly import load_step

        return load_step(file, surfaces=False if triangles else None).named(key)
    from firstcontact.body.polyhedron.polyhedron import Polyhedron

    return Polyhedron.load(file, name=key)


def _of_files(files: tuple[str, ...], motion: Translation | Rotation | None, triangles: bool) -> Scene:
    from firstcontact.scene.load import Check, Scene

    bodies: dict[str, Any] = {}
    for file in files:
        key, k = Path(file).stem, 2
        while key in bodies:
            key, k = f"{Path(file).stem}-{k}", k + 1
        bodies[key] = _body(file, key, triangles)
    first, *others = bodies
    if motion is not None:
        bodies[first] = bodies[first].moving(motion)
    checks = tuple(Check(first, other) for other in others)
    return Scene(Path(files[0]), bodies, checks, files=tuple(map(Path, files)))
