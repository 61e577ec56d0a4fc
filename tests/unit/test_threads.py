"""Queries of several threads at once answer as one after the other, bit for bit."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator

import flint
import numpy as np
import pytest

import firstcontact as fc

TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def scenes():
    rng = np.random.default_rng(101)
    out = []
    for k in range(40):
        a, b = (rng.integers(-2, 3, (4, 3)).astype(float) + shift for shift in ([0, 0, 0], [3, 0, 0]))
        a, b = (fc.Polyhedron(x, TETRAHEDRON, solid=False) for x in (a, b))
        motion = fc.Rotation((1, 1, 1), point=(1, 0, 0), radians=6) if k % 2 else fc.Translation((3, 0.5, -0.25))
        out.append((a.moving(motion), b))
    return out


def bits(hit: fc.FirstContact) -> tuple:
    parts = (None if v is None else v.tobytes() for v in (hit.point, hit.normal))
    return (
        hit.status,
        hit.time,
        hit.time_interval,
        str(hit.time_exact),
        hit.multiplicity,
        hit.element_a,
        *parts,
    )


@pytest.fixture
def hasty_threads() -> Iterator[None]:
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.share(2)
@pytest.mark.parametrize("exact", [False, True])
def test_threads_get_the_same_bits(hasty_threads, exact):
    questions = scenes()
    before = flint.ctx.prec
    alone = [bits(fc.first_contact(*q, exact=exact)) for q in questions]
    assert len({b[0] for b in alone}) > 1
    together: list[dict[int, object]] = [{}, {}, {}]

    def ask(answers, order):
        for k in order:
            try:
                answers[k] = bits(fc.first_contact(*questions[k], exact=exact))
            except Exception as error:
                answers[k] = error

    orders = [np.random.default_rng(s).permutation(len(questions)).tolist() for s in range(len(together))]
    threads = [threading.Thread(target=ask, args=job) for job in zip(together, orders, strict=True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for answers in together:
        assert [answers[k] for k in range(len(questions))] == alone
    assert flint.ctx.prec == before


def test_answers_do_not_depend_on_the_precision_of_the_caller():
    question = scenes()[1]
    before = flint.ctx.prec
    answers = []
    try:
        for precision in (53, 64, 200):
            flint.ctx.prec = precision
            answers.append(bits(fc.first_contact(*question, exact=True)))
            assert flint.ctx.prec == precision
    finally:
        flint.ctx.prec = before
    assert answers[0] == answers[1] == answers[2]
