"""A probe world in the place of football, so that the command line is tested in seconds; engines to compare with."""

from pathlib import Path

import pytest

from regista.envs.football.task import ShootPolicy
from regista.experiments.commands.train import train
from regista.experiments.run import build, games
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch import workers
from tests.envs.grf.fixtures import fake_python, real_python
from tests.experiments.probe import ProbeMethod, ProbePainter, ProbeUPOMDP
from tests.leftovers import nobody_left
from ued.core.baselines import UniformPolicy
from ued.core.task import Task

__all__ = ["nobody_left"]


@pytest.fixture(autouse=True)
def undrawn(request, monkeypatch):
    """Leave pictures empty but in tests marked `drawn`: drawing is most of the time of a short run."""
    if "drawn" in request.keywords:
        return
    from matplotlib.figure import Figure

    monkeypatch.setattr(Figure, "savefig", lambda self, drawn, **_: None)
    monkeypatch.setattr(Figure, "tight_layout", lambda self, **_: None)


@pytest.fixture
def probe(monkeypatch):
    """Let every game of football be a task of probes, with the game's names of test scenes."""

    def task(self, config, env=None):
        tests, held_out = (
            {name: ProbeUPOMDP for name, _ in scenes} for scenes in (self.minigame.tests, self.minigame.held_out)
        )
        baselines = {
            "shoot": lambda upomdp: ShootPolicy(()),
            "random": lambda upomdp: UniformPolicy(upomdp.agent_action_space),
        }
        painter = lambda upomdp: ProbePainter()  # noqa: E731
        return Task(ProbeUPOMDP, tests, painter, held_out, baselines, success_word="goals")

    monkeypatch.setattr(games.FootballGame, "task", task)
    monkeypatch.setattr(build, "make_method", lambda config, upomdp: ProbeMethod(config, upomdp))
    return Path


@pytest.fixture
def trained_here(monkeypatch):
    """Let comparisons train in this process: no probe is seen from another, and every other imports torch anew."""

    def train_all(runs, most, stop, launcher, over):
        for run in runs:
            train(RunFolder.open(run.path), stop)
            run.picture.touch()
            over(run)

    monkeypatch.setattr(workers, "train_all", train_all)


@pytest.fixture
def begun(monkeypatch):
    """Let studies train in this process; return the names of the folders of the runs that were begun, as they are."""
    names = []

    def train_all(runs, most, stop, launcher, over):
        for run in runs:
            names.append(run.path.name)
            if train(RunFolder.open(run.path), stop) >= run.config.total_env_steps:
                over(run)

    monkeypatch.setattr(workers, "train_all", train_all)
    return names


@pytest.fixture(params=["ours twice", "stand-in", "real"])
def engine(request, tmp_path):
    """Return flags of a second engine."""
    if request.param == "ours twice":
        return ["--engine", "regista"]
    python = real_python() if request.param == "real" else str(fake_python(tmp_path))
    return ["--grf-python", python, "--grf-workers", "1"]
