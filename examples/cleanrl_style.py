"""Robust PLR with your own trainer: PPO in one file, in the style of CleanRL, on CartPole levels of a curriculum.

    python examples/cleanrl_style.py --env-steps 200000

The four lines that connect the curriculum to the training loop are marked (1) to (4).
"""

import argparse

import gymnasium as gym
import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical

from ued import BufferConfig, GymUPOMDP, PLRConfig
from ued.methods.plr import PLRCurriculum

N, T, GAMMA, LAMBDA, CLIP = 16, 128, 0.99, 0.95, 0.2


def set_pole(env, values):
    env.unwrapped.length, env.unwrapped.gravity = values["length"], values["gravity"]


parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--env-steps", type=int, default=200_000)
updates = max(parser.parse_args().env_steps // (T * N), 1)
torch.manual_seed(0)
envs = GymUPOMDP(lambda: gym.make("CartPole-v1"), set_pole, {"length": (0.1, 2.0), "gravity": (5.0, 30.0)}, N)
envs.reset(seed=0)
curriculum = PLRCurriculum(envs, PLRConfig(score="max_mc", buffer=BufferConfig(capacity=200)), seed=0, robust=True)
actor, critic = (nn.Sequential(nn.Linear(4, 64), nn.Tanh(), nn.Linear(64, k)) for k in (2, 1))
optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters()], 2.5e-3)

records = curriculum.propose(N)  # (1) the first levels
obs, _ = envs.reset_to_levels(records["level"])
visits = 0  # count of resets, since each visit of a level has its own random seed
steps, total_return, total_value, returns = np.zeros(N), np.zeros(N), np.zeros(N), []
for update in range(1, updates + 1):
    data = {name: torch.zeros(T, N) for name in ("action", "log_prob", "value", "reward", "done", "train")}
    data["obs"], finished = torch.zeros(T, N, 4), []
    for t in range(T):
        data["obs"][t] = torch.as_tensor(obs)
        with torch.no_grad():
            policy, data["value"][t] = Categorical(logits=actor(data["obs"][t])), critic(data["obs"][t])[:, 0]
            data["action"][t] = action = policy.sample()
            data["log_prob"][t] = policy.log_prob(action)
        data["train"][t] = torch.as_tensor(records["train"])  # (2) robust PLR trains on replayed levels only
        obs, reward, terminated, truncated, _ = envs.advance(action.numpy())
        done = terminated | truncated
        data["reward"][t], data["done"][t] = torch.as_tensor(reward), torch.as_tensor(done)
        steps, total_return, total_value = steps + 1, total_return + reward, total_value + data["value"][t].numpy()
        if done.any():  # (3) record the results of finished levels, and reset to the next levels
            records["returns"][done, 0, 0], records["mean_value"][done, 0, 0] = (
                total_return[done],
                (total_value / steps)[done],
            )
            finished.append(records[done])
            steps[done], total_return[done], total_value[done] = 0, 0, 0
            records[done] = curriculum.propose(int(done.sum()))
            visits += 1
            obs, _ = envs.reset_to_levels(records["level"][done], done, visits)
    if finished:
        curriculum.update(np.concatenate(finished))  # (4) the levels are scored
        returns += np.concatenate(finished)["returns"].ravel().tolist()
    advantage, running, next_value = torch.zeros(T, N), torch.zeros(N), critic(torch.as_tensor(obs))[:, 0].detach()
    for t in reversed(range(T)):
        going = 1 - data["done"][t]
        delta = data["reward"][t] + GAMMA * next_value * going - data["value"][t]
        advantage[t] = running = delta + GAMMA * LAMBDA * going * running
        next_value = data["value"][t]
    data |= {"advantage": advantage, "target": advantage + data["value"]}
    rows = data["train"].flatten().nonzero()[:, 0]
    for chosen in (c for _ in range(4) for c in rows[torch.randperm(len(rows))].split(512) if len(c)):  # PPO
        batch = {name: value.flatten(0, 1)[chosen] for name, value in data.items()}
        policy = Categorical(logits=actor(batch["obs"]))
        ratio = (policy.log_prob(batch["action"]) - batch["log_prob"]).exp()
        a = (batch["advantage"] - batch["advantage"].mean()) / (batch["advantage"].std(correction=0) + 1e-8)
        loss = -torch.min(a * ratio, a * ratio.clamp(1 - CLIP, 1 + CLIP)).mean() - 0.01 * policy.entropy().mean()
        loss += 0.5 * ((critic(batch["obs"])[:, 0] - batch["target"]) ** 2).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    mean, filled = np.mean(returns[-100:] or [np.nan]), curriculum.buffer.fill_ratio
    print(f"{update * T * N:8d} steps  mean return {mean:6.1f}  buffer {filled:4.0%}", flush=True)
