"""Whoever trains the runs of a comparison: the same tables, number for number. One who trains a run is its owner."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from regista.experiments.__main__ import main
from regista.experiments.run.config import TaskTrainConfig
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch import owner
from regista.experiments.run.launch.owner import BusyError
from regista.experiments.run.launch.workers import Processes
from regista.experiments.run.table import read_rows

ROOT = Path(__file__).parents[2]
TASK = """
from ued.probes import Frontier
from ued.core.task import Task

task = Task(lambda num_envs: Frontier(num_envs, 4), tests={"open": [[0.0, 0.0, 0.0, -1.0]]})
"""
SHORT = [
    "--num-envs",
    "8",
    "--num-steps",
    "16",
    "--eval-every",
    "0",
    "--no-record",
    "--episodes",
    "30",
    "--levels",
    "0",
]
TABLES = ("results.csv", "table.csv", "table.md")


@pytest.fixture
def words(tmp_path):
    """Return what is typed, but for who trains, how long and where."""
    (tmp_path / "walk.py").write_text(TASK)
    return ["compare", f"{tmp_path / 'walk.py'}:task", "--methods", "dr", "plr", "--seeds", "2", *SHORT]


def measured(run):
    """Return all that a run has measured, but for how long it took."""
    rows = read_rows(run / "metrics.csv")
    return [{name: value for name, value in row.items() if not name.startswith("time/")} for row in rows]


def assert_same(one, other, count):
    for name in TABLES:
        assert (one / name).read_text() == (other / name).read_text()
    runs = sorted(path.name for path in one.glob("*-?"))
    assert len(runs) == count
    for run in runs:
        assert measured(one / run) == measured(other / run) and len(measured(one / run)) > 1


@pytest.mark.slow
@pytest.mark.long
def test_command_lines_make_the_tables_that_a_machine_makes(words, trained_here, tmp_path, capfd):
    words += ["--total-env-steps", "512", "--seeds", "1"]
    alone, by_lines = tmp_path / "alone", tmp_path / "by lines"
    assert main([*words, "--out", str(alone)]) == 0
    capfd.readouterr()
    by_lines = [*words, "--out", str(tmp_path / "by lines"), "--launcher", "commands"]
    assert main(by_lines) == 0
    printed = capfd.readouterr()
    assert len(printed.out.splitlines()) == 2 and "2 of 2 runs to train" in printed.err
    subprocess.run(["xargs", "-L1", "-P2", "env"], cwd=ROOT, input=printed.out, text=True, check=True)
    capfd.readouterr()
    assert main(by_lines) == 0
    assert "to train" not in capfd.readouterr().err
    assert_same(alone, tmp_path / "by lines", 2)


# ---------------------------------------------------------------- owners


@pytest.fixture
def run(tmp_path):
    return RunFolder.create(tmp_path / "run", TaskTrainConfig())


def claim(run, touched, **said):
    """Let a process of another machine be the owner, which gave a sign of life so many seconds ago."""
    path = run.path / owner.OWNER
    path.write_text(json.dumps({"host": "elsewhere", "boot": "another", "pid": 7, **said}))
    os.utime(path, (time.time() - touched,) * 2)
    return path


def test_whoever_trains_says_so_and_lets_go(run):
    with run.locked():
        said = json.loads((run.path / owner.OWNER).read_text())
        assert said["pid"] == os.getpid()
        with pytest.raises(BusyError, match="by another process"), run.locked():
            pass
    assert not list(run.path.glob("owner*"))


def test_an_owner_elsewhere_counts_while_it_gives_signs_of_life(run):
    path = claim(run, touched=owner.SILENT_SECONDS / 2)
    with pytest.raises(BusyError, match="process 7 of elsewhere, last heartbeat 30 s ago"), run.locked():
        pass
    assert json.loads(path.read_text())["pid"] == 7 and len(list(run.path.glob("owner*"))) == 1
    claim(run, touched=owner.SILENT_SECONDS + 1)
    with run.locked():
        assert json.loads(path.read_text())["pid"] == os.getpid()


def test_one_who_was_killed_on_this_machine_is_no_owner(run):
    claim(run, touched=0, boot=owner._boot())
    with run.locked():
        pass
    assert not (run.path / owner.OWNER).exists()


def test_without_locks_the_owner_decides_on_this_machine_too(run, monkeypatch):
    def refuse(file, what):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(owner.fcntl, "flock", refuse)
    claim(run, touched=1, boot=owner._boot())
    with pytest.raises(BusyError), run.locked():
        pass


def test_signs_of_life_go_on_until_the_end(run, monkeypatch):
    monkeypatch.setattr(owner, "BEAT_SECONDS", 0.01)
    with run.locked():
        path = run.path / owner.OWNER
        os.utime(path, (0, 0))
        deadline = time.monotonic() + 10
        while path.stat().st_mtime == 0 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert path.stat().st_mtime > 0


# ---------------------------------------------------------------- Ray, where it is installed


@pytest.fixture
def cluster(monkeypatch):
    """Return two nodes of one core each, in processes of their own."""
    pytest.importorskip("ray")
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    monkeypatch.setenv("RAY_worker_niceness", "0")  # else a busy machine lets them wait for minutes
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "object_store_memory": 80 * 2**20})
    yield cluster
    cluster.shutdown()


@pytest.mark.slow
def test_a_cluster_makes_the_same_tables_though_a_node_dies(words, cluster, trained_here, tmp_path):
    words += ["--total-env-steps", "4096", "--checkpoint-seconds", "0"]
    assert main([*words, "--out", str(tmp_path / "alone")]) == 0
    node, out = cluster.add_node(num_cpus=1, object_store_memory=80 * 2**20), tmp_path / "cluster"
    command = [sys.executable, "-m", "regista", *words, "--out", str(out), "--launcher", "ray"]
    environment = os.environ | {"RAY_ADDRESS": cluster.address}
    process = subprocess.Popen(command, cwd=ROOT, env=environment)
    while len(list(out.glob("*/checkpoint.pt"))) < 2 and process.poll() is None:
        time.sleep(0.1)
    cluster.remove_node(node, allow_graceful=False)
    assert process.wait() == 0
    assert_same(tmp_path / "alone", out, 4)
    assert any(log.read_text().count("steps  student") > 1 for log in out.glob("*/train.log")), "none began twice"


@pytest.mark.slow
def test_runs_of_a_cluster_save_when_they_are_asked_to_stop(words, cluster, tmp_path):
    words += ["--total-env-steps", "50_000_000", "--checkpoint-seconds", "1000", "--seeds", "1"]
    out = tmp_path / "cluster"
    command = [sys.executable, "-m", "regista", *words, "--out", str(out), "--launcher", "ray"]
    process = subprocess.Popen(command, cwd=ROOT, env=os.environ | {"RAY_ADDRESS": cluster.address})
    while not list(out.glob("*/metrics.csv")) and process.poll() is None:
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130
    (saved,) = out.glob("*/checkpoint.pt")
    assert not (saved.parent / owner.OWNER).exists()
    run = RunFolder.open(saved.parent)
    assert 0 < run.load()["env_steps"] == run.env_steps() < 50_000_000


def test_a_cluster_that_is_not_installed_is_an_extra(words, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "ray", None)
    assert main([*words, "--out", str(tmp_path / "out"), "--launcher", "ray"]) == 1
    assert "pip install 'regista[ray]'" in capsys.readouterr().err


def test_a_process_that_was_forked_does_not_keep_a_run_locked(tmp_path):
    """Workers of environments outlive a kill of the command by a moment; `--resume` may come at once."""
    (reader, writer), (heard, here) = os.pipe(), os.pipe()
    with owner.owned(tmp_path):
        child = os.fork()
        if child == 0:
            os.close(writer)
            os.write(here, b"!")
            os.read(reader, 1)  # until the other one has been seen to get the lock
            os._exit(0)
        os.read(heard, 1)  # until it runs, and has let go
        with pytest.raises(BusyError), owner.owned(tmp_path):
            pass
    try:
        with owner.owned(tmp_path):
            pass
    finally:
        os.close(writer)
        os.waitpid(child, 0)
        for end in (reader, heard, here):
            os.close(end)


def test_what_the_disk_did_not_remove_at_first_is_removed_in_the_end(tmp_path, monkeypatch):
    unlink, failures = Path.unlink, iter([OSError(errno.EIO, "broken")])

    def broken_once(self, missing_ok=False):
        if self.name.endswith(".partial") and (failure := next(failures, None)):
            raise failure
        unlink(self, missing_ok)

    monkeypatch.setattr(Path, "unlink", broken_once)
    with owner.owned(tmp_path):
        assert any(path.name.endswith(".partial") for path in tmp_path.iterdir())
    assert not list(tmp_path.iterdir())


def test_a_run_has_its_own_process_group_in_the_session_of_its_launcher(tmp_path):
    """Ctrl-C reaches the launcher alone; the priority of a session, which Linux sets by `nice`, holds for its runs."""
    job = SimpleNamespace(path=tmp_path, config=SimpleNamespace(threads=1), argv=["--version"])
    process = Processes().start(job)
    assert os.getsid(process.pid) == os.getsid(0) and os.getpgid(process.pid) == process.pid
    assert process.wait() == 0
