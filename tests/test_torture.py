"""The torture suite counts what it does, goes on where it stopped, and tells of harm."""

import json
import shutil

import pytest

from tests.torture import __main__ as suite
from tests.torture import faults


def test_a_suite_goes_on_with_the_seeds_that_follow(tmp_path, monkeypatch, capsys):
    seeds = []

    def attack(count, seed, folder):
        seeds.append(seed)
        return {"refused": count}

    monkeypatch.setattr(suite, "PARTS", {"code": suite.Part("numbers", 20, attack)})
    monkeypatch.setattr(suite.time, "monotonic", iter(range(100)).__next__)
    words = ["--report", str(tmp_path / "report.json"), "--minutes", "0.1"]
    assert suite.main(words) == 0
    first = len(seeds)
    assert suite.main(words) == 0
    assert seeds == list(range(len(seeds))) and len(seeds) > first > 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["code" + suite.CHECKED]["counts"] == {"refused": 20 * len(seeds)}
    assert f"| numbers{suite.CHECKED} | {20 * len(seeds)} | {20 * len(seeds)} refused | 0 |" in capsys.readouterr().out


def test_harm_is_told(tmp_path, monkeypatch, capsys):
    def attack(count, seed, folder):
        raise AssertionError("written beside the registers")

    monkeypatch.setattr(suite, "PARTS", {"code": suite.Part("numbers", 20, attack)})
    monkeypatch.setattr(suite.time, "monotonic", iter(range(100)).__next__)
    assert suite.main(["--report", str(tmp_path / "report.json"), "--minutes", "0.1"]) == 1
    assert "code, round 0: written beside the registers" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("cc") is None, reason="the faults are a library in C")
def test_a_full_disk_an_io_error_and_a_kill_leave_a_run_that_goes_on(tmp_path):
    target = faults.attacked("train plr", tmp_path)
    changes = target.undisturbed.changes
    assert changes > 40 and set(target.tables) == {"metrics.csv", "levels.csv"}
    covered = {faults.fault(number, changes) for number in range(4 * changes)}
    assert len(covered) == 4 * changes
    outcomes = [target.attempt(at=changes // 2 + k, kind=kind)[0] for k, kind in enumerate(faults.KINDS)]
    assert set(outcomes) <= {"went on", "went on after it"} and "went on after it" in outcomes
    target.forks.close()
