"""ALP-GMM with Stable-Baselines3: the environments request levels from the curriculum, so the trainer is unchanged.

python examples/with_stable_baselines3.py --env-steps 100000
"""

import argparse

import gymnasium as gym
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv

from ued import ALPGMMConfig, ThetaSpace, UPOMDPWrapper
from ued.adapters.curriculum_wrapper import CurriculumFeed, CurriculumWrapper
from ued.methods.alp_gmm import ALPGMMCurriculum

RANGES = {"length": (0.1, 2.0), "gravity": (5.0, 30.0)}


def set_pole(env, values):
    env.unwrapped.length, env.unwrapped.gravity = values["length"], values["gravity"]


torch.set_num_threads(1)  # small networks train faster on one thread
parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--env-steps", type=int, default=100_000)
curriculum = ALPGMMCurriculum(ThetaSpace(len(RANGES)), ALPGMMConfig(fit_every=100), seed=0)
feed = CurriculumFeed(curriculum)


def make_env():
    return Monitor(CurriculumWrapper(UPOMDPWrapper(gym.make("CartPole-v1"), set_pole, RANGES), feed))


model = PPO("MlpPolicy", DummyVecEnv([make_env] * 8), n_steps=256, seed=0, device="cpu")
model.learn(parser.parse_args().env_steps)
episodes = model.ep_info_buffer
print(f"mean return of the last {len(episodes)} episodes: {sum(e['r'] for e in episodes) / len(episodes):.1f}")
print(f"the curriculum: {feed.metrics}")
