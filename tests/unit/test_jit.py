"""Kernels are compiled once, by however many processes that start together."""

import os
import subprocess
import sys

import pytest

ASK = """
from firstcontact.kernels.jit import kernel
def twice(x):
    return x + x
twice = kernel(twice)
assert twice(2) == 4 and twice(2.0) == 4.0
print(sum(twice.stats.cache_misses.values()), sum(twice.stats.cache_hits.values()))
"""


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
