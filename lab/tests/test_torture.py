"""The torture suite counts its attempts, continues after a stop, and reports harm."""

import json
import multiprocessing
import os
import shutil
import signal
import time
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import pytest

from lab.torture import __main__ as suite
from lab.torture import faults
from lab.torture.worker import Worker


def run_suite(monkeypatch, path, attack):
    """Run a suite of one part for three rounds with the clock of a test."""
    monkeypatch.setattr(suite, "PARTS", {"code": suite.Part("numbers", 20, attack)})
    monkeypatch.setattr(suite, "LIFE", path / "life.json")
    monkeypatch.setattr(suite, "time", SimpleNamespace(monotonic=iter(range(100)).__next__))
    return suite.main(["--report", str(path / "report.json"), "--minutes", "0.1"])


def test_a_suite_goes_on_with_the_seeds_that_follow(tmp_path, monkeypatch, capsys):
    def attack(count, seed, folder):
        return {"refused": count, f"of seed {seed}": 0}

    assert run_suite(monkeypatch, tmp_path, attack) == 0
    name = "code" + suite.CHECKED
    first = json.loads((tmp_path / "report.json").read_text())[name]["rounds"]
    assert run_suite(monkeypatch, tmp_path, attack) == 0
    row = json.loads((tmp_path / "report.json").read_text())[name]
    seeds = {f"of seed {seed}": 0 for seed in range(row["rounds"])}
    assert row["counts"] == {"refused": 20 * len(seeds)} | seeds and len(seeds) > first > 0
    assert f"| {20 * len(seeds)} | {20 * len(seeds)} refused | 0 | 0 |" in capsys.readouterr().out


@pytest.mark.parametrize("crash", [False, True])
def test_harm_is_told_and_ends_no_suite(tmp_path, monkeypatch, capsys, crash):
    def attack(count, seed, folder):
        if crash:
            os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError("written beside the registers")

    assert run_suite(monkeypatch, tmp_path, attack) == 1
    told = "the process ended with exit code -9" if crash else "written beside the registers"
    name = "code" + suite.CHECKED
    assert (
        capsys.readouterr().err.count(f": {told}")
        == json.loads((tmp_path / "report.json").read_text())[name]["rounds"]
        > 1
    )
    assert suite.main(["--report", str(tmp_path / "report.json"), "--mended", name]) == 0


@pytest.mark.slow
@pytest.mark.parametrize("at_work", [False, True])
def test_the_worker_of_a_suite_that_was_killed_ends(tmp_path, at_work):
    """The worker ends whether it was waiting for the next round or in the middle of one."""

    def attack(name, seed):
        (tmp_path / "worker").write_text(str(os.getpid()))
        time.sleep(0.5 * seed)
        return {}

    def run_suite():
        worker = Worker(attack)
        worker.do("code", 0)
        (tmp_path / "ready").touch()
        worker.do("code", 1) if at_work else time.sleep(60)

    suite = multiprocessing.get_context("fork").Process(target=run_suite)
    suite.start()
    soon(lambda: (tmp_path / "ready").exists())
    suite.kill()
    suite.join()
    worker = int((tmp_path / "worker").read_text())
    try:
        soon(lambda: not Path(f"/proc/{worker}").exists())
    finally:
        with suppress(ProcessLookupError):
            os.kill(worker, signal.SIGKILL)


def soon(happened):
    """Wait until `happened` returns true."""
    late = time.monotonic() + 20.0
    while not happened():
        assert time.monotonic() < late
        time.sleep(0.02)


def test_reports_that_ran_beside_each_other_are_added(tmp_path, monkeypatch):
    def written(name, **rows):
        full = {
            part: {"unit": part, "rounds": 1, "seconds": 1.0, "counts": {"ran": n}, "harm": h}
            for part, (n, h) in rows.items()
        }
        (tmp_path / name).write_text(json.dumps(full))
        return str(tmp_path / name)

    monkeypatch.setattr(suite, "LIFE", tmp_path / "life.json")
    written("life.json", code=(10, ["old"]))
    one, two = written("one.json", code=(15, ["old", "new"])), written("two.json", code=(13, ["old"]), kills=(4, []))
    assert suite.main(["--report", str(tmp_path / "all.json"), "--merge", one, two]) == 1
    merged = json.loads((tmp_path / "all.json").read_text())
    assert merged["code"]["counts"] == {"ran": 18} and merged["code"]["harm"] == ["old", "new"]
    assert merged["kills"]["counts"] == {"ran": 4} and merged["kills"]["rounds"] == 1


def test_the_page_quotes_the_report():
    assert suite.table(json.loads(suite.LIFE.read_text())) in suite.PAGE.read_text()


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="the faults are a library in C")
@pytest.mark.long
def test_a_full_disk_an_io_error_and_a_kill_leave_a_run_that_goes_on(tmp_path):
    target = faults.attacked("train plr", tmp_path)
    changes = target.undisturbed.changes
    assert changes > 40 and set(target.tables) == {"metrics.csv", "levels.csv"}
    covered = {faults.fault(number, [changes]) for number in range(4 * changes)}
    assert len(covered) == 4 * changes
    outcomes = [target.attempt(at=changes // 2 + k, kind=kind)[0] for k, kind in enumerate(faults.KINDS)]
    assert set(outcomes) <= {"went on", "went on after it"} and "went on after it" in outcomes
    target.forks.close()
