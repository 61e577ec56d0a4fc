"""What docs/mechanisms.md says holds."""

import doctest
import re
from pathlib import Path

from firstcontact.cli import run

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "mechanisms.md").read_text(encoding="utf-8")


def test_its_session_prints_what_it_says():
    session = doctest.DocTestParser().get_doctest(TEXT, {}, "mechanisms", "mechanisms.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 9


def test_its_sweep_prints_what_it_says(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    (command, shown), = re.findall(r"    \$ firstcontact (.*)\n((?:    .*\n?)+)", TEXT)
    assert run(command.split()) == 1
    assert capsys.readouterr().out == re.sub("^    ", "", shown, flags=re.MULTILINE)
