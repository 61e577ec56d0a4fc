"""What `check`, `intervals` and `curve` share: their options, the walk over a scene's checks, their outputs."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, fields
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from firstcontact.cli.outputs import Outputs, Put
from firstcontact.cli.rows import More, comma_separated, json_lines, row
from firstcontact.errors import FirstContactError, InputError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from fractions import Fraction

    from firstcontact.body.kinds import Body
    from firstcontact.cli.progress import Progress
    from firstcontact.result import Json
    from firstcontact.scene.load import Check, CurveQuestion, Scene
    from firstcontact.view.pair import Result
    from firstcontact.work import CheckArguments

FREE, CONTACT, UNDECIDED = 0, 1, 2


@dataclass(frozen=True)
class Options:
    """What the command line asks beyond the scene; None and False leave the scene's word."""

    json: str | None
    html: str | None
    progress: bool | None
    exact: bool = False
    span: tuple[str, str] | None = None
    workers: int | None = None
    csv: str | None = None
    jsonl: str | None = None
    all: bool = False
    move: str | None = None
    turn: str | None = None
    about: str | None = None
    degrees: str | None = None
    triangles: bool = False

    def outputs(self, read: Iterable[str | Path], **more: str | None) -> Outputs:
        """What is to be written, also by further options; read: files that the command line names to be read."""
        targets = {"json": self.json, "html": self.html, "csv": self.csv, "jsonl": self.jsonl, **more}
        return Outputs({f"--{option}": target for option, target in targets.items()}, read)


_OUTPUTS = (
    click.option("--json", metavar="F|-", help="Write the results as JSON; - prints only them."),
    click.option("--html", metavar="F", help="Write a page that shows the results, offline."),
    click.option("--progress/--no-progress", default=None, help="Progress on stderr (default: on a tty)"),
)
_NO_MORE: More = MappingProxyType({})
_SCENE = (click.argument("scene"),)
_TIMES = (
    click.argument("files", nargs=-1, required=True, metavar="SCENE | FILE FILE..."),
    click.option("--move", metavar='"X Y Z"', help="The first file's body moves by this vector."),
    click.option("--turn", metavar='"X Y Z"', help="The first file's body turns about an axis of this direction,"),
    click.option("--about", metavar='"X Y Z"', help="through this point (0 0 0),"),
    click.option("--degrees", metavar="D", help="so far."),
    click.option("--triangles", is_flag=True, help="Curved parts of STEP files become triangles: answers come sooner."),
    click.option("--all", is_flag=True, help="Print every answer in full, however many there are."),
    click.option("--csv", metavar="F|-", help="Write the results as CSV, row by row."),
    click.option("--jsonl", metavar="F|-", help="Write the results as JSON lines, each as soon as it is there."),
    click.option("--exact", is_flag=True, help="Decide in exact arithmetic and give exact times."),
    click.option("--span", nargs=2, metavar="A B", help='From time A to time B: 0.5, 1/3, "inf".'),
    click.option("--workers", type=click.IntRange(1, 1024), metavar="N",
                 help="Cores that take part (default: all, where the work takes seconds)."),
)


def output_options(command: Callable[..., int]) -> Callable[..., int]:
    """The options of what is written besides text, and of progress."""
    for decorator in reversed(_OUTPUTS):
        command = decorator(command)
    return command


def scene_command(function: Callable[..., int]) -> click.Command:
    """Turn `function(files, options, **others)` into a command over a scene file, or meshes, that asks for times."""
    return _command(function, _TIMES + _OUTPUTS)


def resting_scene_command(function: Callable[..., int]) -> click.Command:
    """The same, `function(scene, options, **others)`, for bodies at rest."""
    return _command(function, _SCENE + _OUTPUTS)


def _command(
    function: Callable[..., int], decorators: Sequence[Callable[[Callable[..., int]], Callable[..., int]]]
) -> click.Command:
    @functools.wraps(function)
    def command(**given: Any) -> int:
        what = given.pop("files", None) or given.pop("scene")
        common = {field.name: given.pop(field.name) for field in fields(Options) if field.name in given}
        return function(what, Options(**common), **given)

    for decorator in reversed(decorators):
        command = decorator(command)
    return click.command(name=function.__name__)(command)


def answer_checks(files: tuple[str, ...], options: Options, out: Outputs, verb_name: str) -> list[Result]:
    """The verb's results for all checks of the scene, in order, printed and written as the options ask."""
    from firstcontact.cli.given import given_scene

    span = _parse_span(options.span)
    scene = given_scene(files, options.move, options.turn, options.about, options.degrees, options.triangles)
    out.refuse_read(scene.files)
    refuse_single(scene.path, scene.checks)
    from firstcontact.assembly.resting import moves
    from firstcontact.assembly.together import PairQuestion, answers
    from firstcontact.batch.workers import cores

    if not any(moves(scene.bodies[key]) for check in scene.checks for key in (check.a, check.b)):
        how = "give one a [body.NAME.motion]" if len(files) == 1 else "give --move or --turn"
        warnings.warn(
            f"{scene.path}: nothing that is checked moves, so bodies are looked at as they stand; {how}", stacklevel=1
        )
    asked = []
    for check in scene.checks:
        arguments: CheckArguments = {**check.arguments(), "exact": check.exact or options.exact}
        if span is not None:
            arguments["span"] = span
        asked.append(PairQuestion.of(verb_name, scene.bodies, check.a, check.b, arguments, scene.allow))

    def given(progress: Progress) -> Iterator[Result]:
        def begin(k: int) -> None:
            question = asked[k].question
            shown = _span_shown(question.arguments["span"], question.a, question.b)
            progress.start(f"{scene.checks[k].a} / {scene.checks[k].b}", shown, k + 1)

        return answers(asked, begin, progress.report, options.workers or cores())

    with ExitStack() as stack:
        rows = [stack.enter_context(x) for x in row_files(options, out, scene.unit)]
        results = answer_all(scene.path, "check", scene.checks, given, options, out, scene, rows)
    deliver(results, options, out, scene)
    return results


def row_files(
    options: Options, out: Outputs, unit: str, columns: More = _NO_MORE, keys: More = _NO_MORE
) -> Iterator[AbstractContextManager[Put]]:
    """Contexts of what takes results row by row; columns: further ones of CSV; keys: further ones of JSON lines."""
    if options.csv is not None:
        yield out.rows("--csv", comma_separated(unit, columns))
    if options.jsonl is not None:
        yield out.rows("--jsonl", json_lines(keys))


def _span_shown(span: Sequence[float | Fraction] | None, a: Body, b: Body) -> tuple[float, float]:
    """The times that are asked about, in doubles, where they are known before a verb has looked."""
    if span is not None:
        return float(span[0]), float(span[1])
    spans = [x.motion.span for x in (a, b) if hasattr(x, "motion")]
    return max((x[0] for x in spans), default=0.0), min((x[1] for x in spans), default=1.0)


def answer_all(
    path: Path,
    what: str,
    questions: Sequence[Check | CurveQuestion],
    answers: Callable[[Progress], Iterator[Result]],
    options: Options,
    out: Outputs,
    scene: Scene | None = None,
    rows: Sequence[Put] = (),
) -> list[Result]:
    """The answers, in order; each is printed as soon as it is there, or the most of them that matters in the end.

    scene: whose answers are printed with how far its bodies have moved, and of many the contacts alone.  rows: take
    each answer.  Interrupted, it delivers what is decided before it lets go.
    """
    from firstcontact.cli import text
    from firstcontact.cli.progress import Progress

    results: list[Result] = []
    brief = scene is not None and len(questions) > text.FEW and not options.all
    with Progress(options.progress, len(questions), out.say) as progress:
        try:
            for result in _named(path, what, questions, answers(progress)):
                results.append(result)
                for put in rows:
                    put(result)
                if not brief and not out.silent:
                    progress.say(str(result) if scene is None else text.in_full(result, scene))
        except KeyboardInterrupt:
            if scene is not None and brief and results and not out.silent:
                progress.say(text.summary(results, scene))
            deliver(results, options, out, scene, interrupted=True)
            raise KeyboardInterrupt(f"{len(results)} of {len(questions)} decided; {progress.state}") from None
        if scene is not None and not out.silent:
            told = text.summary(results, scene) if brief else text.left_out(scene)
            if told:
                progress.say(told)
    return results


def _named(
    path: Path, what: str, questions: Sequence[Check | CurveQuestion], answers: Iterator[Result]
) -> Iterator[Result]:
    """The answers; an error names the question that is not answered."""
    done = 0
    try:
        for done, result in enumerate(answers, 1):  # noqa: B007
            yield result
    except FirstContactError as error:
        question = questions[done]
        raise type(error)(f"{path}: {what} {question.a} / {question.b}: {error}") from error


def deliver(
    results: list[Result], options: Options, out: Outputs, scene: Scene | None = None, *, interrupted: bool = False
) -> None:
    """JSON to stdout, and the files that were asked for; interrupted: what is decided, and that there was more."""
    out.json("--json", lambda: _document(results, scene, interrupted))
    if options.html is not None and (results or not interrupted):
        from firstcontact.view.assembly import SceneView
        from firstcontact.view.html import write_page

        whole = SceneView(scene.bodies, scene.unit) if scene is not None and len(scene.bodies) > 2 else None
        out.file("--html", lambda path: write_page(path, results, whole))


def exit_code(statuses: Iterable[str]) -> int:
    """1 when any pair is in contact, else 2 when any is undecided, else 0."""
    statuses = list(statuses)
    if any(status in ("CONTACT", "INITIAL_CONTACT") for status in statuses):
        return CONTACT
    return UNDECIDED if "UNDECIDED" in statuses else FREE


def exit_code_of(results: Iterable[Result]) -> int:
    """The same of answers; those that are allowed do not count."""
    from firstcontact.assembly.together import verdict

    return exit_code(map(verdict, results))


def write_png(out: Outputs, results: list[Any]) -> None:
    """A picture of the first result in contact, else of the first result."""
    from firstcontact.view.png import write_png

    touching = [result for result in results if exit_code_of([result]) == CONTACT]
    out.file("--png", lambda target: write_png(target, (touching or results)[0]))


def refuse_single(path: Path, pairs: Sequence[Check | CurveQuestion]) -> None:
    """Refuse a scene without a pair of bodies."""
    if not pairs:
        raise InputError(f"{path}: a single body has nothing to touch; add a second [body.NAME]")


def _parse_span(span: tuple[str, str] | None) -> tuple[float | int | Fraction, float | int | Fraction] | None:
    from firstcontact.scene.load import parse_time

    if span is None:
        return None
    try:
        return parse_time(span[0]), parse_time(span[1])
    except ValueError as error:
        raise InputError(f"--span: {error}") from error


def _document(results: Sequence[Result], scene: Scene | None, interrupted: bool) -> dict[str, Json]:
    from firstcontact import __version__
    from firstcontact.result import SCHEMA

    checks = [row(result, {}) for result in results]
    more: dict[str, Json] = {"interrupted": True} if interrupted else {}
    if scene is not None and scene.unit:
        more["unit"] = scene.unit
    if scene is not None and scene.resting:
        more["at_rest"] = scene.resting
    return {"schema": SCHEMA, "version": __version__, **more, "checks": checks}
