"""The benchmark scenes: two closed meshes of about n triangles each, and one motion of the first.

``scenes(n)`` gives every scene as built, ``scenes(n, turned=True)`` the same ones, each with bodies and
motion turned by one random rotation (in floats).  The names in BARRED have a contact inside the span and a
bar in the results; of the others most are free, near misses or deep overlaps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from firstcontact import examples

FloatArray = NDArray[np.float64]
NEAR_MISS = 1e-6
"""Gap of a near miss; the bodies are about 1 wide."""
BARRED = (
    "translation spheres",
    "translation tori",
    "translation gears",
    "rotation lid",
    "rotation arm",
    "rotation arm past posts",
    "rotation gears",
)


@dataclass(frozen=True)
class Scene:
    """Bodies a (moving) and b (at rest) in the world frame at time 0; time runs over (0, 1).

    va, vb: (n, 3) float64; fa, fb: (m, 3) int32, closed, oriented outward.
    kind "translation": a moves by t * vector.  kind "rotation": a turns by t * radians about the line through
    ``point`` along the unit vector ``axis``, right-hand rule.
    expect: "contact" (in 0.05 < t < 0.95), "free", "near miss" (free), "overlap" (at once) or "unknown".
    """

    name: str
    va: FloatArray
    fa: NDArray[np.int32]
    vb: FloatArray
    fb: NDArray[np.int32]
    kind: str
    expect: str
    vector: FloatArray = field(default_factory=lambda: np.zeros(3))
    axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    point: FloatArray = field(default_factory=lambda: np.zeros(3))
    radians: float = 0.0

    def turned(self, rotation: FloatArray) -> Scene:
        """The whole scene under one rotation matrix (3, 3)."""
        arrays = ("va", "vb", "vector", "axis", "point")
        return replace(self, **{name: getattr(self, name) @ rotation.T for name in arrays})

    def pose(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Rotation matrix (3, 3) and shift (3,) that take a from time 0 to time t."""
        if self.kind == "translation":
            return np.eye(3), self.vector * t
        turn = _rotation_matrix(self.axis, self.radians * t)
        return turn, self.point - turn @ self.point

    def jittered(self, repeat: int) -> Scene:
        """The scene with its motion changed by 1e-3 of itself; the same ``repeat`` gives the same motion.

        A near miss keeps its direction, so that it stays one.
        """
        u = np.random.default_rng(1000 + repeat).uniform(-1e-3, 1e-3, 3)
        if self.kind == "rotation":
            return replace(self, radians=self.radians * (1.0 + u[0]))
        if self.expect == "near miss":
            return replace(self, vector=self.vector * (1.0 + u[0]))
        return replace(self, vector=self.vector + u * np.linalg.norm(self.vector))


def scenes(n: int, turned: bool = False) -> dict[str, Scene]:
    """Every scene of about n triangles a body, by name."""
    made = [make(n) for make in _MAKERS]
    if turned:
        made = [scene.turned(random_rotation(7 + k)) for k, scene in enumerate(made)]
    return {scene.name: scene for scene in made}


def random_rotation(seed: int) -> FloatArray:
    """A (3, 3) rotation matrix, uniformly distributed."""
    w, x, y, z = _unit(np.random.default_rng(seed).standard_normal(4))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


# -- translations -------------------------------------------------------------------------------------------


def translation_spheres(n: int) -> Scene:
    """Two noisy spheres, one moving obliquely into the other."""
    return _translation("translation spheres", *_spheres(n, (2.7, 0.5, 0.3)), (-1.8, 0.1, -0.25))


def translation_tori(n: int) -> Scene:
    """Two linked rings; one moves until the rings touch."""
    return _translation("translation tori", *_linked_tori(n), (0.75, 0.2, 0.3))


def translation_gears(n: int) -> Scene:
    """One gear moves sideways into mesh with the other, a little off the gap's middle, until flanks touch."""
    a, b = _gears(n, centre_distance=2.35)
    return _translation("translation gears", a, b, (-0.5, 0.04, 0.02))


def translation_gears_slivers(n: int) -> Scene:
    """The same with every triangle as long as the gear is wide."""
    a, b = _gears(n, centre_distance=2.35, slivers=True)
    return _translation("translation gears, slivers", a, b, (-0.5, 0.04, 0.02))


def translation_spheres_free(n: int) -> Scene:
    """One noisy sphere passes the other at a tenth of its radius."""
    return _translation(
        "translation spheres free", *_spheres(n, (2.5, 1.5, 1.5)), (-5.0, 0.05, 0.1), expect="free"
    )


def translation_tori_free(n: int) -> Scene:
    """Two linked rings; one moves inside the other without touching it."""
    return _translation("translation tori free", *_linked_tori(n), (0.2, 0.1, 0.1), expect="free")


def translation_spheres_near_miss(n: int) -> Scene:
    """The extreme vertex of one noisy sphere passes right over that of the other, at a gap of 1e-6."""
    (va, fa), (vb, fb) = _spheres(n, (0.0, 0.0, 0.0))
    across = _unit(np.array([0.3, -0.5, 0.8]))
    along = _unit(np.cross(across, [0.2, 0.7, 0.4])) * 3.0
    low, high = va[np.argmin(va @ across)], vb[np.argmax(vb @ across)]
    start = high - low + NEAR_MISS * across - 0.5 * along
    return _translation(
        "translation spheres near miss", (va + start, fa), (vb, fb), along, expect="near miss"
    )


def translation_spheres_overlap(n: int) -> Scene:
    """Two noisy spheres of equal size, deep in one another from the start."""
    return _translation(
        "translation spheres overlap", *_spheres(n, (0.5, 0.2, 0.1)), (-1.0, 0.3, 0.1), expect="overlap"
    )


# -- rotations ----------------------------------------------------------------------------------------------


def rotation_gears(n: int) -> Scene:
    """Gears in mesh, one turns about its own axis until its teeth touch the other's."""
    a, b = _gears(n, centre_distance=2.02)
    return _rotation("rotation gears", a, b, (0.0, 0.0, 1.0), 0.1, point=(2.02, 0.0, 0.0))


def rotation_gears_slivers(n: int) -> Scene:
    """The same with every triangle as long as the gear is wide."""
    a, b = _gears(n, centre_distance=2.02, slivers=True)
    return _rotation("rotation gears, slivers", a, b, (0.0, 0.0, 1.0), 0.1, point=(2.02, 0.0, 0.0))


def rotation_lid(n: int) -> Scene:
    """A lid, open by 110 degrees, closes onto a box whose knob stands in its way."""
    return _rotation("rotation lid", *_lid_and_box(n), (0.0, 1.0, 0.0), 110 * pi / 180, point=_HINGE)


def rotation_arm(n: int) -> Scene:
    """An arm sweeps about the vertical axis until it hits a post."""
    a, b = _arm_and_post(n, (0.45, 0.72, -0.1))
    return _rotation("rotation arm", a, b, (0.0, 0.0, 1.0), 1.6)


def rotation_arm_past_posts(n: int) -> Scene:
    """An arm sweeps below two hanging posts, at a gap of 0.02, until it hits a standing one."""
    return _rotation("rotation arm past posts", *_arm_and_three_posts(n), (0.0, 0.0, 1.0), 2.4)


def rotation_arm_turns_free(n: int) -> Scene:
    """An arm turns three and a half times, its hand passing under a post that hangs within its reach."""
    a, b = _arm_and_post(n, (0.6, 0.74, 0.85))
    return _rotation("rotation arm turns free", a, b, (0.0, 0.0, 1.0), 7 * pi, expect="free")


def rotation_gears_free(n: int) -> Scene:
    """Gears in mesh; one turns within the backlash."""
    a, b = _gears(n, centre_distance=2.02)
    return _rotation("rotation gears free", a, b, (0, 0, 1), 0.03, point=(2.02, 0, 0), expect="free")


def rotation_arm_near_miss(n: int) -> Scene:
    """The farthest vertex of the arm passes the nearest point of a post at a gap of 1e-6."""
    (va, fa), (vb, fb) = _arm_and_post(n, (0.0, 0.0, 0.0))
    tip = va[np.argmax(np.hypot(va[:, 0], va[:, 1]))]
    reach = np.hypot(tip[0], tip[1])
    # A tilted post, so that one vertex is the nearest; it goes a right angle ahead of the tip, to its height.
    vb = vb @ random_rotation(3).T
    ahead = np.array([-tip[1], tip[0], 0.0]) / reach
    nearest = vb[np.argmin(vb @ ahead)]
    vb = vb - nearest + ahead * (reach + NEAR_MISS) + [0.0, 0.0, tip[2]]
    return _rotation("rotation arm near miss", (va, fa), (vb, fb), (0.0, 0.0, 1.0), pi, expect="near miss")


def rotation_gears_overlap(n: int) -> Scene:
    """Gears pushed into one another, turning."""
    a, b = _gears(n, centre_distance=1.6)
    return _rotation("rotation gears overlap", a, b, (0, 0, 1), 0.1, point=(1.6, 0, 0), expect="overlap")


_MAKERS: tuple[Callable[[int], Scene], ...] = (
    translation_spheres,
    translation_tori,
    translation_gears,
    rotation_lid,
    rotation_arm,
    rotation_arm_past_posts,
    rotation_gears,
    translation_gears_slivers,
    rotation_gears_slivers,
    translation_spheres_free,
    translation_tori_free,
    rotation_arm_turns_free,
    rotation_gears_free,
    translation_spheres_near_miss,
    rotation_arm_near_miss,
    translation_spheres_overlap,
    rotation_gears_overlap,
)

# -- bodies -------------------------------------------------------------------------------------------------

Mesh = tuple[FloatArray, NDArray[np.int32]]
_HINGE = (0.0, 0.0, 0.46)


def _mesh(body: object) -> Mesh:
    return np.array(body.vertices), np.array(body.triangles)  # type: ignore[attr-defined]


def _translation(
    name: str, a: Mesh, b: Mesh, vector: tuple[float, float, float] | FloatArray, expect: str = "contact"
) -> Scene:
    return Scene(name, *a, *b, kind="translation", expect=expect, vector=np.asarray(vector, dtype=float))


def _rotation(
    name: str,
    a: Mesh,
    b: Mesh,
    axis: tuple[float, float, float],
    radians: float,
    point: tuple[float, float, float] = (0.0, 0.0, 0.0),
    expect: str = "contact",
) -> Scene:
    return Scene(
        name,
        *a,
        *b,
        kind="rotation",
        expect=expect,
        axis=np.asarray(axis, dtype=float),
        point=np.asarray(point, dtype=float),
        radians=radians,
    )


def _unit(v: FloatArray) -> FloatArray:
    return v / np.linalg.norm(v)


def _rotation_matrix(axis: FloatArray, radians: float) -> FloatArray:
    """Right-hand turn about a unit axis through the origin."""
    x, y, z = axis
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + sin(radians) * across + (1.0 - cos(radians)) * (across @ across)


def _spheres(n: int, start: tuple[float, float, float]) -> tuple[Mesh, Mesh]:
    va, fa = _mesh(examples.noisy_sphere(n, seed=1))
    return (va + start, fa), _mesh(examples.noisy_sphere(n, seed=2))


def _linked_tori(n: int) -> tuple[Mesh, Mesh]:
    """Ring a about a parallel to the y axis, ring b about the z axis; each passes the centre of the other."""
    va, fa = _mesh(examples.torus(n, minor=0.25, seed=3))
    upright = va[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    return (upright + [1.0, 0.0, 0.0], fa), _mesh(examples.torus(n, minor=0.25, seed=4))


def _gears(n: int, centre_distance: float, slivers: bool = False) -> tuple[Mesh, Mesh]:
    """Gear a about (centre_distance, 0), a little narrower than b; a tooth of b points into a gap of a.

    The width is cut in 1, 2, 5 layers for n = 1e3, 1e4, 1e5, which refines it half as fast as the outline.
    Slivers: in one layer, so that triangles at 1e5 are hundreds of times longer than wide.
    """
    layers = 1 if slivers else max(1, round(n ** (1.0 / 3.0) / 10.0))
    va, fa = _mesh(examples.spur_gear(n, teeth=20, width=0.3, backlash=0.3, layers=layers))
    a = va @ _rotation_matrix(np.array([0.0, 0.0, 1.0]), pi / 20).T + [centre_distance, 0.0, 0.01]
    return (a, fa), _mesh(examples.spur_gear(n, teeth=20, width=0.4, backlash=0.3, layers=layers))


def _lid_and_box(n: int) -> tuple[Mesh, Mesh]:
    """The lid stands open on the hinge, which runs along y above the back edge of the box."""
    va, fa = _mesh(examples.lid(n))
    closed = va + [0.005, 0.003, 0.465] - np.asarray(_HINGE)
    opened = closed @ _rotation_matrix(np.array([0.0, 1.0, 0.0]), -110 * pi / 180).T
    return (opened + _HINGE, fa), _mesh(examples.box_with_knob(n))


def _arm_and_post(n: int, foot: tuple[float, float, float]) -> tuple[Mesh, Mesh]:
    vb, fb = _mesh(examples.post(n, seed=6))
    return _mesh(examples.arm(n, seed=5)), (vb + foot, fb)


def _arm_and_three_posts(n: int) -> tuple[Mesh, Mesh]:
    """The posts share n triangles; the hanging ones end above the highest point of the arm at their distance."""
    va, fa = _mesh(examples.arm(n, seed=5))
    below = np.abs(np.hypot(va[:, 0], va[:, 1]) - 0.72) < 0.12
    hanging = va[below, 2].max() + 0.02 + 0.6  # a post is 1.2 long
    vertices, faces, count = [], [], 0
    for k, (distance, degrees, height) in enumerate([(0.72, 28, hanging), (0.72, 62, hanging), (0.85, 100, -0.1)]):
        v, f = _mesh(examples.post(n // 3, seed=6 + k))
        angle = degrees * pi / 180
        vertices.append(v + [distance * cos(angle), distance * sin(angle), height])
        faces.append(f + count)
        count += len(v)
    return (va, fa), (np.concatenate(vertices), np.concatenate(faces))
