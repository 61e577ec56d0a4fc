"""What a long run shows: how far it is, results as they come, and what is decided when it is interrupted."""

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time

import pytest

from firstcontact import query
from firstcontact.cli import progress
from firstcontact.cli.progress import Progress, _duration

CHECK = '[[check]]\npair = ["left", "right"]\n'
SLOW = """
import sys, time
from firstcontact import query
answers = {verb: getattr(query, verb) for verb in ("first_contact", "contact_intervals")}
asked = 0
def slow(verb):
    def ask(*bodies, progress, **arguments):
        global asked
        asked += 1
        if asked == 3:  # silent for ever, but for one report
            progress(0.125, 4321)
            time.sleep(60)
        return answers[verb](*bodies, progress=progress, **arguments)
    return ask
for verb in answers:
    setattr(query, verb, slow(verb))
from firstcontact.cli import main
main()
"""


@pytest.fixture
def three(cubes):
    return cubes("1.1", CHECK * 3)


def interrupt_when(process, stream, wanted: str, times: int = 1) -> str:
    """What the stream gave until it held `wanted` so many times, when SIGINT was sent."""
    text, end = "", time.monotonic() + 60
    while text.count(wanted) < times and time.monotonic() < end:
        if select.select([stream], [], [], 1)[0]:
            text += os.read(stream, 65536).decode()
    assert text.count(wanted) >= times, text
    time.sleep(0.3)  # the next one has begun
    process.send_signal(signal.SIGINT)
    return text


@pytest.mark.parametrize("verb", ["check", "intervals"])
def test_results_come_at_once_and_an_interrupt_leaves_what_is_decided(three, tmp_path, verb):
    report = tmp_path / "report.json"
    command = [sys.executable, "-c", SLOW, verb, str(three), "--json", str(report)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    out = interrupt_when(process, process.stdout.fileno(), "CONTACT", 2)  # the third takes a minute
    rest, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out.count("left and right: CONTACT") == 2 and rest == b""
    document = json.loads(report.read_text())
    assert document["interrupted"] is True and len(document["checks"]) == 2
    told = "firstcontact: interrupted; 2 of 3 decided; left / right (3 of 3): free until 0.125, 4,321 steps\n"
    assert err.decode().endswith(told)


def test_json_alone_is_a_whole_document_when_it_is_interrupted(command, three, monkeypatch):
    answer, asked = query.first_contact, []

    def interrupted(*bodies, **arguments):
        asked.append(bodies)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return answer(*bodies, **arguments)

    monkeypatch.setattr(query, "first_contact", interrupted)
    code, out, err = command("check", three, "--json", "-")
    document = json.loads(out)
    assert code == 130 and document["interrupted"] is True and len(document["checks"]) == 2
    assert err == "firstcontact: interrupted; 2 of 3 decided; left / right (3 of 3)\n"
    monkeypatch.undo()
    assert "interrupted" not in json.loads(command("check", three, "--json", "-").out)


def test_a_terminal_shows_pairs_steps_and_the_time_left(three):
    """Also while the search is silent; the line is gone when the run is over."""
    master, slave = pty.openpty()
    process = subprocess.Popen([sys.executable, "-c", SLOW, "check", str(three)], stdout=subprocess.PIPE, stderr=slave)
    os.close(slave)
    shown = interrupt_when(process, master, "4,321 steps; 2 s")  # the seconds go on without a report
    out, _ = process.communicate(timeout=30)
    assert process.returncode == 130 and out.decode().count("CONTACT") == 2
    assert re.search(r"left / right \(3 of 3\): free until 0.125, 4,321 steps; \d s, about \d s left", shown)
    rest = os.read(master, 65536).decode()
    assert rest.startswith(("\r\x1b[2K", "^C")) and "free until 0.125, 4,321 steps" in rest  # of what was not decided
    os.close(master)


def test_errors_come_after_the_results_before_them(command, cubes, monkeypatch):
    code, out, err = command("check", cubes("1.1", CHECK + CHECK + "span = [1, 0]\n"))
    assert code == 3 and out.count("CONTACT") == 1 and "check left / right: " in err


def test_time_left_is_what_the_share_done_tells(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    shown = Progress(False, 4, print)
    shown.start("a / b", (0.0, 2.0))
    clock[0] += 30
    shown.report(1.0, 77)  # an eighth of all
    assert shown._line() == "a / b (1 of 4): free until 1, 77 steps; 30 s, about 3 min 30 s left"
    shown.start("a / c", (0.0, float("inf")))
    shown.report(5.0, 1)
    assert shown._line() == "a / c (2 of 4): free until 5, 1 steps; 30 s, about 1 min 30 s left"
    shown.start("b / c", (1.0, 1.0))
    shown.report(float("-inf"), 3)
    assert shown._line() == "b / c (3 of 4): searching, 3 steps; 30 s, about 30 s left"
    assert _duration(59.4) == "59 s" and _duration(3599.6) == "1 h 0 min"
