"""The simulator behind the engine's calls: what it keeps from one step to the next."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from regista.envs.football import engine
from regista.envs.football.batch import step_batch
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames import MINIGAMES

FREE = MINIGAMES["1v1Free"].program


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(step_batch, "get_overload"), reason="kernels run uncompiled")
def test_types_are_looked_up_in_the_first_step_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    one, other = (FootballVectorEnv(FREE, 3) for _ in range(2))
    for env in (one, other):
        env.reset(seed=0)
    for t, actions in enumerate(np.random.default_rng(0).integers(0, 19, (60, 3))):
        other._engine = engine.Simulator(other.behaviors.code)  # which looks them up in every step
        expected = other.step(actions)
        with monkeypatch.context() as patch:
            if t > 0:
                patch.setattr(engine, "step_batch", None)
            step = one.step(actions)
        assert all((a == b).all() for a, b in zip(step[:4], expected[:4], strict=True))


def test_a_simulator_that_has_stepped_can_be_sent_to_another_process() -> None:
    env = FootballVectorEnv(FREE, 1)
    env.reset(seed=0)
    env.step(np.zeros(1, np.int64))
    env._engine = pickle.loads(pickle.dumps(env._engine))
    env.step(np.zeros(1, np.int64))
