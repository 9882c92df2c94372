"""Robust PLR with a trainer of one's own: PPO in one file, in the style of CleanRL, on poles of a teacher's choice.

    python examples/cleanrl_style.py --env-steps 200000

What the curriculum needs from the loop is marked (1) to (4).
"""

import argparse

import gymnasium as gym
import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical

from ued import BufferConfig, GymUPOMDP, PLRConfig
from ued.methods.plr import PLRLevels

N, T, GAMMA, LAMBDA, CLIP = 16, 128, 0.99, 0.95, 0.2


def set_pole(env, values):
    env.unwrapped.length, env.unwrapped.gravity = values["length"], values["gravity"]


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--env-steps", type=int, default=200_000)
steps_wanted = parser.parse_args().env_steps
torch.manual_seed(0)
envs = GymUPOMDP(lambda: gym.make("CartPole-v1"), set_pole, {"length": (0.1, 2.0), "gravity": (5.0, 30.0)}, N)
envs.reset(seed=0)
config = PLRConfig(score="positive_value_loss", buffer=BufferConfig(capacity=200))
curriculum = PLRLevels(envs, config, seed=0, robust=True)
actor, critic = (nn.Sequential(nn.Linear(4, 64), nn.Tanh(), nn.Linear(64, k)) for k in (2, 1))
optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters()], 2.5e-3)

trials = curriculum.propose(N)  # (1) levels to begin with
obs, _ = envs.reset_to_levels(trials["level"])
open_returns, env_steps, returns = np.zeros(N), 0, []
while env_steps < steps_wanted:
    data = {name: torch.zeros(T, N) for name in ("action", "log_prob", "value", "reward", "done", "train")}
    data["obs"] = torch.zeros(T, N, 4)
    ended = []  # (step, environment, its trial)
    for t in range(T):
        data["obs"][t] = torch.as_tensor(obs)
        with torch.no_grad():
            policy = Categorical(logits=actor(data["obs"][t]))
            data["action"][t], data["value"][t] = action, _ = policy.sample(), critic(data["obs"][t])[:, 0]
            data["log_prob"][t] = policy.log_prob(action)
        data["train"][t] = torch.as_tensor(trials["train"])  # (2) robust PLR learns from replayed levels alone
        obs, reward, terminated, truncated, _ = envs.step(action.numpy())
        done = terminated | truncated
        data["reward"][t], data["done"][t] = torch.as_tensor(reward), torch.as_tensor(done)
        open_returns += reward
        if done.any():  # (3) the next levels for the environments that are through
            trials["returns"][done, 0, 0] = open_returns[done]
            ended += [(t, int(n), trials[n].copy()) for n in np.flatnonzero(done)]
            returns += open_returns[done].tolist()
            open_returns[done] = 0
            trials[done] = curriculum.propose(int(done.sum()))
            obs, _ = envs.reset_to_levels(trials["level"][done], done)
    env_steps += T * N
    with torch.no_grad():  # advantages
        advantage, running = torch.zeros(T, N), torch.zeros(N)
        next_value = critic(torch.as_tensor(obs))[:, 0]
        for t in reversed(range(T)):
            going = 1 - data["done"][t]
            delta = data["reward"][t] + GAMMA * next_value * going - data["value"][t]
            advantage[t] = running = delta + GAMMA * LAMBDA * going * running
            next_value = data["value"][t]
    for t, n, trial in ended:  # (4) what came of the levels, and how wrong the critic was
        start = int(data["done"][:t, n].nonzero()[-1]) + 1 if data["done"][:t, n].any() else 0
        trial["positive_advantage"][0, 0] = float(advantage[start : t + 1, n].clamp(min=0).mean())
    if ended:
        curriculum.update(np.array([trial for _, _, trial in ended]))
    rows = data["train"].flatten().nonzero()[:, 0]
    flat = {name: value.flatten(0, 1) for name, value in data.items()}
    targets = (advantage + data["value"]).flatten()
    for _ in range(4 if len(rows) else 0):  # PPO
        for batch in rows[torch.randperm(len(rows))].split(512):
            policy = Categorical(logits=actor(flat["obs"][batch]))
            ratio = (policy.log_prob(flat["action"][batch]) - flat["log_prob"][batch]).exp()
            a = advantage.flatten()[batch]
            a = (a - a.mean()) / (a.std() + 1e-8)
            loss = -torch.min(a * ratio, a * ratio.clamp(1 - CLIP, 1 + CLIP)).mean()
            loss += 0.5 * ((critic(flat["obs"][batch])[:, 0] - targets[batch]) ** 2).mean()
            optimizer.zero_grad()
            (loss - 0.01 * policy.entropy().mean()).backward()
            optimizer.step()
    filled = f"{curriculum.buffer.fill:4.0%}"
    print(f"{env_steps:8d} steps  mean return {np.mean(returns[-100:]):6.1f}  buffer {filled}", flush=True)
