"""`firstcontact robot`: a robot along a trajectory, against itself and its cell."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from firstcontact.cli import common
from firstcontact.cli.rows import row
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from firstcontact.batch.courses import CourseSearch, MetPair
    from firstcontact.batch.kept_parts import KeptLines, MetRow
    from firstcontact.body.kinds import Body
    from firstcontact.cli.outputs import Outputs
    from firstcontact.cli.progress import RowsProgress
    from firstcontact.cli.rows import More
    from firstcontact.mechanism.course import Course
    from firstcontact.result import FirstContact, Json


@click.command()
@click.argument("description")
@click.option("--trajectory", required=True, metavar="F", help="Joint values: CSV, NPZ or JSON of a JointTrajectory.")
@click.option("--scene", metavar="F", help="A scene whose bodies stand, or move, about the robot.")
@click.option("--srdf", metavar="F", help="Pairs of links that are switched off.")
@click.option("--package", "packages", metavar="NAME=DIR", multiple=True, help="Where package://NAME/ is.")
@click.option("--cubic", is_flag=True, help="Cubic values between waypoints (default: linear).")
@click.option("--csv", metavar="F|-", help="Write the results as CSV, row by row.")
@click.option("--jsonl", metavar="F|-", help="Write the results as JSON lines, each as soon as it is there.")
@click.option("--resume", is_flag=True, help="Go on where the run was stopped that wrote the same --csv or --jsonl.")
@common.output_options
def robot(
    description: str, trajectory: str, scene: str | None, srdf: str | None, packages: tuple[str, ...], cubic: bool,
    resume: bool, **outputs: Any,
) -> int:  # fmt: skip
    """Find what a robot meets first along its trajectory.

    DESCRIPTION is a URDF file.  Links that a joint connects are not asked about with each other.  Contacts are told as
    the waypoints are gone through, and in the end what is free.
    """
    from firstcontact.robot.robot import Robot
    from firstcontact.scene.load import load_scene

    options = common.Options(**outputs)
    rows = next((Path(x) for x in (options.jsonl, options.csv) if x not in (None, "-")), None)
    if resume and rows is None:
        raise click.UsageError("--resume: give the --csv or --jsonl file of the run that was stopped.")
    places = dict(_pair(text) for text in packages)
    with options.outputs(x for x in (description, trajectory, scene, srdf) if x is not None) as out:
        arm = Robot.load(description, srdf=srdf, packages=places)
        loaded = None if scene is None else load_scene(scene)
        out.refuse_read([*arm.files, *(() if loaded is None else loaded.files)])
        cell = {} if loaded is None else dict(loaded.bodies)
        course = arm.read_course(trajectory, interpolation="cubic" if cubic else "linear")
        kept = None if rows is None else _kept(rows, resume, trajectory, course, cell, cubic)
        run = Run(description, course, cell, options, out, kept, "" if loaded is None else loaded.unit)
        results = run.all()
        run.deliver(results, arm.name)
    return common.exit_code([hit.status.name for hit in results])


def _pair(text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign:
        raise InputError(f"--package {text}: write NAME=DIR")
    return name, value


def _kept(
    out: Path, resume: bool, trajectory: str, course: Course, cell: Mapping[str, Body], cubic: bool
) -> KeptLines:
    """What a run that was stopped has finished, to go on from; without `resume` nothing."""
    import hashlib

    from firstcontact import __version__
    from firstcontact.batch.files import digest
    from firstcontact.batch.kept_parts import KeptLines

    folder = KeptLines.folder_of(out)
    if not resume:
        shutil.rmtree(folder, ignore_errors=True)
    elif not folder.is_dir():
        raise InputError(f"{folder}: is not there, so nothing is left to go on with; leave --resume out")
    links = course.mechanism.links
    bodies = {f"{link}.{k}": body for link, own in links.items() for k, body in enumerate(own)}
    joints = [
        (x.name, x.parent, x.child, None if x.motion is None else x.motion.to_dict(), str(x.mimic))
        for x in course.mechanism.joints.values()
    ]
    skip = sorted(map(sorted, course.mechanism.skip))
    about = {
        "trajectory": hashlib.sha256(Path(trajectory).read_bytes()).hexdigest(),
        "robot": hashlib.sha256(f"{digest(bodies)} {joints} {skip}".encode()).hexdigest(),
        "scene": digest(cell),
        "interpolation": "cubic" if cubic else "linear",
        "version": __version__,
    }
    return KeptLines(out, about)


class Run:
    """A course gone through and told, part by part."""

    def __init__(
        self, label: str, course: Course, cell: Mapping[str, Body], options: common.Options, out: Outputs,
        kept: KeptLines | None, unit: str,
    ) -> None:  # fmt: skip
        self.label, self.course, self.cell, self.options, self.out = label, course, cell, options, out
        self.kept, self.unit, self.total = kept, unit, len(course.times) - 1

    def all(self) -> list[FirstContact]:
        """All answers, which are written as they come: contacts by their times, then what is free.

        Interrupted, it says how far it came, and what is kept.
        """
        from firstcontact.cli.progress import RowsProgress

        joints = {name: _value_of(name) for name in self.course.mechanism.free}
        results: list[FirstContact] = []
        with ExitStack() as stack:
            columns = {"waypoint": self._waypoint, **joints}
            files = common.row_files(self.options, self.out, self.unit, columns, self._keys)
            rows = [stack.enter_context(x) for x in files]
            label = f"{self.label}: waypoints"
            progress = stack.enter_context(RowsProgress(self.options.progress, label, self.out.say))
            following, before = self._begun()
            try:
                for found in self._found(following, before, progress):
                    results.append(found.hit)
                    for put in rows:
                        put(found.hit)
                    if not self.out.silent and found.hit.status.name != "FREE":
                        progress.say(self._told(found.hit))
            except KeyboardInterrupt:
                self.out.json("--json", lambda: self._document(results, interrupted=True))
                raise KeyboardInterrupt(self._stopped(following.begin)) from None
        return results

    def _begun(self) -> tuple[CourseSearch, list[MetPair]]:
        """What is left to ask, and what an earlier run has found."""
        from firstcontact.batch.courses import CourseSearch, MetPair
        from firstcontact.result import FirstContact

        done, rows = (0, []) if self.kept is None else self.kept.taken_over()
        following = CourseSearch(self.course, self.cell.values(), begin=done, settled=[x["pair"] for x in rows])
        pairs = list(following.pairs())
        before = []
        for x in rows:
            a, b = pairs[x["pair"]]
            before.append(MetPair(x["pair"], replace(FirstContact.from_dict(x["hit"]), a=a, b=b)))
        return following, before

    def _found(self, following: CourseSearch, before: list[MetPair], progress: RowsProgress) -> Iterator[MetPair]:
        from firstcontact.result import finite

        yield from before
        progress.rows(following.begin, self.total)
        for part in following.parts(lambda done: progress.rows(done, self.total)):
            yield from part.found
            if self.kept is not None:
                rows: list[MetRow] = [{"pair": pair, "hit": finite(hit.to_dict())} for pair, hit in part.found]
                self.kept.add(part.begin, part.end, rows)
        yield from following.free()

    def deliver(self, results: list[FirstContact], name: str) -> None:
        """What is written when all is known."""
        free = sum(hit.status.name == "FREE" for hit in results)
        self.out.say(f"{len(results)} pairs, {free} of them FREE from waypoint 0 to {self.total}")
        self.out.json("--json", lambda: self._document(results, robot=name))
        if self.options.html is not None:
            from firstcontact.view.assembly import SceneView
            from firstcontact.view.html import write_page

            links = [body for own in self.course.bodies.values() for body in own]
            bodies = {body.name or "": body for body in (*links, *self.cell.values())}
            self.out.file("--html", lambda path: write_page(path, results, SceneView(bodies, self.unit)))
        if self.kept is not None:
            self.kept.remove()

    def _document(self, results: list[FirstContact], **more: Json) -> dict[str, Json]:
        return {**more, "checks": [row(hit, self._keys) for hit in results]}

    @property
    def _keys(self) -> More:
        return {"waypoints": lambda hit: None if (k := self._waypoint(hit)) is None else [k, k + 1]}

    def _waypoint(self, hit: FirstContact) -> int | None:
        """The last waypoint, counted from 0, that is not after the contact."""
        return None if hit.time is None else self.course.stretch(hit.time)

    def _told(self, hit: FirstContact) -> str:
        k = self._waypoint(hit)
        if k is None:
            return str(hit)
        normal = "" if hit.normal is None else "; normal ({:.6g}, {:.6g}, {:.6g})".format(*hit.normal)
        return f"{hit}\n  between waypoints {k} and {k + 1}{normal}"

    def _stopped(self, at: int) -> str:
        told = f"decided from waypoint 0 to {at} of {self.total}"
        if self.kept is None:
            return told
        return f"{told}, kept in {self.kept.folder}; the same command with --resume goes on from there"


def _value_of(joint: str) -> Callable[[FirstContact], float | None]:
    """Where the joint stands at a contact."""
    return lambda hit: next((x.value for x in hit.joints if x.name == joint), None)
