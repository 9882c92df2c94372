"""A probe world in the place of football, so that the command line is tested in seconds."""

from pathlib import Path

import pytest

from experiments.run import build
from tests.experiments.probe import ProbeMethod, ProbePainter, ProbeUPOMDP


@pytest.fixture
def probe(monkeypatch):
    """Let `build` make probes, whatever the names."""

    def make_upomdp(program, num_envs, config, seed, threads):
        upomdp = ProbeUPOMDP(num_envs)
        upomdp.reset(seed=seed)
        return upomdp

    monkeypatch.setattr(build, "make_upomdp", make_upomdp)
    monkeypatch.setattr(build, "make_method", lambda config, upomdp: ProbeMethod(config, upomdp))
    monkeypatch.setattr(build, "make_painter", lambda program, lineup=None: ProbePainter())
    return Path
