"""The command `firstcontact`: one file per subcommand, errors in one line, exit codes with a meaning.

Nothing heavy is imported until a subcommand runs, so that --help stays quick.
"""

from __future__ import annotations

import atexit
import gc
import logging
import os
import sys
import threading
import warnings
from typing import NoReturn

import click

from firstcontact import __version__
from firstcontact.cli import outputs
from firstcontact.cli.batch import batch
from firstcontact.cli.check import check
from firstcontact.cli.curve import curve
from firstcontact.cli.info import info
from firstcontact.cli.intervals import intervals
from firstcontact.cli.robot import robot
from firstcontact.cli.sweep import sweep
from firstcontact.cli.toolpath import toolpath
from firstcontact.cli.warmup import warmup
from firstcontact.errors import FirstContactError, one_line

BAD_INPUT = 3
INTERRUPTED = 130
READER_LEFT = 141
"""Of a pipe: neither 0 nor 1, which would claim an answer."""

COLLECTING = 50_000, 50, 100
"""A command makes many objects that last until it ends, soon; looking for cycles among them costs a tenth."""


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="firstcontact")
def cli() -> None:
    """When, where and with which faces do two moving shapes first touch?

    Exit codes: 0 no contact (proved), 1 contact, 2 undecided, 3 bad input or usage, 130 interrupted; `curve` ends
    with 0.
    """


for command in (check, intervals, curve, sweep, robot, toolpath, batch, info, warmup):
    cli.add_command(command)


def main() -> None:
    """Run the command line and leave with its exit code."""
    gc.set_threshold(*COLLECTING)
    logging.getLogger("trimesh").addHandler(logging.NullHandler())  # its warnings would double our one line
    logging.getLogger("firstcontact").addHandler(_Said())
    logging.getLogger("firstcontact").setLevel(logging.INFO)
    warnings.showwarning = _warn
    if "_FIRSTCONTACT_COMPLETE" in os.environ:  # a shell asks for its script, or for words to complete
        cli.main(prog_name="firstcontact")
    outputs.write_whole()
    _leave(run(sys.argv[1:]))


def _leave(code: int) -> NoReturn:
    """End the process with that exit code, without taking apart what it has loaded: that took half a second after a
    STEP file.  Where a thread is still at work, which Python waits for, or an output is left unwritten, as ever.
    """
    if any(not thread.daemon for thread in threading.enumerate() if thread is not threading.main_thread()):
        sys.exit(code)
    atexit._run_exitfuncs()
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except (OSError, ValueError):  # told by Python
        sys.exit(code)
    outputs.tell("", "")
    os._exit(code)


class _Said(logging.Handler):
    """What the package logs, as errors are told."""

    def emit(self, record: logging.LogRecord) -> None:
        _say(record.getMessage())


def run(arguments: list[str]) -> int:
    """The exit code; every error on purpose becomes one line on stderr."""
    if sys.stdout is None:
        return _fail("standard output is closed; give it a place, /dev/null for none")
    escaped = outputs.escape_letters()
    try:
        # Not cli.main(): that turns a broken pipe into exit code 1, which means contact here.
        with cli.make_context("firstcontact", arguments) as context:
            code = cli.invoke(context)
        sys.stdout.flush()
        if escaped:
            _say(f"standard output ({sys.stdout.encoding}) lacks letters, such as {escaped[0]!a}; they are written "
                 "as escapes: set PYTHONIOENCODING=utf-8")  # fmt: skip
        return int(code)
    except click.exceptions.Exit as end:  # --help, --version
        return end.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return _fail(f"name a command: {', '.join(cli.commands)}")
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "firstcontact"
        return _fail(f"{error.format_message()} See '{command} --help'.")
    except FirstContactError as error:
        return _fail(str(error))
    except KeyboardInterrupt as stop:
        _say(f"interrupted; {stop}" if str(stop) else "interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        outputs.forget_the_rest()
        return READER_LEFT
    except OSError as error:  # files that were asked for have been written, or refused by name
        outputs.forget_the_rest()
        return _fail(f"standard output: {(error.strerror or str(error)).lower()}; give it another place")


def _warn(message: Warning | str, *_: object, **__: object) -> None:
    """One line on stderr, as of errors."""
    _say(str(message))


def _fail(message: str) -> int:
    _say(message)
    return BAD_INPUT


def _say(message: str) -> None:
    outputs.tell(f"firstcontact: {one_line(message)}")
