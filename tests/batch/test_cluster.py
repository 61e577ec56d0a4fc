"""A cluster of two processes of dask.distributed, in which one is killed in the middle."""

import importlib
import json
import os
import signal
import threading

import numpy as np
import pytest
from distributed import Client, LocalCluster

import firstcontact as fc
from firstcontact.batch import workers
from firstcontact.batch.cluster import Cluster
from firstcontact.batch.questions import asked
from firstcontact.cli import run
from one_by_one import one_by_one, rows_of

BALL, EGG = fc.sphere(1), fc.ellipsoid((1, 2, 1)).translated((4, 0, 0))
VECTORS = np.random.default_rng(0).uniform([0, -2, -2], [6, 2, 2], (150, 3)).tolist()
QUERIES = [(BALL.moving(fc.Translation(v)), EGG) for v in VECTORS]


@pytest.fixture(scope="module")
def client():
    with LocalCluster(n_workers=2, processes=True, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster, timeout=30) as client:
            yield client


@pytest.fixture(scope="module")
def expected():
    return one_by_one(QUERIES)


def within(seconds, ask):
    """What `ask` gives, or an error where it hangs."""
    given = []
    thread = threading.Thread(target=lambda: given.append(ask()), daemon=True)
    thread.start()
    thread.join(seconds)
    assert given, f"nothing after {seconds} s" if thread.is_alive() else "an error"
    return given[0]


@pytest.mark.thorough
def test_bodies_that_are_lost_are_brought_again(client, expected, monkeypatch):
    monkeypatch.setattr(workers, "LARGEST_PART", 8)
    cluster = Cluster(client, asked(QUERIES).bodies)
    first = cluster.there

    def lose(done, total):
        if done > 30 and cluster.there is first:
            first.cancel()

    table = within(60, lambda: fc.first_contacts(QUERIES, executor=cluster, progress=lose))
    assert rows_of(table) == expected and cluster.there is not first


@pytest.mark.thorough
def test_the_command_takes_a_cluster(client, expected, scene, tmp_path, capfd, monkeypatch):
    path, out = tmp_path / "queries.jsonl", tmp_path / "answers.jsonl"
    bodies = scene("""
[body.ball]
shape = "sphere"
radius = 1
[body.egg]
shape = "ellipsoid"
radii = [1, 2, 1]
at = [4, 0, 0]
""")
    path.write_text("".join(json.dumps({"a": "ball", "b": "egg", "vector": v}) + "\n" for v in VECTORS))
    command = ["batch", str(path), "--bodies", str(bodies), "--out", str(out), "--scheduler"]
    code = within(60, lambda: run([*command, client.scheduler.address]))
    answers = [json.loads(line) for line in out.read_text().splitlines()]
    assert code == 1 and answers == [{"a": "ball", "b": "egg"} | row for row in expected]
    capfd.readouterr()
    monkeypatch.setattr(importlib.import_module("firstcontact.cli.batch"), "REACHED_WITHIN", 1)
    assert within(30, lambda: run([*command, "tcp://127.0.0.1:9"])) == 3
    assert "--scheduler tcp://127.0.0.1:9: no answer within 1 s" in capfd.readouterr().err


@pytest.mark.thorough
def test_a_worker_that_is_killed_is_no_loss(client, expected, monkeypatch):
    """Every row is there, none twice."""
    monkeypatch.setattr(workers, "LARGEST_PART", 8)
    told, killed = [], []
    processes = list(client.run(os.getpid).values())

    def progress(done, total):
        told.append(done)
        if done > 30 and not killed:
            killed.append(processes[0])
            os.kill(killed[0], signal.SIGKILL)

    table = within(60, lambda: fc.first_contacts(QUERIES, executor=client, progress=progress))
    assert killed and rows_of(table) == expected
    assert told == sorted(set(told)) and told[-1] == len(QUERIES)
