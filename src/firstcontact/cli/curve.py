"""`firstcontact curve`: all points that two ruled surfaces at rest share."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from firstcontact.cli import common
from firstcontact.errors import InputError

if TYPE_CHECKING:
    from fractions import Fraction

    from firstcontact.body.kinds import Body
    from firstcontact.cli.outputs import Outputs
    from firstcontact.cli.progress import Progress
    from firstcontact.result_curve import IntersectionCurve
    from firstcontact.view.pair import Result


@common.resting_scene_command
@click.option("--tolerance", metavar="L", help="Greatest distance between a curve and its polyline (1e-6).")
@click.option("--box", nargs=6, metavar="X0 Y0 Z0 X1 Y1 Z1", help="Only what lies in this box.")
@click.option("--at", metavar="T", help="Time at which moving or deforming surfaces are taken.")
@click.option("--method", metavar="M", help="How to search; by default what suits the pair.")
def curve(scene: str, options: common.Options, **asked: str | tuple[str, ...] | None) -> int:
    """Find the intersection curve of each pair of surfaces at rest.

    SCENE is a TOML file; [[curve]] tables name the pairs, else every pair that is checked is taken.  Printed:
    branches, overlaps, isolated and singular points.  Ends with 0, whatever the surfaces share.
    """
    with options.outputs([scene]) as out:
        results = _curves(scene, options, out, _read(asked))
        common.deliver(results, options, out)
    return 0


def _curves(scene_file: str, options: common.Options, out: Outputs, asked: dict[str, Any]) -> list[Result]:
    from firstcontact.query import intersection_curve
    from firstcontact.scene.load import load_scene

    scene = load_scene(scene_file)
    out.refuse_read(scene.files)
    common.refuse_single(scene.path, scene.curves)

    questions = [replace(given, **asked) for given in scene.curves]

    def answers(progress: Progress) -> Iterator[IntersectionCurve]:
        for question in questions:
            progress.start(f"{question.a} / {question.b}")
            p, q = (_resting(scene.bodies[key], key, question.at) for key in (question.a, question.b))
            result = intersection_curve(p, q, **question.arguments())
            if options.json is not None:
                result.to_dict()  # exact ends may take long; the result keeps them
            yield result

    return common.answer_all(scene.path, "curve", questions, answers, options, out)


def _resting(body: Body, key: str, time: float | None) -> Body:
    if time is not None:
        return body.at(time) if hasattr(body, "at") else body
    if hasattr(body, "motion") or getattr(body, "deforming", False):
        how = "moves" if hasattr(body, "motion") else "deforms"
        raise InputError(f"{key} {how}; say at which time by --at T, or by the key at in [[curve]]")
    return body


def _read(asked: dict[str, Any]) -> dict[str, Any]:
    """The options that were given, as fields of the scene's questions."""
    from firstcontact.exact.numbers import positive_double
    from firstcontact.scene.load import parse_number

    def number(option: str, text: str) -> float | int | Fraction:
        try:
            return parse_number(text)
        except ValueError as error:
            raise InputError(f"--{option}: {error}") from error

    found = {key: value for key, value in asked.items() if value is not None}
    for option in found.keys() & {"tolerance", "at"}:
        found[option] = number(option, found[option])
    if "tolerance" in found:
        found["tolerance"] = positive_double(found["tolerance"], "--tolerance", "length")
    if "box" in found:
        corners = [number("box", x) for x in found["box"]]
        found["box"] = corners[:3], corners[3:]
    return found
