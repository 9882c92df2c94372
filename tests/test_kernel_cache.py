"""Tests of the kernel cache: concurrent and killed processes, and caches that are damaged or cannot be written."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from regista.kernels import jit, notices
from regista.kernels.notices import WAITING, reached
from regista.kernels.numba_linking import Kernel

pytestmark = pytest.mark.skipif(jit.kernel(lambda x: x).__class__ is not Kernel, reason="Numba compiles as usual")

# A program with two kernels; with `slow`, it compiles for longer than `PATIENCE`, so another process reports waiting.
PROGRAM = """
import sys, time
from pathlib import Path
from regista.kernels import notices
from regista.kernels.jit import kernel

notices.PATIENCE = 0.2

@kernel
def twice(x):
    return 2 * x

@kernel
def twice_and_one(x):
    return twice(x) + 1

if "slow" in sys.argv:
    usual = twice_and_one._compiler.compile
    def compile(*args):
        Path("compiling").touch()
        time.sleep(float(sys.argv[2]))
        return usual(*args)
    twice_and_one._compiler.compile = compile
print(twice_and_one(3), sum(twice_and_one.stats.cache_hits.values()))
"""
COMPILED, LOADED = "7 0", "7 1"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the program and an empty cache."""
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "cache").mkdir(mode=0o700)
    return tmp_path


def start(folder: Path, *words: str) -> subprocess.Popen[str]:
    """Start the program."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(jit.ROOT)}
    command = [sys.executable, "program.py", *words]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=pipe, stderr=pipe, text=True)


def said(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Wait for the end of a process; return its stdout and stderr."""
    out, errors = process.communicate(timeout=60)
    return out.strip(), errors.strip()


@contextmanager
def compiling(folder: Path, seconds: float) -> Iterator[subprocess.Popen[str]]:
    """Start a process that compiles for `seconds`; yield it once compilation has begun, and kill it afterwards."""
    process = start(folder, "slow", str(seconds))
    try:
        until = time.monotonic() + 60
        while not (folder / "compiling").exists():
            assert process.poll() is None and time.monotonic() < until
            time.sleep(0.02)
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.long
def test_who_starts_meanwhile_says_that_it_waits_and_loads_the_result(folder: Path) -> None:
    with compiling(folder, 4) as first:
        second = start(folder)
        assert said(second) == (LOADED, WAITING)
        assert said(first)[0] == COMPILED
    assert said(start(folder)) == (LOADED, "")


@pytest.mark.long
def test_who_is_killed_while_compiling_blocks_nobody(folder: Path) -> None:
    with compiling(folder, 600) as first:
        second = start(folder)
        assert second.stderr is not None and second.stderr.readline().strip() == WAITING
        assert second.poll() is None
        first.send_signal(signal.SIGKILL)
        assert said(second) == (COMPILED, "")
    assert said(start(folder)) == (LOADED, "")


@pytest.mark.long
def test_damaged_caches_are_replaced(folder: Path) -> None:
    said(start(folder))
    for ending in ("*.nbc", "*.nbi"):
        (damaged,) = (folder / "cache").rglob(f"*twice_and_one*{ending[1:]}")
        damaged.write_bytes(damaged.read_bytes()[:20])
        out, errors = said(start(folder))
        assert out == COMPILED and errors.startswith("regista: cached kernels are damaged and compiled again")
        assert said(start(folder)) == (LOADED, "")


# All uses of environments by commands: different programs, representations, numbers of matches and of agents.
PLAY = """
import sys
from dataclasses import replace
import numpy as np
from numba.core.dispatcher import Dispatcher
from regista.envs.football.config import FootballConfig
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.run.games import entry_points
from regista.minigames.suites import NAMED
from ued import METHODS, PPOConfig

SMALL = PPOConfig(num_steps=4, num_minibatches=1, hidden_size=20)
for name, count, settings, ppo in (
    ("1v1Free", 3, {}, SMALL),
    ("1v1Free", 20, {"representation": "simple115"}, replace(SMALL, memory="gru", shared_torso=True)),
    ("Buildup", 2, {"control": "all"}, replace(SMALL, team="shared", critic="central")),
    ("Buildup", 1, {"representation": "raw", "control": "all"}, None),
    ("Gauntlet", 2, {"representation": "smm_stacked", "rewards": "scoring,checkpoints"}, None),
):
    env = FootballVectorEnv(NAMED[name].program, count, config=replace(FootballConfig(), **settings))
    env.reset(seed=0)
    env.step(np.zeros(env.action_space.shape, np.int64))
    env.set_state(env.get_state())
    env.program_actions()
    if ppo is not None:
        METHODS["plr"].load()(env, ppo, seed=0, env_steps=100).update()
ours = [module for name, module in sys.modules.items() if name.startswith(("regista.", "scenic_lite."))]
kernels = {id(kernel): kernel for module in ours for kernel in vars(module).values() if isinstance(kernel, Dispatcher)}
assert [len(entry.signatures) for entry in entry_points()] == [1] * len(entry_points())
called = {kernel.py_func for kernel in kernels.values() if kernel.signatures}
assert called == {entry.py_func for entry in entry_points()}, called
"""


@pytest.mark.long
def test_python_calls_no_kernels_but_the_entry_points_each_with_the_same_types() -> None:
    done = subprocess.run([sys.executable, "-c", PLAY], cwd=jit.ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@jit.kernel
def thrice(x):
    return 3 * x


@jit.kernel
def four_times(x):
    return thrice(x) + x


def test_a_full_disk_is_no_error(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    @contextmanager
    def full(path: str) -> Iterator[None]:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        yield

    fresh = jit.kernel(lambda x: x + 5)
    monkeypatch.setattr(notices, "_said", set())
    monkeypatch.setattr(fresh._cache._cache_file, "_open_for_write", full)
    assert fresh(1) == 6 and fresh(1.5) == 6.5
    where = f"No space left on device: {fresh._cache.cache_path}"
    assert capfd.readouterr().err == f"regista: compiled kernels are not cached: {where}\n"


def test_a_folder_without_locks_is_no_error(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    fresh = jit.kernel(lambda x: x + 6)
    monkeypatch.setattr(fresh._cache, "_cache_path", str(tmp_path / "missing" / "folder"))
    assert fresh(1) == 7


def test_a_kernel_reaches_itself_and_what_it_calls() -> None:
    assert reached(four_times.py_func) == {four_times.py_func, thrice.py_func}


def test_the_line_tells_what_is_compiled_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [100.0]
    monkeypatch.setattr(notices.time, "monotonic", lambda: clock[0])
    with notices.at_work(["thrice", "four_times"], 30) as work:
        clock[0] = 112.0
        assert work.line() == work.plain() == ""
        with notices.compiling(four_times.py_func):
            assert work.line() == "compiling kernels (once): four_times (2 of 2), 0 of 2 functions, 12 s"
            assert work.plain() == "compiling kernels (once on this machine, about 30 s)"
            notices.compiled_part(thrice.py_func)
            assert "1 of 2 functions" in work.line()
            notices.generating()
            assert work.line() == "compiling kernels (once): four_times (2 of 2), machine code, 12 s"
        with notices.waiting():
            assert work.line() == f"{WAITING}, 12 s" and work.plain() == ""
            clock[0] += notices.PATIENCE
            assert work.plain() == WAITING
        assert work.line() == ""


CALLER = """
import math
import rules
from helpers import LIMIT, faster
from regista.kernels.jit import kernel

@kernel
def run(x):
    return min(faster(x) + rules.BONUS, LIMIT) + math.floor(later(x))

@kernel
def later(x):
    return 0.5

print(run(3), sum(run.stats.cache_hits.values()))
"""
HELPERS = """
from regista.kernels.jit import kernel

LIMIT = 100

@kernel
def faster(x):
    return 2 * x
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "old", "new", "printed"),
    [
        ("helpers.py", "2 * x", "5 * x", "16 0"),
        pytest.param("helpers.py", "LIMIT = 100", "LIMIT = 4", "4 0", marks=pytest.mark.slow),
        pytest.param("rules.py", "1", "2", "8 0", marks=pytest.mark.slow),
        pytest.param("program.py", "return 0.5", "return 1.5", "8 0", marks=pytest.mark.slow),
    ],
)
@pytest.mark.long
def test_a_kernel_of_another_project_follows_all_files_that_it_sees(folder, file, old, new, printed):
    for name, text in {"program.py": CALLER, "helpers.py": HELPERS, "rules.py": "BONUS = 1\n"}.items():
        (folder / name).write_text(text)
    assert [said(start(folder))[0] for _ in range(2)] == ["7 0", "7 1"]
    path = folder / file
    path.write_text(path.read_text().replace(old, new))
    assert [said(start(folder))[0] for _ in range(2)] == [printed, printed[:-1] + "1"]
