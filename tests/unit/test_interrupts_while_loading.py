"""Ctrl-C while a package loads that catches all that is raised meanwhile."""

import os
import signal
import sys
import threading

import pytest

from firstcontact.interrupts import interrupted_after

GREEDY = """
import os, signal
try:
    os.kill(os.getpid(), signal.SIGINT)
    for _ in range(1000):
        pass
except BaseException:
    pass
"""


@pytest.fixture
def greedy(tmp_path, monkeypatch):
    """The name of such a package."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    (tmp_path / "greedy_package.py").write_text(GREEDY)
    monkeypatch.syspath_prepend(tmp_path)
    yield "greedy_package"
    sys.modules.pop("greedy_package", None)
    signal.signal(signal.SIGINT, before)


def test_it_is_raised_once_the_package_is_there(greedy):
    with pytest.raises(KeyboardInterrupt), interrupted_after():
        __import__(greedy)
    assert greedy in sys.modules and signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_it_goes_before_other_errors(greedy):
    with pytest.raises(KeyboardInterrupt), interrupted_after():
        __import__(greedy)
        raise ValueError


def test_without_it_nothing_changes(greedy):
    with pytest.raises(ValueError, match="own"), interrupted_after():
        raise ValueError("own")
    seen = []

    def elsewhere():
        with interrupted_after():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]


def test_where_it_is_ignored_it_stays_so(greedy):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with interrupted_after():
        os.kill(os.getpid(), signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
