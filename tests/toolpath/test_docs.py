"""What docs/toolpaths.md and the README say of tool paths holds."""

import doctest
import re
from pathlib import Path

import pytest

from firstcontact.cli import run
from firstcontact.toolpath import gcode

ROOT = Path(__file__).resolve().parents[2]
TEXTS = {name: (ROOT / name).read_text(encoding="utf-8") for name in ("docs/toolpaths.md", "README.md")}


def test_its_session_prints_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    session = doctest.DocTestParser().get_doctest(TEXTS["docs/toolpaths.md"], {}, "toolpaths", "toolpaths.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 5


@pytest.mark.share(2)
@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_the_example_prints_what_is_shown(text, capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    (shown,) = re.findall(r'    \$ firstcontact toolpath examples/pocket.nc .* --from "0 0 80"\n((?:    .*\n)+)', text)
    assert run(["toolpath", "examples/pocket.nc", "--scene", "examples/setup.toml", "--from", "0 0 80"]) == 1
    assert capsys.readouterr().out == re.sub("^    ", "", shown, flags=re.MULTILINE)


def test_words_that_move_nothing_are_listed():
    text = TEXTS["docs/toolpaths.md"]
    ranges = re.search(r"\| moves nothing \| (.*?);", text)[1]
    listed = set()
    for first, last in re.findall(r"G(\d+)(?: to G(\d+))?", ranges):
        listed |= set(map(str, range(int(first), int(last or first) + 1)))
    assert listed == gcode.STILL - {"80"}
