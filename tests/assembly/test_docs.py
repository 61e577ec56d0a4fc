"""What docs/assemblies.md says is so."""

import doctest
import re
from pathlib import Path

from firstcontact.cli import run

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "assemblies.md").read_text(encoding="utf-8")


def test_the_session():
    found = doctest.testfile(str(ROOT / "docs" / "assemblies.md"), module_relative=False)
    assert found.attempted == 6 and found.failed == 0


def test_the_command(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    command, _, told = re.search(r"```console\n\$ firstcontact ([^\n]*)(\n)(.*?)```", TEXT, re.DOTALL).groups()
    assert run(command.split()) == 1
    assert capsys.readouterr().out == told
