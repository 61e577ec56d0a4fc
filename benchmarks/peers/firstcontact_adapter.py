"""firstcontact: bodies made once, the motion made within every query."""

import firstcontact as fc
from peers.answer import Answer

STATUS = {
    fc.Status.FREE: "free",
    fc.Status.CONTACT: "contact",
    fc.Status.INITIAL_CONTACT: "overlap",
    fc.Status.UNDECIDED: "undecided",
}
COUNTED = ("node_visits", "pair_tests", "undecided", "exact_evaluations")


class FirstContact:
    """The certified verb; ``exact`` asks for the exact time instead."""

    name = "firstcontact"

    def prepare(self, scene):
        """Bodies, and by one query whatever the first query builds: trees, and their refit about the axis."""
        state = self.make(scene)
        self.query(state, scene)
        return state

    def make(self, scene):
        """The bodies alone."""
        return fc.Polyhedron(scene.va, scene.fa), fc.Polyhedron(scene.vb, scene.fb)

    def query(self, state, scene, exact=False):
        a, b = state
        hit = fc.first_contact(a.moving(_motion(scene)), b, exact=exact)
        counts = {key: float(getattr(hit.stats, key)) for key in COUNTED}
        if hit.time_interval is not None:
            counts["width"] = float(hit.time_interval[1] - hit.time_interval[0])
        return Answer(STATUS[hit.status], None if hit.time is None else float(hit.time), counts)

    def exact(self, state, scene):
        """The answer by exact arithmetic."""
        return self.query(state, scene, exact=True)


def _motion(scene):
    if scene.kind == "translation":
        return fc.Translation(scene.vector)
    return fc.Rotation(scene.axis, scene.point, radians=scene.radians)
