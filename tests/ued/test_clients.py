"""Stock clients take a batch of ours as it is: Gymnasium's wrappers, Stable-Baselines3, CleanRL's way of counting."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from ued import GymUPOMDP
from ued.probes import Frontier


def put(env, values):
    env.unwrapped.length = values["length"]


def cartpole(num_envs=4):
    return GymUPOMDP(
        lambda: gymnasium.make("CartPole-v1", render_mode="rgb_array"), put, {"length": (0.2, 2)}, num_envs
    )


def test_the_batch_says_how_it_resets_and_tells_the_last_info():
    env = Frontier(8, longest=3)
    assert env.autoreset_mode is env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    env.reset(seed=0)
    for _ in range(4):
        *_, terminated, truncated, info = env.step(np.zeros(8, int))
        ended = terminated | truncated
        assert ("final_info" in info) == ended.any()
        if ended.any():
            assert (info["_final_info"] == ended).all()


def test_vectors_render():
    env = cartpole(2)
    env.reset(seed=0)
    assert env.render_mode == "rgb_array" and env.metadata["render_fps"] == 50
    assert [frame.shape for frame in env.render()] == [(400, 600, 3)] * 2


def test_episodes_are_counted_as_cleanrl_counts_them():
    env = cartpole()
    env.next_levels = env.sample_levels
    counted = gymnasium.wrappers.vector.RecordEpisodeStatistics(env)
    counted.reset(seed=0)
    found, lengths, running = [], [], np.zeros(4, int)
    for _ in range(60):
        _, _, terminated, truncated, info = counted.step(np.ones(4, int))
        running += 1
        ended = terminated | truncated
        if ended.any():
            found += info["episode"]["r"][info["_episode"]].tolist()
            lengths += running[ended].tolist()
            running[ended] = 0
    assert len(found) > 10 and found == lengths


def test_stable_baselines_trains_on_a_batch():
    pytest.importorskip("stable_baselines3")
    from stable_baselines3 import PPO

    from ued.sb3 import SB3VecEnv

    env = cartpole()
    theta = env.levels["theta"].copy()
    model = PPO("MlpPolicy", SB3VecEnv(env), n_steps=64, batch_size=64, n_epochs=1, seed=0).learn(512)
    assert model.num_timesteps == 512 and len(model.ep_info_buffer) > 5
    assert (env.levels["theta"] != theta).all()


def test_stable_baselines_is_told_of_the_end_of_an_episode():
    pytest.importorskip("stable_baselines3")
    from ued.sb3 import SB3VecEnv

    env = SB3VecEnv(cartpole(2))
    env.seed(3)
    env.reset()
    for _ in range(40):
        seen, _, dones, infos = env.step(np.ones(2, int))
        for index in np.flatnonzero(dones):
            assert abs(infos[index]["terminal_observation"][2]) > 0.2 > abs(seen[index][2])
            assert infos[index]["episode"]["r"] == infos[index]["episode"]["l"]
            assert not infos[index]["TimeLimit.truncated"] and infos[index]["theta"].shape == (1,)
    assert env.get_attr("theta_dim") == [1, 1] and env.env_is_wrapped(object) == [False, False]


def test_pools_of_threads_wait_passively_if_ued_comes_before_torch():
    asked = "import os, ued; from ued import PPO; print(os.environ.get('OMP_WAIT_POLICY'))"
    found = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, env={"PATH": ""}, check=True)
    assert found.stdout.strip() == "passive"
