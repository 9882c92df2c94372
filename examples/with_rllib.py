"""Domain randomization with RLlib's PPO: each episode plays a new random level.

    pip install 'ray[rllib]' torch
    python examples/with_rllib.py --env-steps 100000

RLlib takes single environments and batches them itself. `UPOMDPWrapper` samples a level at each reset;
`CurriculumWrapper` takes levels from a curriculum instead, as in `with_stable_baselines3.py`.
"""

import argparse

import gymnasium
from ray.rllib.algorithms.ppo import PPOConfig
from ray.tune.registry import register_env

from ued import UPOMDPWrapper

RANGES = {"length": (0.1, 2.0), "gravity": (5.0, 30.0)}


def set_pole(env, values):
    env.unwrapped.length, env.unwrapped.gravity = values["length"], values["gravity"]


def make_env(config):
    return UPOMDPWrapper(gymnasium.make("CartPole-v1"), set_pole, RANGES)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env-steps", type=int, default=100_000)
    arguments = parser.parse_args()
    register_env("poles", make_env)
    settings = PPOConfig().environment("poles").env_runners(num_env_runners=0, num_envs_per_env_runner=8)
    settings = settings.training(train_batch_size_per_learner=2048, minibatch_size=256, num_epochs=4, lr=3e-4)
    algorithm, env_steps = settings.debugging(seed=0, log_level="ERROR").build_algo(), 0
    while env_steps < arguments.env_steps:
        result = algorithm.train()["env_runners"]
        env_steps = int(result["num_env_steps_sampled_lifetime"])
        print(f"{env_steps} env_steps, mean return {result['episode_return_mean']:.1f}")
    algorithm.stop()


if __name__ == "__main__":
    main()
