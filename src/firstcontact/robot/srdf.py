"""Pairs of links that a robot's semantic description switches off."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from firstcontact.errors import InputError


def disabled(path: Path) -> list[tuple[str, str]]:
    """The pairs of links of all `disable_collisions`."""
    root = tree(path)
    if root.find("joint/parent") is not None:
        raise InputError(f"{path}: describes links and joints, as URDF does; give the SRDF file of disabled pairs")
    pairs = [(x.get("link1"), x.get("link2")) for x in root.iter("disable_collisions")]
    return [(a, b) for a, b in pairs if a is not None and b is not None]


def tree(path: Path) -> ElementTree.Element:
    """The root of a file of XML."""
    try:
        return ElementTree.parse(path).getroot()
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}; give a robot's description") from error
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: no XML ({error}); give a robot's description") from error
