"""What `check`, `intervals` and `curve` share: their options, the walk over a scene's checks, their outputs."""

from __future__ import annotations

import functools
import json
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from firstcontact.errors import FirstContactError, InputError

if TYPE_CHECKING:
    from firstcontact.cli.progress import Progress

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


_OUTPUTS = (
    click.argument("scene"),
    click.option("--json", metavar="F|-", help="Write the results as JSON; - prints only them."),
    click.option("--html", metavar="F", help="Write a page that shows the results, offline."),
    click.option("--progress/--no-progress", default=None, help="Progress on stderr (default: on a tty)"),
)
_TIMES = (
    click.option("--exact", is_flag=True, help="Decide in exact arithmetic and give exact times."),
    click.option("--span", nargs=2, metavar="A B", help='From time A to time B: 0.5, 1/3, "inf".'),
    click.option("--workers", type=click.IntRange(1, 1024), metavar="N",
                 help="Cores that take part (default: all, where the work takes seconds)."),
)


def scene_command(function: Callable[..., int]) -> click.Command:
    """Turn `function(scene, options, **others)` into a command over a scene file that asks for times."""
    return _command(function, _OUTPUTS + _TIMES)


def resting_scene_command(function: Callable[..., int]) -> click.Command:
    """The same for bodies at rest."""
    return _command(function, _OUTPUTS)


def _command(function: Callable[..., int], decorators: tuple[Any, ...]) -> click.Command:
    @functools.wraps(function)
    def command(scene: str, **given: Any) -> int:
        common = {field.name: given.pop(field.name) for field in fields(Options) if field.name in given}
        return function(scene, Options(**common), **given)

    for decorator in reversed(decorators):
        command = decorator(command)
    return click.command(name=function.__name__)(command)


def _changes(body: Any) -> bool:
    """Whether it moves, or its shape does: ruled surfaces may deform with the time."""
    return hasattr(body, "motion") or getattr(body, "deforming", False)


def answer_checks(scene_file: str, options: Options, verb_name: str) -> list[Any]:
    """The verb's results for all checks of the scene, in order; their text is printed as they come."""
    from firstcontact.scene.load import load_scene

    check_target(options.json, options.html)
    span = _parse_span(options.span)
    scene = load_scene(scene_file)
    refuse_single(scene.path, scene.checks)
    from firstcontact import query
    from firstcontact.batch.results import Question, in_order, told_by_boxes
    from firstcontact.batch.workers import cores

    if not any(_changes(scene.bodies[key]) for check in scene.checks for key in (check.a, check.b)):
        warnings.warn(
            f"{scene.path}: nothing that is checked moves, so bodies are looked at as they stand; "
            "give one a [body.NAME.motion]", stacklevel=1,
        )  # fmt: skip
    questions = []
    for check in scene.checks:
        arguments = {**check.arguments(), "exact": check.exact or options.exact}
        if span is not None:
            arguments["span"] = span
        questions.append(Question(verb_name, scene.bodies[check.a], scene.bodies[check.b], arguments))
    known = told_by_boxes(questions)

    def answers(progress: Progress) -> Iterator[Any]:
        def begin(k: int) -> None:
            shown = _span_shown(questions[k].arguments["span"], questions[k].a, questions[k].b)
            progress.start(f"{scene.checks[k].a} / {scene.checks[k].b}", shown)

        def here(k: int) -> Any:
            begin(k)
            verb = getattr(query, verb_name)
            asked = questions[k]
            return known[k] if k in known else verb(asked.a, asked.b, progress=progress.report, **asked.arguments)

        return in_order(questions, here, begin, options.workers or cores())

    return answer_all(scene.path, "check", scene.checks, answers, options)


def _span_shown(span: Any, a: Any, b: Any) -> tuple[float, float]:
    """The times that are asked about, in doubles, where they are known before a verb has looked."""
    if span is not None:
        return float(span[0]), float(span[1])
    spans = [x.motion.span for x in (a, b) if hasattr(x, "motion")]
    return max((x[0] for x in spans), default=0.0), min((x[1] for x in spans), default=1.0)


def answer_all(
    path: Path, what: str, questions: Sequence[Any], answers: Callable[[Progress], Iterator[Any]], options: Options
) -> list[Any]:
    """The answers, in order, each printed as soon as it is there, unless JSON alone is.

    Interrupted, it delivers what is decided before it lets go.
    """
    from firstcontact.cli.progress import Progress

    results: list[Any] = []
    with Progress(options.progress, len(questions)) as progress:
        try:
            for result in answers(progress):
                results.append(result)
                if options.json != "-":
                    progress.say(str(result))
        except FirstContactError as error:
            question = questions[len(results)]
            raise type(error)(f"{path}: {what} {question.a} / {question.b}: {error}") from error
        except KeyboardInterrupt:
            deliver(results, options, interrupted=True)
            raise KeyboardInterrupt(f"{len(results)} of {len(questions)} decided; {progress.state}") from None
    return results


def deliver(results: list[Any], options: Options, *, interrupted: bool = False) -> None:
    """JSON to stdout, and the files that were asked for; interrupted: what is decided, and that there was more."""
    if options.json is not None:
        text = json.dumps(_document(results, interrupted), indent=1)
        if options.json == "-":
            click.echo(text)
        else:
            write(options.json, lambda path: path.write_text(text + "\n", encoding="utf-8"))
    if options.html is not None and (results or not interrupted):
        from firstcontact.view.html import write_page

        write(options.html, lambda path: write_page(path, results))


def exit_code(statuses: list[str]) -> int:
    """1 when any pair is in contact, else 2 when any is undecided, else 0."""
    if any(status in ("CONTACT", "INITIAL_CONTACT") for status in statuses):
        return CONTACT
    return UNDECIDED if "UNDECIDED" in statuses else FREE


def write_png(path: str, results: list[Any]) -> None:
    """A picture of the first result in contact, else of the first result."""
    from firstcontact.view.png import write_png

    touching = [result for result in results if exit_code([result.status.name]) == CONTACT]
    write(path, lambda target: write_png(target, (touching or results)[0]))


def check_target(*paths: str | None) -> None:
    """Refuse output paths in folders that are not there, before the work begins."""
    for path in paths:
        if path is not None and path != "-" and not _may_be_written(Path(path)):
            raise InputError(f"{path}: cannot be written; give a file in a folder that exists")


def _may_be_written(path: Path) -> bool:
    try:
        return path.parent.is_dir() and not path.is_dir()
    except OSError:  # a name that is too long
        return False


def refuse_single(path: Path, pairs: Sequence[Any]) -> None:
    """Refuse a scene without a pair of bodies."""
    if not pairs:
        raise InputError(f"{path}: a single body has nothing to touch; add a second [body.NAME]")


def _parse_span(span: tuple[str, str] | None) -> tuple[Any, Any] | None:
    from firstcontact.scene.load import parse_time

    if span is None:
        return None
    try:
        return parse_time(span[0]), parse_time(span[1])
    except ValueError as error:
        raise InputError(f"--span: {error}") from error


def write(path: str, write: Callable[[Path], Any]) -> None:
    try:
        write(Path(path))
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}; choose another file") from error


def _document(results: list[Any], interrupted: bool) -> dict[str, Any]:
    from firstcontact import __version__
    from firstcontact.result import SCHEMA, finite

    checks = [{key: x for key, x in finite(r.to_dict()).items() if key != "schema"} for r in results]
    more = {"interrupted": True} if interrupted else {}
    return {"schema": SCHEMA, "version": __version__, **more, "checks": checks}
