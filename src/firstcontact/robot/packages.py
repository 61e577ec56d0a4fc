"""Where the files are that a robot's description names: `package://NAME/...`, `file://...` or a path beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from firstcontact.errors import InputError

PACKAGE = "package://"


def found(name: str, description: Path, packages: Mapping[str, str | Path]) -> Path:
    """The file that the description names.

    A package is where `packages` says; else the nearest folder of its name above the description, or beside such a one.
    """
    if not name.startswith(PACKAGE):
        path = Path(name.removeprefix("file://"))
        return path if path.is_absolute() else description.parent / path
    package, _, rest = name.removeprefix(PACKAGE).partition("/")
    if package in packages:
        return Path(packages[package]) / rest
    for folder in description.resolve().parents:
        for root in (folder, folder / package):
            if root.name == package and (root / rest).exists():
                return root / rest
    raise InputError(f"{description}: {name}: no folder {package!r} that has it is near; say where: {package}=FOLDER")
