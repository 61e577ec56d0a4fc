"""First contacts of one pair of polyhedra under each of many rotations about one axis."""

from __future__ import annotations

import numpy as np

from firstcontact.body.polyhedron.polyhedron import Polyhedron
from firstcontact.contact.polyhedra.each import Exactly, FirstContacts, Place, Walked, Walks, first_of, piece_of, placed
from firstcontact.contact.polyhedra.problems.rotation_problem import RotationProblem
from firstcontact.exact.numbers import exact_value
from firstcontact.motion.arrays import Rotations
from firstcontact.search.trees.walk_each import OPEN


class EachRotation:
    """Body a turns by each of `motions`, about one axis and in one sense, over [0, last]; body b rests."""

    def __init__(self, a: Polyhedron, b: Polyhedron, motions: Rotations, lasts: np.ndarray) -> None:
        """lasts (n,): ends of the windows."""
        self.a, self.b, self.motions, self.lasts = a, b, motions, lasts

    def told(self) -> tuple[np.ndarray, np.ndarray, FirstContacts]:
        """FREE, MET or OPEN, node visits and pair tests, of each motion; the contacts."""
        problem = self._problem(0)
        a, b = problem.tree_a, problem.tree_b
        errors = problem.error_a, problem.error_b
        walks = Walks(a.boxes, a, b.boxes, b, sum(errors), *errors, problem.most_tests())
        angles = [self.motions.angle(k) for k in range(len(self.lasts))]
        lasts = map(exact_value, self.lasts.tolist())
        windows = [problem.until(abs(x * t), abs(y * t)).window() for (x, y), t in zip(angles, lasts, strict=True)]
        ranges = problem.motion.copy()  # walks fill it, and others may go on in other threads
        none = np.empty((0, 3))
        ends, sure_ends = np.array(windows).reshape(-1, 2).T.copy()
        return self._contacts(walks.walked(ranges, none, none, ends, sure_ends))

    def _contacts(self, walked: Walked) -> tuple[np.ndarray, np.ndarray, FirstContacts]:
        found = []
        for some in walked.groups():
            motion = int(walked.motions[some.start])
            problem = self._problem(motion)
            candidates = zip(*walked.times[some].T.tolist(), walked.named(some), strict=True)
            first = first_of(list(candidates), _exactly(problem))
            if first is None:
                walked.told[motion] = OPEN
            else:
                found.append((motion, problem.world_instant(first[0]), *first))
        return walked.told, walked.work, FirstContacts(
            np.array([motion for motion, *_ in found], np.int64),
            np.array([time for _, (time, _), *_ in found]),
            np.array([interval for _, (_, interval), *_ in found]).reshape(-1, 2),
            lambda k: found[k][2],
            lambda k: found[k][3],
        )  # fmt: skip

    def _problem(self, motion: int) -> RotationProblem:
        moving = self.a.moving(self.motions[motion])
        return RotationProblem(self.a, self.b, piece_of(moving, self.b, float(self.lasts[motion])))

    def place(self, contacts: FirstContacts, k: int) -> Place:
        """Elements, point and normal of a contact."""
        motion = int(contacts.motions[k])
        return placed(self._problem(motion), contacts, k, self.a.moving(self.motions[motion]), self.b)


def _exactly(problem: RotationProblem) -> Exactly:
    return lambda pair, lo, hi: problem.contact_within(*pair[1:], lo, hi)
