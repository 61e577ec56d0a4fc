"""What docs/mechanisms.md says holds."""

import doctest
import re
from pathlib import Path

import pytest

from firstcontact.cli import run

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "mechanisms.md").read_text(encoding="utf-8")


def test_its_session_prints_what_it_says():
    session = doctest.DocTestParser().get_doctest(TEXT, {}, "mechanisms", "mechanisms.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 9


COMMANDS = re.findall(r"    \$ firstcontact (.*)\n((?:    .*\n?)+)", TEXT)


@pytest.mark.share(3)
@pytest.mark.parametrize(("command", "shown"), COMMANDS, ids=[command.split()[0] for command, _ in COMMANDS])
def test_its_commands_print_what_they_say(command, shown, capsys, monkeypatch):
    if command.startswith("robot"):
        pytest.importorskip("yourdfpy")
    monkeypatch.chdir(ROOT)
    assert run(command.split()) == 1
    assert capsys.readouterr().out == re.sub("^    ", "", shown, flags=re.MULTILINE)
