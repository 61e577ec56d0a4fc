"""The mechanism of a robot's description."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.errors import InputError, shown
from firstcontact.mechanism.joints import Joint
from firstcontact.mechanism.mechanism import Mechanism
from firstcontact.robot import srdf as semantic
from firstcontact.robot import urdf

if TYPE_CHECKING:
    from firstcontact.exact.numbers import Nested


class Robot(Mechanism):
    """Links and joints of a URDF file; angles are in radians, lengths those of the file.

    Links that a joint connects, and all that is fixed to these, are not asked about with each other.
    """

    @classmethod
    def load(
        cls, path: str | Path, *, srdf: str | Path | None = None, packages: Mapping[str, str | Path] | None = None,
        base: Nested | None = None, skip: Iterable[Iterable[str]] = (),
    ) -> Robot:  # fmt: skip
        """The robot of a URDF file.

        srdf: a file whose disabled pairs are skipped, too.  packages: folders of `package://NAME/`, where they are not
        found above the file.  base: (4, 4) pose of the root.  skip: further pairs of links.
        """
        place = np.eye(4) if base is None else np.asarray(base, float)
        if place.shape != (4, 4):
            raise InputError(f"base has the shape {place.shape}; give a 4x4 pose")
        if not isinstance(path, str | Path):
            raise InputError(f"path is {shown(path)}; give that of a URDF file")
        read = urdf.read(Path(path), packages or {}, place)
        off = semantic.disabled(Path(srdf)) if srdf is not None else []  # such files may be about more links
        known = [pair for pair in off if len(set(pair)) == 2 and read.links.keys() >= set(pair)]
        pairs = [*skip, *known, *adjacent(read.joints)]
        robot = cls(read.links, read.joints, skip=pairs)
        robot.name = read.name
        robot.files = (Path(path), *read.files, *([] if srdf is None else [Path(srdf)]))
        return robot

    name: str = ""
    files: tuple[Path, ...] = ()
    """What was read: the description, its meshes, and the disabled pairs."""


def adjacent(joints: list[Joint]) -> list[tuple[str, str]]:
    """Pairs of links with one joint between them that is not fixed, and of all that is fixed to these."""
    group: dict[str, list[str]] = {}
    for joint in joints:
        for link in (joint.parent, joint.child):
            group.setdefault(link, [link])
    for joint in joints:
        if joint.kind == "fixed" and group[joint.parent] is not group[joint.child]:
            merged = group[joint.parent] + group[joint.child]
            group |= {link: merged for link in merged}
    return [(x, y) for joint in joints for x in group[joint.parent] for y in group[joint.child] if x != y]
