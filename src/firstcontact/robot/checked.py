"""What a robot's description says, before it is read: each shape and joint with the numbers that it needs."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element

from firstcontact.errors import InputError

SHAPES = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "capsule": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
    "mesh": {},
}
"""The shapes, and how many numbers each of their attributes has."""


def check(path: Path, robot: Element) -> None:
    """InputError that names the link or joint of the first thing that cannot be read."""
    if robot.tag != "robot" or not robot.get("name"):
        raise InputError(f"{path}: its first element is <{robot.tag}>, not <robot name=...>; give URDF")
    _check_names(path, robot)
    for link in robot.findall("link"):
        who = f"{path}: link {_named(path, link, 'link')!r}"
        for k, collision in enumerate(link.findall("collision")):
            _check_origin(collision, f"{who}: collision {k}")
            geometries = collision.findall("geometry")
            if len(geometries) != 1:
                raise InputError(f"{who}: collision {k} has {len(geometries)} geometries; give it one")
            _check_shape(geometries[0], f"{who}: collision {k}")
    for joint in robot.findall("joint"):
        who = f"{path}: joint {_named(path, joint, 'joint')!r}"
        for end in ("parent", "child"):
            if (element := joint.find(end)) is None or not element.get("link"):
                raise InputError(f"{who} has no {end}; give it <{end} link=...>")
        _check_origin(joint, who)
        for tag, keys in {"limit": ("lower", "upper"), "mimic": ("multiplier", "offset")}.items():
            for element in joint.findall(tag):
                for key in keys:
                    if element.get(key) is not None:
                        _numbers(element, key, 1, who)
        axis = None if joint.get("type") in ("fixed", "floating") else joint.find("axis")
        if axis is not None and not any(_numbers(axis, "xyz", 3, who)):
            raise InputError(f"{who}: its axis is 0 0 0; give a direction")


def _check_names(path: Path, robot: Element) -> None:
    for what in ("link", "joint"):
        names = [_named(path, element, what) for element in robot.findall(what)]
        for k, name in enumerate(names):
            if name in names[:k]:
                raise InputError(f"{path}: two {what}s are called {name!r}; give each its own name")


def _named(path: Path, element: Element, what: str) -> str:
    name = element.get("name")
    if not name:
        raise InputError(f"{path}: a {what} has no name; give each its own")
    return name


def _check_origin(element: Element, who: str) -> None:
    origin = element.find("origin")
    for key in ("xyz", "rpy"):
        if origin is not None and origin.get(key) is not None:
            _numbers(origin, key, 3, who)


def _check_shape(geometry: Element, who: str) -> None:
    if len(geometry) > 1:
        raise InputError(f"{who} has {len(geometry)} shapes in one geometry; give each a collision of its own")
    if not len(geometry):
        raise InputError(f"{who} has no shape; give one of {', '.join(SHAPES)}")
    (shape,) = geometry
    if shape.tag not in SHAPES:
        raise InputError(f"{who} is a {shape.tag}; give one of {', '.join(SHAPES)}")
    for key, count in SHAPES[shape.tag].items():
        if not all(x > 0.0 for x in _numbers(shape, key, count, who)):
            raise InputError(f"{who}: the {key} of its {shape.tag} is {shape.get(key)!r}; give lengths above 0")
    if shape.tag == "mesh":
        if not shape.get("filename"):
            raise InputError(f"{who}: its mesh has no filename")
        if shape.get("scale") is not None and not all(_numbers(shape, "scale", 3, who)):
            raise InputError(f"{who}: the scale of its mesh is {shape.get('scale')!r}; give numbers other than 0")


def _numbers(element: Element, key: str, count: int, who: str) -> list[float]:
    """The numbers of an attribute."""
    given = element.get(key)
    try:
        numbers = [float(x) for x in (given or "").split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        many = "one finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"{who}: {key} of its {element.tag} is {given!r}; give {many}")
    return numbers
