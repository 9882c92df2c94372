"""Students that learn from coordinates of pixels learn what they learn from images."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch

from regista import minigames
from regista.envs.football.config import FootballConfig
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.run.config import presets
from scenic_lite import load
from ued import DR, Paired
from ued.adapters.policy import load_policy, spaces_of
from ued.config import AdversaryConfig, PairedConfig
from ued.core import checkpoint
from ued.core.sparse_image import SparseImage

PPO = replace(presets()["thesis"].ppo, hidden_size=32, num_steps=32, num_minibatches=2, update_epochs=2)
UPDATES = 2


@cache
def program():
    return load(minigames.MINIGAMES["1v1Free"].program, FOOTBALL)


def football(pixels: str, representation: str = "smm_stacked") -> FootballVectorEnv:
    env = FootballVectorEnv(program(), 4, config=FootballConfig(representation, pixels=pixels))
    env.reset(seed=1)
    return env


def trained(method, pixels, config=PPO, *own):
    made = method(football(pixels), config, *own, seed=2)
    before = [weight.detach().clone() for weight in made.learners[0].student.parameters()]
    metrics = [made.update() for _ in range(UPDATES)]
    return made, before, metrics


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("settings", [{}, {"memory": "gru"}, {"shared_torso": False}])
def test_a_run_on_coordinates_is_the_run_on_images_but_for_rounding(settings):
    config = replace(PPO, **settings)
    (ours, before, metrics), (theirs, _, others) = (trained(DR, pixels, config) for pixels in ("sparse", "dense"))
    seen = ours.learners[0].rollout.observation
    assert seen.shape == (32, 4, 96, 3) and theirs.learners[0].rollout.observation.shape == (32, 4, 72, 96, 16)
    np.testing.assert_array_equal(ours.learners[0].rollout.action, theirs.learners[0].rollout.action)
    weights = [[*made.learners[0].student.parameters()] for made in (ours, theirs)]
    for first, one, other in zip(before, *weights, strict=True):
        moved = (other - first).abs().max()
        assert moved > 0 and (one - other).abs().max() < 0.01 * moved + 1e-6
    for mine, other in zip(metrics, others, strict=True):
        for name in ("student/policy_loss", "student/value_loss", "student/entropy", "student/grad_norm"):
            assert mine[name] == pytest.approx(other[name], rel=1e-3, abs=1e-6), name


@pytest.mark.long
def test_paired_on_coordinates_chooses_the_levels_that_it_chooses_on_images():
    """The adversary's context is the image itself, as in the thesis."""
    config = PairedConfig(adversary=AdversaryConfig(context="observation", hidden_size=8))
    runs = [trained(Paired, pixels, PPO, config)[0] for pixels in ("sparse", "dense")]
    ours, theirs = (made.upomdp.levels["theta"] for made in runs)
    np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=1e-5)


@pytest.mark.slow
def test_a_checkpoint_of_coordinates_plays_on_images(tmp_path):
    made, *_ = trained(DR, "sparse")
    assert isinstance(made.upomdp.agent_observation_space, SparseImage)
    state = {"method": made.state_dict(), "config": {"ppo": vars(PPO)}, "spaces": spaces_of(made.upomdp)}
    checkpoint.save(tmp_path / "checkpoint.pt", state)
    policy = load_policy(tmp_path)
    images = football("dense").observe()
    student = made.learners[0].student
    expected = student.play(football("sparse").observe(), torch.Generator(), greedy=True)
    np.testing.assert_array_equal(policy.act(images, greedy=True), expected)


@pytest.mark.slow
def test_stable_baselines_and_torchrl_see_images():
    pytest.importorskip("stable_baselines3")
    pytest.importorskip("torchrl")
    from ued.adapters.sb3 import SB3VecEnv
    from ued.adapters.torchrl import TorchRLEnv

    sparse, dense = (SB3VecEnv(football(pixels, "smm")) for pixels in ("sparse", "dense"))
    assert sparse.observation_space == dense.observation_space
    np.testing.assert_array_equal(sparse.reset(), dense.reset())
    for _ in range(40):
        (seen, _, ended, infos), (other, _, _, other_infos) = (env.step(np.full(4, 5)) for env in (sparse, dense))
        np.testing.assert_array_equal(seen, other)
        for index in np.flatnonzero(ended):
            last = (told[index]["terminal_observation"] for told in (infos, other_infos))
            np.testing.assert_array_equal(*last)
    torched = TorchRLEnv(football("sparse", "smm"))
    assert torched.observation_spec["observation"].shape == (4, 72, 96, 4)
    assert (torched.rollout(3)["observation"] > 0).any()
