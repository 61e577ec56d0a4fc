"""Where a command's output goes: text to standard output, answers to the files that its options name.

What is asked for by name is written whole, whatever becomes of standard output.
"""

from __future__ import annotations

import codecs
import io
import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

import click

from firstcontact.errors import FirstContactError, InputError

STANDARD = "-"
MAY_BE_STANDARD = "--json", "--csv", "--jsonl"
Put = Callable[[Any], None]
"""Takes one answer."""


class Writing(Protocol):
    """What rows are written to."""

    def write(self, text: str, /) -> int: ...

    def flush(self) -> None: ...


class Outputs:
    """Context of all that a command writes.

    targets: what each option names: a file, "-" for standard output, or None.  read: files that it reads.  Files that
    cannot be written, two options for one file, and files that are read are refused, before the work begins.

    Leaves with the error of standard output, if there was one: the text is cut off there, the files are whole.
    """

    def __init__(self, targets: Mapping[str, str | None], read: Iterable[str | Path] = ()) -> None:
        self._targets = {option: target for option, target in targets.items() if target is not None}
        self._files = {option: Path(x) for option, x in self._targets.items() if x != STANDARD}
        self._lost: OSError | None = None
        _refuse_standard([option for option, target in self._targets.items() if target == STANDARD])
        for option, path in self._files.items():
            if not _may_be_written(path):
                raise InputError(f"{option} {path}: cannot be written; give a file in a folder that exists")
        self._refuse_same()
        self.refuse_read(read)

    @property
    def silent(self) -> bool:
        """Whether standard output is for something else than text."""
        return STANDARD in self._targets.values()

    def refuse_read(self, files: Iterable[str | Path]) -> None:
        """Refuse to write over these files, which are read."""
        read = [Path(file) for file in files]
        for option, path in self._files.items():
            if any(_is_same(path, file) for file in read):
                raise InputError(f"{option} {path}: is read for this answer; choose another file")

    def _refuse_same(self) -> None:
        files = list(self._files.items())
        for k, (option, path) in enumerate(files):
            for other, before in files[:k]:
                if _is_same(path, before):
                    raise InputError(f"{other} and {option} both name {path}; give each a file of its own")

    def say(self, text: str) -> None:
        """Print a line on standard output, unless that is for something else."""
        if not self.silent:
            self.write(text + "\n")
            self.flush()

    def write(self, text: str, /) -> int:
        """To standard output.  Once that is lost it takes no more, so that the files become whole."""
        return self._tried(lambda: sys.stdout.write(text)) or 0

    def flush(self) -> None:
        self._tried(lambda: sys.stdout.flush())

    def _tried(self, act: Callable[[], int | None]) -> int | None:
        if self._lost is not None:
            return None
        try:
            return act()
        except OSError as error:
            if not self._files:
                raise
            forget_the_rest()
            self._lost = error
            return None

    @contextmanager
    def rows(self, option: str, make: Callable[[Writing], Put]) -> Iterator[Put]:
        """What takes answers and writes them, each at once, where the option says."""
        if self._targets[option] == STANDARD:
            yield make(self)
            return
        with self._named(option):
            file = open(self._files[option], "w", encoding="utf-8", newline="")
        try:
            with self._named(option):
                put = make(file)

            def named(answer: object) -> None:
                with self._named(option):
                    put(answer)

            yield named
        except BaseException:
            _close_anyhow(file)
            raise
        with self._named(option):
            file.close()

    def json(self, option: str, document: Callable[[], object]) -> None:
        """Write what `document` gives, where it is wanted."""
        if option not in self._targets:
            return
        text = json.dumps(document(), indent=1) + "\n"
        if self._targets[option] == STANDARD:
            self.write(text)
            self.flush()
        else:
            self.file(option, lambda path: path.write_text(text, encoding="utf-8"))

    def file(self, option: str, write: Callable[[Path], object]) -> None:
        """Have a file written, where it is wanted."""
        if option in self._files:
            with self._named(option):
                write(self._files[option])

    @contextmanager
    def _named(self, option: str) -> Iterator[None]:
        """What the system refuses, in one line that names option and file."""
        try:
            yield
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise InputError(f"{option} {self._files[option]}: {reason}; choose another file") from error
        except FirstContactError as error:
            if not isinstance(error.__cause__, OSError):
                raise
            raise InputError(f"{option} {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None and self._lost is not None:
            raise self._lost


def tell(text: str, end: str = "\n") -> None:
    """On standard error; where that takes nothing, nobody can be told, and the exit code stands."""
    try:
        click.echo(text + end, err=True, nl=False)
    except OSError:
        pass


def write_whole() -> None:
    """Give standard output a buffer where it has none (PYTHONUNBUFFERED), for this process.

    Without one Python drops what the system does not take of a text, on a full disk or as a reader leaves, and tells
    nobody.
    """
    out = sys.stdout
    if isinstance(out, io.TextIOWrapper) and isinstance(out.buffer, io.RawIOBase):
        sys.stdout = io.TextIOWrapper(io.BufferedWriter(out.buffer), encoding=out.encoding, line_buffering=True)


def escape_letters() -> list[str]:
    """Let standard output write letters that its encoding lacks as escapes; returns where they will be noted."""
    noted: list[str] = []

    def escape(error: UnicodeError) -> tuple[str | bytes, int]:
        if isinstance(error, UnicodeEncodeError):
            noted.append(error.object[error.start])
        return codecs.backslashreplace_errors(error)

    codecs.register_error("firstcontact.escape", escape)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="firstcontact.escape")
    return noted


def forget_the_rest() -> None:
    """Keep Python from complaining about what is left unwritten when it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refuse_standard(options: list[str]) -> None:
    """Refuse what cannot be printed, and two on one output."""
    for option in options:
        if option not in MAY_BE_STANDARD:
            raise click.UsageError(f"{option} -: is not for standard output; name a file.")
    if len(options) > 1:
        raise click.UsageError(f"{' and '.join(options)}: one of them may be -, for standard output.")


def _may_be_written(path: Path) -> bool:
    try:
        return path.parent.is_dir() and not path.is_dir()
    except (OSError, ValueError):  # a name that is too long, or holds a null
        return False


def _is_same(path: Path, other: Path) -> bool:
    """Whether both are one file, there or not; what is no file of the disk may be named twice."""
    try:
        if path.exists() and other.exists():
            return path.samefile(other) and path.is_file()
        return path.resolve() == other.resolve()
    except (OSError, ValueError, RuntimeError):  # told by who opens it
        return False


def _close_anyhow(file: io.TextIOBase) -> None:
    """Where an error is on its way: what was written whole is there, and that error is told."""
    try:
        file.close()
    except OSError:
        pass
