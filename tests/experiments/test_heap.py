"""Memory that was freed is used again without page faults."""

import platform
import subprocess
import sys

import pytest

SCRIPT = """
import resource, sys
import numpy as np
from regista.experiments.run.heap import keep_freed_memory

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        blocks = [np.full(3_000_000, 1.0) for _ in range(3)]  # 24 MB each
        del blocks
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

assert keep_freed_memory() == (sys.argv[1] == "glibc")
faults()
print(faults())
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="page faults are counted on Unix only")
def test_freed_memory_is_kept():
    kind = platform.libc_ver()[0]
    done = subprocess.run([sys.executable, "-c", SCRIPT, kind], capture_output=True, text=True, check=True)
    if kind == "glibc":  # 60 blocks of 5,900 pages
        assert int(done.stdout) < 1_000


def test_another_c_library_is_left_alone(monkeypatch):
    from regista.experiments.run import heap

    monkeypatch.setattr(heap.ctypes, "CDLL", lambda name: object())
    assert not heap.keep_freed_memory()
