"""A method is one file and one row: here a toy one, which the command line then trains."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest

import ued
from ued.methods import METHODS, MethodRow
from ued.probes import Frontier

ROOT = Path(__file__).parent.parent.parent
FILE = """
from dataclasses import dataclass

from ued.config import setting
from ued.levels.queue import LevelQueue
from ued.methods.method import Method
from ued.methods.dr import RandomCurriculum


@dataclass(frozen=True)
class ToyConfig:
    reluctance: float = setting(0.5, "half the number of updates before anything is learned")


class Toy(Method):
    def setup(self, config, seed):
        self.config = config or ToyConfig()
        self.curriculum = RandomCurriculum(self.upomdp)
        self.queue = LevelQueue(self.curriculum, self.upomdp.num_envs)
        self.learner = self.add_learner("student", self.upomdp)

    def update(self):
        levels = self.collect_rollouts()
        metrics = {"toy/reluctance": self.config.reluctance}
        if self.updates >= 2 * self.config.reluctance:
            metrics |= self.learner.learn(self.env_steps)
        return self.report(levels, metrics)
"""
ROW = 'MethodRow("toy", "toy", "Toy", ToyConfig, "Toy", "#123456", "–", "uniform levels, reluctantly", "1")'
TRAIN = """
import sys
from toy import ToyConfig
from ued.methods import METHODS, MethodRow
METHODS["toy"] = {row}
from regista.experiments.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """Put the file on the path, and the row into the table."""
    (tmp_path / "toy.py").write_text(FILE)
    monkeypatch.syspath_prepend(tmp_path)
    from toy import ToyConfig

    monkeypatch.setitem(METHODS, "toy", eval(ROW, {"MethodRow": MethodRow, "ToyConfig": ToyConfig}))
    yield METHODS["toy"]
    sys.modules.pop("toy")


def test_a_row_is_all_that_others_need(toy):
    from ued import Toy

    assert ued.Toy is Toy is toy.load() and "ToyConfig" in ued.__all__
    method = Toy(Frontier(8, longest=4), ued.PPOConfig(num_steps=8, hidden_size=8))
    metrics = [method.update() for _ in range(3)][-1]
    assert metrics["env_steps"] == 3 * 8 * 8 and "student/policy_loss" in metrics
    resumed = Toy(Frontier(8, longest=4), method.ppo, seed=1)
    resumed.load_state_dict(method.state_dict())
    assert resumed.update()["student/policy_loss"] == method.update()["student/policy_loss"]


@pytest.mark.long
def test_the_command_line_trains_it(toy, tmp_path):
    (tmp_path / "train.py").write_text(TRAIN.format(row=ROW))
    command = [sys.executable, "train.py", "train", "1v1Restricted", "--method", "toy", "--toy.reluctance", "0.25"]
    command += ["--num-envs", "4", "--num-steps", "8", "--total-env-steps", "64", "--eval-every", "0", "--no-record"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([*command, "--out", "run"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "run" / "metrics.csv").open()))
    assert [row["env_steps"] for row in rows] == ["32", "64"] and rows[1]["toy/reluctance"] == "0.25"
