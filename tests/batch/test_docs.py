"""What docs/batches.md says holds: its sessions, its columns, its file of queries."""

import doctest
import re
from pathlib import Path

from firstcontact.batch.arrow import answer_columns
from firstcontact.batch.query_rows import KEYS, KNOWN
from firstcontact.cli import run
from firstcontact.result_table import ROW

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "batches.md").read_text(encoding="utf-8")


def block(language):
    (found,) = re.findall(rf"```{language}\n(.*?)```", TEXT, flags=re.DOTALL)
    return found


def test_its_sessions_print_what_they_say():
    session = doctest.DocTestParser().get_doctest(TEXT, {}, "batches", "batches.md", 0)
    assert doctest.DocTestRunner().run(session).failed == 0 and len(session.examples) == 9


def test_its_tables_name_all_columns():
    answers, queries = TEXT.split("## Files")
    assert set(ROW.names) <= set(re.findall(r"`(\w+)`", answers.split("## Cores")[0]))
    assert KNOWN <= set(re.findall(r"`(\w+)`", queries)) and set(KEYS) < KNOWN


def test_its_file_of_queries_is_answered(tmp_path, capsys):
    scene, queries, out = tmp_path / "scene.toml", tmp_path / "queries.csv", tmp_path / "answers.csv"
    scene.write_text(block("toml").replace('file = "', f'file = "{ROOT}/examples/'))
    queries.write_text(block("csv"))
    assert run(["batch", str(queries), "--bodies", str(scene), "--out", str(out), "--no-progress"]) == 1
    first, *rows = out.read_text().splitlines()
    assert first == ",".join(f'"{name}"' for name in ["id", "a", "b", *answer_columns()])
    assert [row.split(",")[0] for row in rows] == ['"near"', '"far"', '"back"']
    assert "3 queries in" in capsys.readouterr().out
