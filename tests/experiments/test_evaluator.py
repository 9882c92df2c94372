"""Which test scenes an evaluation plays side by side."""

from types import SimpleNamespace

import numpy as np
from gymnasium.spaces import Box, Discrete

from regista.experiments.run.evaluator import MOST_NUMBERS, EvalScenes
from ued.config import PPOConfig
from ued.core.baselines import UniformPolicy
from ued.core.seeding import torch_generator
from ued.learning.student import Student

STUDENT = Student(Box(0, 1, (3,), np.float32), Discrete(2), PPOConfig(hidden_size=8), torch_generator(0))


def together(policy, engine=None, size=3, scenes=("a", "b", "c")):
    def scene(name):
        return SimpleNamespace(num_envs=16, single_observation_space=Box(0, 1, (size,), np.float32), name=name)

    made = {name: scene(name) for name in {*scenes}}
    evaluation = SimpleNamespace(
        config=SimpleNamespace(engine=engine), scenes={k: made[v] for k, v in enumerate(scenes)}
    )
    return EvalScenes._together(evaluation, policy, list(evaluation.scenes))


def test_scenes_are_played_side_by_side_as_far_as_memory_allows():
    assert together(STUDENT) >= 3 and together(STUDENT, "regista") >= 3
    assert together(STUDENT, size=MOST_NUMBERS // 32) == 2
    assert together(STUDENT, size=MOST_NUMBERS) == 1


def test_scenes_that_cannot_be_played_side_by_side_are_played_one_by_one():
    assert together(UniformPolicy(Discrete(2))) == 1  # baselines may be bound to their environments
    assert together(STUDENT, "grf") == 1
    assert together(STUDENT, scenes=("a", "b", "a")) == 1  # two tests in the same environments
