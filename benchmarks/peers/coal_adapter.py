"""coal: distances between two OBBRSS trees, and advancement loops on top of them.

From a free time t with distance d, no point of a that can touch b is faster than ``speed``, so a stays clear
of b until t + d / speed.  Two loops use that:

* Conservative: every step is the proved one.
* Leaping: steps to where the nearest pair would meet, up to MAX_STRETCH proved steps, and keeps what lands
  clear of b.  Mostly quicker, and able to leap over a contact that comes and goes within one step.

Both end when the nearest pair's time to contact is at most 1e-9 of the span, and add that time to the answer.
"""

from time import perf_counter

import coal
import numpy as np

from peers.answer import Answer

TOLERANCE = 1e-9
"""Of the span; smaller costs more queries, larger spoils the comparison at equal error."""
MAX_QUERIES = 20_000
MAX_STRETCH = 30.0
"""Of a leap, in proved steps.  3 to 30 are about equally quick on the barred scenes, 100 is not."""
ROUNDING = 1e-13
"""Of the span: a proved step this short stands for a gap made of rounding, whose normal says nothing."""


def _model(vertices, faces):
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(faces), len(vertices))
    model.addVertices(np.ascontiguousarray(vertices))
    model.addTriangles(np.ascontiguousarray(faces, dtype=np.int64))
    model.endModel()
    return model


class _Distance:
    """Distance between a at time t and b, with its witness points, counted and timed."""

    def __init__(self, models, scene):
        self.a, self.b = models
        self.scene = scene
        self.rest = coal.Transform3s.Identity()
        self.request = coal.DistanceRequest()
        self.request.enable_signed_distance = False
        self.queries = 0
        self.seconds = 0.0

    def __call__(self, t):
        pose = coal.Transform3s(*self.scene.pose(t))
        result = coal.DistanceResult()
        start = perf_counter()
        distance = coal.distance(self.a, pose, self.b, self.rest, self.request, result)
        self.seconds += perf_counter() - start
        self.queries += 1
        return distance, result.getNearestPoint1(), result.getNearestPoint2()


def _reach(vertices, scene):
    """Largest distance of the vertices from the axis."""
    off = vertices - scene.point
    return np.sqrt(np.max(np.einsum("ij,ij->i", off, off) - (off @ scene.axis) ** 2))


class Conservative:
    """Conservative advancement with proved steps."""

    name = "coal"
    stretch = 1.0

    def prepare(self, scene):
        reach = 0.0
        if scene.kind == "rotation":
            # A point of a that touches b is no farther from the axis than b's farthest.
            reach = min(_reach(scene.va, scene), _reach(scene.vb, scene))
        return (_model(scene.va, scene.fa), _model(scene.vb, scene.fb)), reach

    def query(self, state, scene):
        models, reach = state
        distance = _Distance(models, scene)
        if scene.kind == "translation":
            speed = np.linalg.norm(scene.vector)
        else:
            speed = abs(scene.radians) * reach
        answer = self._advance(distance, scene, speed)
        answer.counts = {"distance queries": distance.queries, "distance seconds": distance.seconds}
        return answer

    def _advance(self, distance, scene, speed):
        """Every turn moves ``free``, a time taken as reached without contact, or drops one long step."""
        gap, on_a, on_b = distance(0.0)
        if gap <= 0.0:
            return Answer("overlap", 0.0)
        free, short = 0.0, False
        while free < 1.0 and distance.queries < MAX_QUERIES:
            proved = gap / speed
            closing = _closing_speed(scene, on_a, on_b, gap)
            remaining = gap / closing if closing > 0.0 else np.inf
            if proved <= ROUNDING:
                return Answer("contact", free)
            if remaining <= TOLERANCE:
                return Answer("contact", free + remaining)
            step = proved if short else max(proved, min(remaining, self.stretch * proved))
            ahead = min(free + step, 1.0)
            found = distance(ahead)
            short = found[0] <= 0.0
            if not short:
                free, (gap, on_a, on_b) = ahead, found
            elif step - proved <= TOLERANCE:
                # The contact lies past the proved part of the step; a proved step touches by rounding only.
                return Answer("contact", ahead)
        return Answer("free" if free >= 1.0 else "failed")


class Leaping(Conservative):
    """Advancement that keeps every step that lands clear."""

    name = "coal leaping"
    stretch = MAX_STRETCH


def _closing_speed(scene, on_a, on_b, gap):
    """How fast the nearest point of a moves towards that of b, per unit of the span."""
    if scene.kind == "translation":
        velocity = scene.vector
    else:
        velocity = scene.radians * np.cross(scene.axis, on_a - scene.point)
    return float(velocity @ (on_b - on_a)) / gap
