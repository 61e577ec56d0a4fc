"""Threads and processes give the answers of `first_contact`, bit for bit, whatever becomes of them."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import active_children
from pathlib import Path

import numpy as np
import pytest

import firstcontact as fc
from firstcontact.batch import together, workers
from firstcontact.batch.questions import asked
from one_by_one import one_by_one, rows_of

CUBE = fc.examples.box((1, 1, 1))
TETRA = fc.Polyhedron([(3, 0, 0), (4, 0, 0), (3, 1, 0), (3, 0, 1)], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
BALL, EGG = fc.sphere(1), fc.ellipsoid((1, 2, 1)).translated((4, 0, 0))


def vectors(n, seed=0):
    return np.random.default_rng(seed).uniform([0, -2, -2], [6, 2, 2], (n, 3))


def many(n=40):
    """Pairs of all kinds: walked together, one by one, and errors."""
    v = vectors(n)
    queries = [(CUBE.moving(fc.Translation(x.tolist())), TETRA, (0, 1 + k % 3)) for k, x in enumerate(v)]
    queries += [(BALL.moving(fc.Translation(x.tolist())), EGG) for x in v[:8]]
    queries += [(CUBE.moving(fc.Rotation((0, 0, 1), (x[0], 2, 0), degrees=200)), TETRA) for x in v[:8]]
    queries += [
        (CUBE, CUBE), (fc.half_space((0, 0, 1), 0), fc.half_space((0, 0, 1), -1)),
        (CUBE.moving(fc.Translation((1, 0, 0))), TETRA, (1, 0)), (CUBE, TETRA, (0, math.nan)), (CUBE, TETRA, 3),
    ]  # fmt: skip
    order = np.random.default_rng(1).permutation(len(queries))
    return [queries[k] for k in order]


@pytest.fixture
def at_once(monkeypatch):
    """What is left goes to processes without looking whether it is worth it."""
    monkeypatch.setattr(workers, "WORTH", 0.0)
    monkeypatch.setattr(workers, "TRIED", 0.0)


def test_any_number_of_threads_gives_the_answers_one_by_one(monkeypatch):
    queries = many()
    expected = one_by_one(queries)
    assert sum(isinstance(row, str) for row in expected) >= 4
    monkeypatch.setattr(workers, "WORTH", math.inf)
    monkeypatch.setattr(workers, "THREAD_PART", 1e-9)
    monkeypatch.setattr(workers, "FIRST_WALKED", 4)  # so that there are parts for all of them
    for n in (1, 2, 5):
        assert rows_of(fc.first_contacts(queries, workers=n)) == expected


@pytest.mark.share(4)
@pytest.mark.parametrize("arguments", [{"exact": True}, {"budget": 5}, {"tolerance": 1e-3}, {"engine": "sweep"}])
def test_arguments_are_those_of_first_contact(arguments):
    queries = many(12)
    assert rows_of(fc.first_contacts(queries, workers=1, **arguments)) == one_by_one(queries, **arguments)


@pytest.mark.thorough
def test_a_worker_that_is_killed_is_no_loss(at_once, monkeypatch):
    """Every row is there, none twice, and the processes are gone in the end."""
    monkeypatch.setattr(workers, "FIRST_PART", 2)
    queries = [(BALL.moving(fc.Translation(x)), EGG) for x in vectors(60).tolist()]
    told, killed = [], []

    def progress(done, total):
        told.append((done, total))
        if done > 10 and not killed:
            killed.append(active_children()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    table = fc.first_contacts(queries, workers=2, progress=progress)
    assert killed and rows_of(table) == one_by_one(queries)
    done = [n for n, _ in told]
    assert done == sorted(set(done)) and told[-1] == (60, 60)
    assert not [x for x in active_children() if x.pid in killed]


class Frail(workers.Elsewhere):
    """One that is broken when it is asked, or by what it is asked, at the numbers that are given."""

    def __init__(self, bodies, when_asked, by_it):
        self.bodies, self.when_asked, self.by_it, self.asked, self.renewed = bodies, when_asked, by_it, 0, 0
        super().__init__(self.ask, 2, self.heal)

    def ask(self, questions, asking):
        self.asked += 1
        future = Future()
        if self.asked in self.when_asked:
            raise BrokenExecutor
        if self.asked in self.by_it:
            future.set_exception(BrokenExecutor())
        else:
            future.set_result(workers.timed_answers(self.bodies, questions, asking))
        return future

    def heal(self):
        self.renewed += 1


def test_parts_are_done_again_until_there_is_no_hope(monkeypatch):
    """Those that nobody takes, too: that ended the batch."""
    monkeypatch.setattr(workers, "FIRST_PART", 3)
    monkeypatch.setattr(workers, "LARGEST_PART", 3)
    queries = many()
    shapes = asked(queries).bodies
    frail = Frail(shapes, when_asked={2, 9, 10}, by_it={1, 4, 5, 12})
    assert rows_of(fc.first_contacts(queries, executor=frail)) == one_by_one(queries)
    assert frail.renewed == 7
    for hopeless in (Frail(shapes, range(5, 9999), ()), Frail(shapes, (), range(5, 9999))):
        with pytest.raises(BrokenExecutor):
            fc.first_contacts(queries, executor=hopeless)


class Deadly(Frail):
    """One that is lost with each part that holds one of some questions, and with all that is at work beside it."""

    def __init__(self, bodies, deadly):
        self.deadly, self.begun = deadly, []
        super().__init__(bodies, (), ())

    def ask(self, questions, asking):
        future = Future()
        self.begun = [x for x in self.begun if not x.done()] + [future]
        if any(questions.spans[k] in self.deadly for k in range(len(questions))):
            for each in self.begun:
                each.set_exception(BrokenExecutor())
        elif len(self.begun) > 3 or len(questions) < 3:
            future.set_result(workers.timed_answers(self.bodies, questions, asking))
        else:
            threading.Timer(0.05, self.later, (future, questions, asking)).start()
        return future

    def later(self, future, questions, asking):
        if not future.done():
            future.set_result(workers.timed_answers(self.bodies, questions, asking))


def test_a_question_that_ends_its_worker_every_time_is_an_error_in_its_row(monkeypatch):
    """It ended the batch."""
    monkeypatch.setattr(workers, "FIRST_PART", 4)
    monkeypatch.setattr(workers, "LARGEST_PART", 7)
    queries = [(CUBE.moving(fc.Translation(x)), TETRA, (0, 1 + k)) for k, x in enumerate(vectors(40).tolist())]
    deadly = Deadly(asked(queries).bodies, [(0, 6), (0, 7), (0, 31)])
    expected = one_by_one(queries)
    for k in (5, 6, 30):
        expected[k] = workers.LOST
    assert rows_of(fc.first_contacts(queries, executor=deadly)) == expected


@pytest.mark.share(2)
@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_executors_of_others(pool):
    queries = many(12)
    with pool(2) as executor:
        table = fc.first_contacts(queries, executor=executor)
    assert rows_of(table) == one_by_one(queries)


SCRIPT = """
import firstcontact as fc
from firstcontact.batch import together, workers
from firstcontact.batch.questions import asked
print("runs")
workers.WORTH = workers.TRIED = 0.0
ball = fc.sphere(1)
other = ball.translated((4, 0, 0))
hits = fc.first_contacts([(ball.moving(fc.Translation((k, 0, 0))), other) for k in range(8)], workers=2)
print(*hits.status)
"""


@pytest.mark.thorough
def test_a_script_needs_no_main(tmp_path):
    path = tmp_path / "script.py"
    path.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": str(Path(fc.__file__).parents[1])}
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, timeout=60, env=environment)
    assert done.stdout.splitlines() == ["runs", " ".join(["FREE"] * 2 + ["CONTACT"] * 6)], done.stderr


KILLED = """
import os, signal
from multiprocessing import active_children
def die(done, total):
    if done > 2:
        print(*(child.pid for child in active_children()), flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
"""


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


@pytest.mark.thorough
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at processes as Linux shows them")
def test_processes_end_with_the_one_that_started_them(tmp_path):
    """They waited for ever for one that was killed."""
    path = tmp_path / "script.py"
    path.write_text(KILLED + SCRIPT.replace("workers=2", "workers=2, progress=die"))
    environment = {**os.environ, "PYTHONPATH": str(Path(fc.__file__).parents[1])}
    with open(tmp_path / "said", "w+") as said:  # no pipe, which those that are left would hold open
        where = {"stdout": said, "stderr": subprocess.DEVNULL}
        done = subprocess.run([sys.executable, path], timeout=60, env=environment, **where)
        said.seek(0)
        _, pids = said.read().splitlines()
    assert done.returncode == -signal.SIGKILL and pids.split()
    end = time.monotonic() + 20
    while any(map(is_alive, pids.split())) and time.monotonic() < end:
        time.sleep(0.05)
    left = [int(pid) for pid in pids.split() if is_alive(pid)]
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert not left


@pytest.mark.thorough
def test_an_interrupt_ends_the_processes(at_once):
    queries = [(BALL.moving(fc.Translation(x)), EGG) for x in vectors(60).tolist()]

    def interrupt(done, total):
        if done > 5:
            raise KeyboardInterrupt

    before = set(active_children())
    with pytest.raises(KeyboardInterrupt):
        fc.first_contacts(queries, workers=2, progress=interrupt)
    assert not set(active_children()) - before


def test_an_interrupt_ends_the_threads(monkeypatch):
    """Parts that have not begun are not walked any more."""
    begun = []
    walk = together.walk_together

    def slowly(*args):
        begun.append(args)
        time.sleep(0.01)
        return walk(*args)

    monkeypatch.setattr(together, "walk_together", slowly)
    monkeypatch.setattr(together, "FEWEST", 1)
    monkeypatch.setattr(workers, "THREAD_PART", 1e-9)  # parts of one question

    def interrupt(done, total):
        if done > 1024:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fc.first_contacts((CUBE.moving(fc.Translations(vectors(1350))), TETRA), workers=2, progress=interrupt)
    assert 2 < len(begun) < 150


def test_what_is_refused_one_by_one_is_refused_though_boxes_are_apart():
    """Exact times of screws have no form: an error in each row, as `first_contact` raises it."""
    box = fc.examples.box((1, 1, 1))
    far = box.translated((50, 0, 0))
    moving = box.moving(fc.Screw((0, 0, 1), degrees=30, advance=1))
    table = fc.first_contacts([(moving, far)] * 40, exact=True)
    assert table.counts == {"error": 40} and "Screw" in table.error[0]
    assert fc.first_contacts([(moving, far)] * 40).counts == {"FREE": 40}
