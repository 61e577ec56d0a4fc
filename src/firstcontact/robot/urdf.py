"""A robot's description: links with their shapes, joints, all placed in the world in which all joint values are 0."""

from __future__ import annotations

import io
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.body.solid import primitives
from firstcontact.errors import InputError
from firstcontact.interrupts import interrupted_after
from firstcontact.io.meshes import FORMATS
from firstcontact.mechanism.joints import Joint
from firstcontact.motion.poses import Pose, read_poses
from firstcontact.robot import srdf as semantic
from firstcontact.robot.checked import check
from firstcontact.robot.packages import found

if TYPE_CHECKING:
    import yourdfpy

    from firstcontact.body.solid.composite_quadric import CompositeQuadric

NEEDED = {"link": {"collision"}, "joint": {"origin", "parent", "child", "axis", "limit", "mimic"}}
"""What is read of links and joints."""

Capsules = set[tuple[str, int]]
"""The names of links and the numbers of their shapes."""

KINDS = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}


@dataclass(frozen=True)
class Description:
    """What a robot is made of: the bodies of each link, the joints; files: of its meshes."""

    name: str
    links: dict[str, list[Any]]
    joints: list[Joint]
    files: list[Path]


def read(path: Path, packages: Mapping[str, str | Path], base: np.ndarray) -> Description:
    """The robot of a URDF file, its root placed by `base` (4, 4).

    Poses are products of doubles, and each stands for the nearest rotation: within a few 1e-16 of what the file says.
    Vertices of meshes are placed in doubles too.
    """
    (robot, capsules), meshes = _parsed(path), dict[Path, Polyhedron]()
    homes = _homes(path, robot, base)
    links = {
        link.name: [
            _body(path, packages, meshes, capsules, link.name, k, shape, homes[link.name] @ _matrix(shape.origin))
            for k, shape in enumerate(link.collisions or [])
        ]
        for link in robot.links
    }
    joints = [_joint(path, joint, homes[joint.child]) for joint in robot.joints]
    return Description(robot.name, links, joints, list(meshes))


def _parsed(path: Path) -> tuple[yourdfpy.urdf.Robot, Capsules]:
    """What the parser makes of links and joints, and which cylinders are capsules."""
    try:
        with interrupted_after():
            import yourdfpy
    except ImportError as error:
        raise InputError("robots need yourdfpy; install it: python -m pip install 'firstcontact[robot]'") from error
    root = semantic.tree(path)
    check(path, root)  # the parser leaves out what it does not understand, and raises what it meets
    capsules = _bare(root)
    logging.getLogger("yourdfpy").setLevel(logging.ERROR)  # it warns of meshes that are not asked for
    file = io.BytesIO(ElementTree.tostring(root))
    try:
        return yourdfpy.URDF.load(file, load_meshes=False, build_scene_graph=False).robot, capsules
    except Exception as error:  # its parser raises what it meets
        raise InputError(f"{path}: no description of a robot ({type(error).__name__}: {error}); give URDF") from error


def _bare(root: ElementTree.Element) -> Capsules:
    """Leaves links and joints with what counts here, and cylinders for capsules, which the parser does not know."""
    capsules = set()
    for element in list(root):
        if element.tag not in NEEDED:
            root.remove(element)
        for part in list(element):
            if part.tag not in NEEDED.get(element.tag, ()):
                element.remove(part)
    for link in root.findall("link"):
        for k, collision in enumerate(link.findall("collision")):
            for shape in collision.findall("geometry/capsule"):
                shape.tag = "cylinder"
                capsules.add((link.get("name", ""), k))
    return capsules


def _matrix(origin: np.ndarray | None) -> np.ndarray:
    return np.eye(4) if origin is None else np.asarray(origin, float)


def _homes(path: Path, robot: yourdfpy.urdf.Robot, base: np.ndarray) -> dict[str, np.ndarray]:
    """The (4, 4) pose of each link."""
    above = {joint.child: joint for joint in robot.joints}
    homes: dict[str, np.ndarray] = {}

    def home(link: str, below: tuple[str, ...] = ()) -> np.ndarray:
        if link in below:
            raise InputError(f"{path}: link {link!r} hangs on itself; give a tree")
        if link not in homes:
            joint = above.get(link)
            homes[link] = base if joint is None else home(joint.parent, (*below, link)) @ _matrix(joint.origin)
        return homes[link]

    for link in robot.links:
        home(link.name)
    for joint in robot.joints:
        for name in (joint.parent, joint.child):
            if name not in homes:
                raise InputError(f"{path}: joint {joint.name!r} names the link {name!r}, which is not there")
    return homes


def _joint(path: Path, joint: yourdfpy.urdf.Joint, home: np.ndarray) -> Joint:
    if joint.type not in KINDS:
        raise InputError(f"{path}: joint {joint.name!r} is {joint.type!r}; {', '.join(KINDS)} are followed")
    kind = KINDS[joint.type]
    if kind == "fixed":
        return Joint(joint.name, kind, joint.parent, joint.child)
    axis = home[:3, :3] @ (np.array([1.0, 0.0, 0.0]) if joint.axis is None else np.asarray(joint.axis, float))
    limits = None
    if joint.limit is not None and joint.type != "continuous":
        lower, upper = joint.limit.lower or 0.0, joint.limit.upper or 0.0
        limits = (lower, upper) if lower < upper else None
    mimic = None
    if joint.mimic is not None:
        ratio, offset = joint.mimic.multiplier, joint.mimic.offset
        mimic = joint.mimic.joint, 1.0 if ratio is None else ratio, 0.0 if offset is None else offset
    unit = "rad" if kind == "revolute" else None
    return Joint(
        joint.name, kind, joint.parent, joint.child, axis=axis.tolist(), point=home[:3, 3].tolist(), unit=unit,
        limits=limits, mimic=mimic,
    )  # fmt: skip


def _body(
    path: Path, packages: Mapping[str, str | Path], meshes: dict[Path, Polyhedron], capsules: Capsules, link: str,
    k: int, shape: yourdfpy.urdf.Collision, place: np.ndarray,
) -> Polyhedron | CompositeQuadric:  # fmt: skip
    """A shape of a link, by the link's name and, beyond the first, a number; meshes: what was read of files so far."""
    name = link if k == 0 else f"{link}.{k}"
    geometry = shape.geometry
    if geometry.mesh is not None:
        file = found(geometry.mesh.filename, path, packages)
        if not file.is_file():
            raise InputError(f"{path}: link {link!r}: its mesh {file} is not there")
        mesh = meshes[file] = meshes.get(file) or _mesh(file)
        scale = np.ones(3) if geometry.mesh.scale is None else np.asarray(geometry.mesh.scale, float)
        vertices = (mesh.vertices * scale) @ place[:3, :3].T + place[:3, 3]
        triangles = mesh.triangles if np.prod(scale) > 0 else mesh.triangles[:, ::-1]
        return Polyhedron(vertices, triangles, solid=mesh.solid, name=name)
    if geometry.box is not None:
        solid = primitives.box(np.asarray(geometry.box.size).tolist())
    elif geometry.cylinder is not None:
        solid = primitives.cylinder(geometry.cylinder.radius, geometry.cylinder.length)
        if (link, k) in capsules:
            ball = primitives.sphere(geometry.cylinder.radius)
            ends = [ball.translated((0, 0, x)) for x in (-geometry.cylinder.length / 2, geometry.cylinder.length / 2)]
            solid = solid | ends[0] | ends[1]
    else:  # `check` has let no other shape pass
        solid = primitives.sphere(geometry.sphere.radius)
    pose: Pose = read_poses([place], [f"{path}: the place of link {link!r}"])[0]
    return solid.transformed([*pose.matrix(), (0, 0, 0, 1)]).named(name)


def _mesh(file: Path) -> Polyhedron:
    if file.suffix.lower() in FORMATS:
        return Polyhedron.load(file)
    with interrupted_after():
        import trimesh

    try:
        mesh = trimesh.load(file, force="mesh")
    except Exception as error:  # readers of trimesh raise what they meet, and need packages of their own
        raise InputError(f"{file}: cannot be read ({error}); give one of {', '.join(FORMATS)}") from error
    return Polyhedron.from_trimesh(mesh, name=file.stem)
