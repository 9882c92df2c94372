"""Stock clients take a batch of ours as it is: Gymnasium's wrappers, Stable-Baselines3, TorchRL, CleanRL's loop."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.vector import AutoresetMode

from ued import GymUPOMDP
from ued.probes import Frontier


def put(env, values):
    env.unwrapped.length = values["length"]


def cartpole(num_envs=4):
    return GymUPOMDP(
        lambda: gymnasium.make("CartPole-v1", render_mode="rgb_array"), put, {"length": (0.2, 2)}, num_envs
    )


def pendulum():
    def gravity(env, values):
        env.unwrapped.g = values["gravity"]

    return GymUPOMDP(lambda: gymnasium.make("Pendulum-v1"), gravity, {"gravity": (5, 15)}, 4)


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
    env.level_sampler = env.sample_levels
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


def as_cleanrl_plays(envs, steps):
    """Make the calls that the loop of CleanRL's ppo.py makes; return the returns and lengths that it finds."""
    torch.manual_seed(0)
    envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(envs)
    assert isinstance(envs.single_action_space, gymnasium.spaces.Discrete)
    actor = torch.nn.Linear(np.array(envs.single_observation_space.shape).prod(), int(envs.single_action_space.n))
    obs = torch.zeros((steps, envs.num_envs) + envs.single_observation_space.shape)
    rewards, dones = torch.zeros(2, steps, envs.num_envs)
    next_obs, _ = envs.reset(seed=1)
    next_obs, next_done, episodes = torch.Tensor(next_obs), torch.zeros(envs.num_envs), []
    for step in range(steps):
        obs[step], dones[step] = next_obs, next_done
        action = torch.distributions.Categorical(logits=actor(next_obs)).sample()
        next_obs, reward, terminations, truncations, infos = envs.step(action.cpu().numpy())
        next_done = np.logical_or(terminations, truncations)
        rewards[step] = torch.tensor(reward).view(-1)
        next_obs, next_done = torch.Tensor(next_obs), torch.Tensor(next_done)
        if "final_info" in infos:
            ended = infos["_episode"]
            assert (ended == infos["_final_info"]).all() and (ended == next_done.numpy()).all()
            episodes += zip(infos["episode"]["r"][ended].tolist(), infos["episode"]["l"][ended].tolist(), strict=True)
    envs.close()
    assert rewards.sum() == steps * envs.num_envs and dones[1:].sum() + next_done.sum() == len(episodes)
    return episodes


def test_the_loop_of_cleanrl_finds_in_a_batch_what_it_finds_in_gymnasiums_own():
    env = cartpole()
    env.level_sampler = env.sample_levels
    same_step = {"autoreset_mode": AutoresetMode.SAME_STEP}
    for envs in (env, gymnasium.make_vec("CartPole-v1", 4, "sync", vector_kwargs=same_step)):
        episodes = as_cleanrl_plays(envs, 150)
        assert len(episodes) > 5 and all(returned == length for returned, length in episodes)


@pytest.mark.slow
@pytest.mark.parametrize("make", [cartpole, pendulum, lambda: Frontier(4, longest=3)])
def test_a_batch_is_torchrls_environment(make):
    pytest.importorskip("torchrl")
    from torchrl.envs import check_env_specs

    from ued.adapters.torchrl import TorchRLEnv

    env = TorchRLEnv(make())
    env.set_seed(0)
    check_env_specs(env)
    assert env.batch_size == (4,)


@pytest.mark.slow
def test_torchrl_sees_whole_episodes_each_on_its_level():
    pytest.importorskip("torchrl")
    from ued.adapters.torchrl import TorchRLEnv

    env = TorchRLEnv(Frontier(4, longest=3))
    env.set_seed(0)
    played = env.rollout(40, break_when_any_done=False)
    length, place = env.upomdp.length, played["observation"][..., :3].argmax(-1)
    done, theta = played["next", "done"][..., 0], played["theta"]
    steps = torch.as_tensor(length(theta.flatten(0, 1).numpy())).view(4, 40)
    assert (done == (place + 1 == steps)).all() and 40 < done.sum() < 160  # a path ends where its level says
    assert (place[:, 1:][done[:, :-1]] == 0).all()  # and the next one begins at its start
    assert (theta == played["next", "theta"]).all()
    assert (theta[:, 1:][done[:, :-1]] != theta[:, :-1][done[:, :-1]]).all()  # on another level
    last = played["next", "observation"][..., -1]
    torch.testing.assert_close(last * 3, steps.float())  # the last observation is of the episode that ended


@pytest.mark.slow
def test_torchrl_resets_some_environments_and_plays_no_team():
    pytest.importorskip("torchrl")
    from test_team import Roles

    from ued.adapters.torchrl import TorchRLEnv

    env = TorchRLEnv(Frontier(4, longest=3, blocked_above=1.0))
    env.set_seed(0)
    begun, some = env.reset(), torch.tensor([[True], [False], [True], [False]])
    before = begun["theta"].clone()
    after = env.reset(begun.set("_reset", some))["theta"]
    assert ((before != after).all(1, keepdim=True) == some).all()
    with pytest.raises(ValueError, match="supports one agent, the environments have 3"):
        TorchRLEnv(Roles(4))


@pytest.mark.slow
def test_stable_baselines_trains_on_a_batch():
    pytest.importorskip("stable_baselines3")
    from stable_baselines3 import PPO

    from ued.adapters.sb3 import SB3VecEnv

    env = cartpole()
    theta = env.levels["theta"].copy()
    model = PPO("MlpPolicy", SB3VecEnv(env), n_steps=64, batch_size=64, n_epochs=1, seed=0).learn(512)
    assert model.num_timesteps == 512 and len(model.ep_info_buffer) > 5
    assert (env.levels["theta"] != theta).all()


def test_stable_baselines_is_told_of_the_end_of_an_episode():
    pytest.importorskip("stable_baselines3")
    from ued.adapters.sb3 import SB3VecEnv

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


@pytest.mark.long
def test_pools_of_threads_wait_passively_if_ued_comes_before_torch():
    asked = "import os, ued; from ued import PPO; print(os.environ.get('OMP_WAIT_POLICY'))"
    found = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, env={"PATH": ""}, check=True)
    assert found.stdout.strip() == "passive"
