"""The maze benchmark from Python: train on random mazes, then evaluate on test mazes of other kinds and sizes.

    python examples/maze.py --method accel --env-steps 1_000_000

`regista train maze` does the same with run folders, tables and recordings; `regista list maze` describes the tests.
"""

import argparse

import ued
from regista.envs.maze.env import Mazes
from regista.envs.maze.named_mazes import TEST_MAZES


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--method", choices=list(ued.METHODS), default="accel")
    parser.add_argument("--env-steps", type=int, default=1_000_000)
    arguments = parser.parse_args()
    ppo = ued.PPOConfig(num_steps=256, gamma=0.995, num_minibatches=1, memory="gru", hidden_size=64)
    method = ued.METHODS[arguments.method].load()(Mazes(32), ppo, seed=0, env_steps=arguments.env_steps)
    while method.env_steps < arguments.env_steps:
        metrics = method.update()
        print(f"{method.env_steps} env_steps, return {metrics['return/student']:.2f}")
    for name, test in TEST_MAZES.items():
        played = ued.evaluate(method.student, test.make(16), episodes=32, seed=1)
        print(f"{name:<24}{played.success.mean():5.0%} solved")


if __name__ == "__main__":
    main()
