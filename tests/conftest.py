"""One hypothesis profile for all tests: the same examples in every run, no deadline on a busy machine; scene files.

With FIRSTCONTACT_ENGINE=NAME all tests that leave the choice of an engine to the library have the one of that name.
"""

import os

import hypothesis
import pytest

from amount import REST, THOROUGH
from firstcontact import query
from firstcontact.contact.polyhedra import first
from firstcontact.kernels import cache

hypothesis.settings.register_profile("fixed", derandomize=True, deadline=None, database=None, print_blob=True)
hypothesis.settings.load_profile("fixed")

ENGINE = os.environ.get("FIRSTCONTACT_ENGINE", "auto")
if ENGINE not in query.ENGINES:
    raise pytest.UsageError(f"FIRSTCONTACT_ENGINE is {ENGINE!r}; choose one of {', '.join(query.ENGINES)}")


def pytest_sessionstart(session):
    """All tests need all kernels: where none is compiled, they are together, in a fraction of the time that the tests
    would take, each for its own and two processes for the same ones."""
    config = session.config
    every = config.args_source is pytest.Config.ArgsSource.TESTPATHS and not config.option.collectonly
    if every and not hasattr(config, "workerinput") and not next(cache.FOLDER.rglob("*.nbc"), None):
        from firstcontact.warmup import cores, warm_together  # loads all that answers

        warm_together(cores())


@pytest.fixture(autouse=True, scope="session")
def chosen_engine():
    """Of translations and rotations of polyhedra; other motions are searched as ever."""
    if ENGINE == "auto":
        yield
        return

    def problems_in_order(a, b, parts, engine, threads=None):
        if threads is None:  # lists of pairs, which leave no choice
            return original(a, b, parts, engine)
        return original(a, b, parts, ENGINE if engine == "auto" else engine, threads)

    original, first.problems_in_order = first.problems_in_order, problems_in_order
    yield
    first.problems_in_order = original


def pytest_collection_modifyitems(config, items):
    """Leave out what is `thorough`, and what `share` marks leave out: on a diagonal, so that each value of one
    parameter is seen if another one has enough values.  Or leave out all else."""
    if THOROUGH:
        return
    values = {}
    left_out = {item for item in items if _is_left_out(item, values) is not REST}
    items[:] = [item for item in items if item not in left_out]
    config.hook.pytest_deselected(items=list(left_out))


def _is_left_out(item, values):
    """values: of each test's parameters those seen so far, by identity."""
    if item.get_closest_marker("thorough"):
        return True
    mark = item.get_closest_marker("share")
    if mark is None:
        return False
    places = 0
    for name, value in item.callspec.params.items():
        known = values.setdefault((item.nodeid.split("[")[0], name), {})
        places += known.setdefault(id(value), len(known))
    return places % mark.args[0] != 0


def pytest_runtest_setup(item):
    if ENGINE != "auto" and item.get_closest_marker("auto"):
        pytest.skip(f"about what 'auto' chooses, not {ENGINE!r}")


@pytest.fixture
def scene(tmp_path):
    """Write text as a scene file and give its path."""

    def write(text):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return path

    return write
