"""Kernels are compiled once, by however many processes start together, and again when what they are made of changes."""

import ctypes
import dis
import importlib
import os
import pkgutil
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest
from llvmlite import binding
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher
from numba.core.registry import cpu_target

import firstcontact
from firstcontact import query
from firstcontact.kernels import cache, notices
from firstcontact.kernels.parts import KernelPart
from firstcontact.kernels.roomy import roomy
from firstcontact.kernels.thrift import effort
from firstcontact.search.trees import translate, walk
from firstcontact.search.trees.frame import twice_area_vectors

EXTRAS = "distributed", "pyarrow", "pandas", "pyvista"
ASK = """
from firstcontact.kernels.jit import kernel
def twice(x):
    return x + x
twice = kernel(twice)
assert twice(2) == 4 and twice(2.0) == 4.0
print(sum(twice.stats.cache_misses.values()), sum(twice.stats.cache_hits.values()))
"""


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="no lock there: a kernel may be compiled twice")
def test_processes_that_start_together_compile_a_kernel_once(tmp_path):
    (tmp_path / "ask.py").write_text(ASK)
    environment = os.environ | {"FIRSTCONTACT_CACHE": str(tmp_path / "cache")}
    asking = [
        subprocess.Popen([sys.executable, str(tmp_path / "ask.py")], stdout=subprocess.PIPE, text=True, env=environment)
        for _ in range(4)
    ]
    told = [[int(n) for n in process.communicate()[0].split()] for process in asking]
    assert all(process.returncode == 0 for process in asking)
    misses, hits = map(sum, zip(*told, strict=True))
    assert (misses, hits) == (2, 6)  # of four processes, for an integer and a float: whoever came first


FROM_FILE = """
import sys
import numpy as np
from firstcontact.search.trees.frame import twice_area_vectors
print(twice_area_vectors(np.eye(3), np.array([[0, 1, 2]])).tolist(), "numba.np.arraymath" in sys.modules)
"""


def test_kernels_from_files_load_nothing_to_compile_with():
    assert twice_area_vectors(np.eye(3), np.array([[0, 1, 2]])).tolist() == [[1.0, 1.0, 1.0]]  # and it is in a file
    done = subprocess.run([sys.executable, "-c", FROM_FILE], capture_output=True, text=True, check=True)
    assert done.stdout == "[[1.0, 1.0, 1.0]] False\n"


CALLED = """
from firstcontact.kernels.jit import kernel
LIMIT = {limit}
def called(x):
    return x + LIMIT
called = kernel(called)
def calls(x):
    "{said}"
    return called(x)
calls = kernel(calls)
print(calls(1), sum(calls.stats.cache_hits.values()))
"""


@pytest.mark.thorough
def test_an_edit_of_what_a_kernel_reads_is_seen_and_a_new_place_is_not_an_edit(tmp_path):
    environment = os.environ | {"FIRSTCONTACT_CACHE": str(tmp_path / "cache")}

    def told(folder, limit, said):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "ask.py").write_text(CALLED.format(limit=limit, said=said))
        at = [sys.executable, str(tmp_path / folder / "ask.py")]
        return subprocess.run(at, capture_output=True, text=True, check=True, env=environment).stdout.split()

    assert told("one", 1, "a") == ["2", "0"]
    assert told("one", 1, "b") == ["2", "1"]  # other words
    assert told("two", 1, "b") == ["2", "1"]  # another folder
    assert told("two", 2, "b") == ["3", "0"]  # a constant of a kernel that it calls


SHIPPED = """
import sys
from pathlib import Path
from firstcontact.kernels import cache, notices
from firstcontact.kernels.parts import KernelPart
from firstcontact.kernels.thrift import effort
from firstcontact.search.trees import translate, walk
from firstcontact.search.trees.frame import twice_area_vectors
cache.SHIPPED, cache._ALL_SHIPPED = Path(sys.argv[1]), Path(sys.argv[1]).parent
from firstcontact.kernels.jit import kernel
def twice(x):
    return x + x
twice = kernel(twice)
twice._cache._name = "firstcontact.search.made_up"
print(twice(2), len(cache.LOADED), len(cache.COMPILED))
"""


@pytest.mark.thorough
def test_shipped_kernels_are_found_by_any_processor_and_others_than_ours_are_told_once(tmp_path):
    (tmp_path / "ask.py").write_text(SHIPPED)
    portable = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}

    def told(cache_folder, shipped, more):
        environment = os.environ | {"FIRSTCONTACT_CACHE": str(tmp_path / cache_folder)} | more
        at = [sys.executable, str(tmp_path / "ask.py"), str(shipped)]
        done = subprocess.run(at, capture_output=True, text=True, check=True, env=environment)
        return done.stdout.split(), done.stderr

    nowhere = tmp_path / "none" / "here"
    assert told("built", nowhere, portable) == (["4", "0", "1"], "")
    (built,) = (tmp_path / "built").iterdir()
    assert told("user", built, {}) == (["4", "1", "0"], "")  # a processor with a name of its own
    assert not (tmp_path / "user").exists() or not list((tmp_path / "user").rglob("*.nbc"))
    out, err = told("user", built.with_name("numba-of-tomorrow"), {})
    assert out == ["4", "0", "1"] and err.count("\n") == 1
    why = f"the kernels shipped are for {built.name}, this is {cache.VERSIONS}"
    assert err.startswith(f"{why}: compiling the kernels for meshes, about ")


def test_a_first_run_says_what_it_compiles_before_it_does(caplog, monkeypatch):
    monkeypatch.setattr(notices, "_announced", set())
    with caplog.at_level("INFO", logger="firstcontact"):
        for module in ("search.trees.tree", "kernels.convex.simplex", "search.sweep.sheets", "kernels.brackets"):
            notices.announce(f"firstcontact.{module}.f", cache.VERSIONS, "")
    meshes, convex = (record.getMessage() for record in caplog.records)
    assert meshes.startswith("compiling the kernels for meshes, about ")
    assert convex.startswith("compiling the kernels for convex curved bodies, about ")


def test_the_families_are_of_modules_that_are_there():
    names = [info.name for info in pkgutil.walk_packages(firstcontact.__path__, "firstcontact.")]
    for start in notices.FAMILIES:
        assert any(name.startswith(f"firstcontact.{start}") for name in names), start


def test_all_that_kernels_read_is_in_their_digest():
    """By value, or by the digest of a kernel; types and functions by their names are of Python, NumPy and Numba."""
    kernels = 0
    for info in pkgutil.walk_packages(firstcontact.__path__, "firstcontact."):
        if info.name.endswith("__main__"):
            continue
        try:
            home = importlib.import_module(info.name)
        except ModuleNotFoundError as missing:  # of an extra that is not installed: there are no kernels
            assert missing.name in EXTRAS, missing
            continue
        for kernel in vars(home).values():
            if not isinstance(kernel, Dispatcher) or kernel.py_func.__module__ != info.name:
                continue
            kernels += 1
            assert isinstance(kernel._cache, cache.KernelCache)
            for name, value in _read(kernel.py_func, kernel.py_func.__code__):
                assert _is_told(value), (kernel, name, value)
            _ask_of_motion(kernel)
    assert kernels > 400


def test_files_that_are_laid_out_in_another_way_have_other_names(monkeypatch):
    def name():
        return walk.walk._cache._file(Path(), (), "x86_64", ("generic", "")).name

    now = name()
    monkeypatch.setattr(cache, "WRITING", cache.WRITING - 1)
    assert name() != now and name().split("-")[0] == now.split("-")[0]


def test_options_of_what_the_motion_chooses_are_in_the_digest(monkeypatch):
    """Kernels that were inlined by an option, or not, were taken for one another."""
    chosen, options = cache.IMPLEMENTATIONS[translate.earliest_meeting, 1]
    assert options == {"forceinline": True}
    before = cache.fingerprint(walk.walk, 1)
    monkeypatch.setattr(cache, "_fingerprints", {})
    assert cache.fingerprint(walk.walk, 1) == before
    monkeypatch.setattr(cache, "_fingerprints", {})
    monkeypatch.setitem(cache.IMPLEMENTATIONS, (walk.earliest_meeting, 1), (chosen, {}))
    assert cache.fingerprint(walk.walk, 1) != before


def _read(function, code):
    for step in dis.get_instructions(code):
        if step.opname == "LOAD_GLOBAL" and step.argval in function.__globals__:
            yield step.argval, function.__globals__[step.argval]
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _read(function, constant)


def _ask_of_motion(kernel):
    """Where the type of `motion` chooses, the kernel has one, and another digest for each."""
    names = kernel.py_func.__code__.co_varnames[: kernel.py_func.__code__.co_argcount]
    told = {n: cache.fingerprint(kernel, n) for n in range(4)}
    assert len(set(told.values())) == 1 or "motion" in names, (kernel, names)


def _is_told(value):
    if isinstance(value, tuple):
        return type(value) is tuple and all(map(_is_told, value))
    if isinstance(value, type):  # of a named tuple, whose fields are told
        return not value.__module__.startswith("firstcontact") or hasattr(value, "_fields")
    if isinstance(value, (types.ModuleType, types.FunctionType, Dispatcher, np.ndarray, *cache.PLAIN)):
        return True
    return not value.__module__.startswith("firstcontact")


SIGNALLED = """
import signal
import time
import numpy as np
from firstcontact.kernels.jit import kernel, with_signals
def both(x):
    return x + 1.0, x > 0.0
both = kernel(both)
both(np.zeros(2))
def handler(*_):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, handler)
told = []
@with_signals
def asked(k):
    end = time.perf_counter() + 0.1
    signal.setitimer(signal.ITIMER_REAL, 2e-4 + 1e-6 * k)
    while time.perf_counter() < end:
        both(np.zeros(2))
for k in range(300):
    try:
        asked(k)
    except BaseException as error:
        told.append(type(error).__name__)
print(*sorted(set(told)), len(told))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no timers there")
def test_an_interrupt_is_raised_as_it_is_wherever_it_arrives(tmp_path):
    """Numba makes a SystemError of one that arrives while it hands over a kernel's results.

    One that arrives in the collection of garbage is lost, as in any program: hardly any.
    """
    (tmp_path / "ask.py").write_text(SIGNALLED)
    done = subprocess.run([sys.executable, str(tmp_path / "ask.py")], capture_output=True, text=True, check=True)
    kind, count = done.stdout.split()
    assert kind == "KeyboardInterrupt" and int(count) >= 295


@pytest.mark.parametrize("verb", ["first_contact", "contact_intervals", "contact_pairs"])
def test_verbs_raise_what_a_handler_raised(verb, monkeypatch):
    def interrupted(_):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SystemError("returned a result with an exception set") from error

    monkeypatch.setattr(query.table, verb, interrupted)
    box = firstcontact.examples.box()
    with pytest.raises(KeyboardInterrupt):
        getattr(firstcontact, verb)(box.moving(firstcontact.Translation((0, 0, 2))), box)


PARTS = """
from firstcontact.kernels.cache import COMPILED
from firstcontact.kernels.jit import kernel
def inmost(x):
    if x < 0:
        raise ValueError("negative")
    return x + 1
inmost = kernel(inmost)
def middle(x):
    return 2 * inmost(x)
middle = kernel(middle)
def outer(x):
    return middle(x) + 4
outer = kernel(outer)
assert outer(3) == 12
try:
    outer(-1)
except ValueError as error:
    assert str(error) == "negative"
print(*(name.split("-")[0].split(".")[-1] + "." + name.split(".")[-1] for name in COMPILED))
print(middle(3), inmost(3), len(middle.signatures))
"""


@pytest.mark.thorough
def test_what_kernels_call_gets_no_code_of_its_own_until_python_calls_it(tmp_path):
    (tmp_path / "ask.py").write_text(PARTS)
    environment = os.environ | {"FIRSTCONTACT_CACHE": str(tmp_path / "cache")}

    def told():
        at = [sys.executable, str(tmp_path / "ask.py")]
        return subprocess.run(at, capture_output=True, text=True, check=True, env=environment).stdout.splitlines()

    assert told() == ["inmost.part middle.part outer.nbc", "8 4 1"]
    assert told() == ["", "8 4 1"]
    for file in (tmp_path / "cache").rglob("*outer*.nbc"):
        file.unlink()
    assert told() == ["outer.nbc", "8 4 1"]  # of parts from the disk, which raise what they raised


OFTEN = """
from firstcontact.kernels.cache import COMPILED
from firstcontact.kernels.jit import kernel
def called(x, k, turned):
    return -x * k if turned else x * k
called = kernel(called)
def calls(x):
    return called(x, 1, False) + called(x, 2, True) + called(x, int(x), x > 0)
calls = kernel(calls)
print(calls(3.0), *(name.split("-")[0].split(".")[-1] for name in COMPILED))
"""


def test_a_kernel_is_compiled_once_for_all_numbers_that_callers_write_out(tmp_path):
    (tmp_path / "ask.py").write_text(OFTEN)
    environment = os.environ | {"FIRSTCONTACT_CACHE": str(tmp_path / "cache")}
    at = [sys.executable, str(tmp_path / "ask.py")]
    done = subprocess.run(at, capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.split() == ["-12.0", "called", "calls"]


THRIFTY = """
import sys
import numpy as np
from firstcontact.kernels import thrift
if sys.argv[1] == "thrifty":
    thrift.apply()
from firstcontact.kernels.cache import COMPILED
from firstcontact.kernels.jit import kernel, uncounted
def part(x, k):
    if x[k] < 0.0:
        raise ValueError("negative")
    return x[k] * k
part = uncounted(part)
def whole(x, count):
    total, low = 0.0, np.zeros(2)
    for k in range(count):
        total += max(part(x, k), round(x[k], 1)) ** 2 / 3.0
        low[k % 2] -= x[k]
        while total > 0.5:
            total = total * 0.5 if x[k] > 0.5 else total - 0.25
    def twice(y):
        return 2.0 * y
    first = [part(x, k) for k in range(count) if x[k] > 0.1]
    return twice(total), len(first), np.sort(np.concatenate((low, x[::-1] * 2.0 - x)))
whole = kernel(whole)
a, n, rows = whole(np.array([0.26, 0.74, 0.05]), 3)
print(a.hex(), n, *map(float.hex, rows))
try:
    whole(np.array([-1.0]), 1)
except ValueError as error:
    print(error, len(COMPILED))
"""


@pytest.mark.thorough
def test_thrifty_compiling_makes_the_same_code(tmp_path):
    """Of overloads, closures, array expressions, exceptions, arrays counted, variables that branches assign to."""
    (tmp_path / "ask.py").write_text(THRIFTY)

    def told(how):
        environment = os.environ | {"FIRSTCONTACT_CACHE": str(tmp_path / how)}
        at = [sys.executable, str(tmp_path / "ask.py"), how]
        return subprocess.run(at, capture_output=True, text=True, check=True, env=environment).stdout

    assert told("thrifty") == told("plain")
    assert told("thrifty").splitlines()[1] == "negative 0"  # what one process kept serves another


def _faults_of_calls():
    """Pages asked of the system by calls, at each depth of the stack of frames."""
    import resource  # noqa: PLC0415 (not there on Windows)

    def below(depth):
        if depth:
            return below(depth - 1)
        before = resource.getrusage(resource.RUSAGE_THREAD).ru_minflt
        for _ in range(100):
            _nothing()
        return resource.getrusage(resource.RUSAGE_THREAD).ru_minflt - before

    return sum(map(below, range(300)))


def _nothing():
    """A call whose frame is larger than those below it, so that somewhere it is the first one of a chunk."""


_nothing.__code__ = _nothing.__code__.replace(co_stacksize=100)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="faults of a thread are counted there")
def test_calls_with_room_ask_for_no_memory_whenever_they_are_made():
    assert roomy(_faults_of_calls) < 100 <= _faults_of_calls()  # at some depth, by each of a hundred calls


def test_walks_that_llvm_tries_its_hardest_at_are_there():
    """Their code is found by how Numba begins its name."""
    for module in effort.WALKS:
        importlib.import_module(f"firstcontact.{module}")
    box = firstcontact.examples.box((1, 1, 1))
    query.first_contact(box.translated((0, 0, 3)).moving(firstcontact.Translation((0, 0, -3))), box)
    names = [done.fndesc.llvm_cpython_wrapper_name for done in walk.walk.overloads.values()]
    assert names and all(name.startswith(effort.HARD) for name in names)


def test_what_is_linked_before_its_callers_is_not_lost():
    """Found by a command: after parts were read from files, "Symbol _ZN5numba... not linked properly"."""
    codegen = cpu_target.target_context.codegen()

    def part(text):
        made = KernelPart(codegen, "part")
        made._shared_module, made._finalized = binding.parse_assembly(text), True
        return made

    inner = part("define linkonce_odr i64 @inner() { ret i64 42 }")
    middle = part("declare i64 @inner()\ndefine linkonce_odr i64 @middle() { %x = call i64 @inner() ret i64 %x }")
    outer = part("declare i64 @middle()\ndefine linkonce_odr i64 @outer() { %x = call i64 @middle() ret i64 %x }")
    code = "declare i64 @outer()\ndefine i64 @whole() { %x = call i64 @outer() ret i64 %x }"
    with global_compiler_lock:
        whole = codegen.create_library("whole")
        whole.add_llvm_module(binding.parse_assembly(code))
        for each in (inner, middle, outer):
            whole.add_linking_library(each)
        whole.finalize()
    assert ctypes.CFUNCTYPE(ctypes.c_int64)(whole.get_pointer_to_function("whole"))() == 42
