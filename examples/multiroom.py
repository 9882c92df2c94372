"""PLR over seeds, as in Procgen, on MiniGrid: 200 mazes of two rooms, each defined by a seed.

    pip install minigrid
    python examples/multiroom.py --method plr

`reset(seed=)` generates the rooms. `Seeds(200)` is a level space of 200 seeds: every episode of a level has the same
rooms, so PLR replays the levels that it scored. The test uses other seeds.
"""

import argparse

import gymnasium

import ued

TRAINING, TEST = ued.Seeds(200), ued.Seeds(1000, first=10_000)


def room() -> gymnasium.Env:
    """Make one environment that observes only the image: the mission text has no fixed size."""
    from minigrid.wrappers import ImgObsWrapper

    return ImgObsWrapper(gymnasium.make("MiniGrid-MultiRoom-N2-S4-v0"))


def make(num_envs: int = 16) -> ued.GymUPOMDP:
    """Make training environments."""
    return ued.GymUPOMDP(room, None, TRAINING, num_envs)


def make_new(num_envs: int = 16) -> ued.GymUPOMDP:
    """Make test environments with unseen seeds."""
    return ued.GymUPOMDP(room, None, TEST, num_envs)


rooms = ued.Task(make, tests={"new rooms": make_new})  # regista compare examples/multiroom.py:rooms --methods dr plr


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--method", choices=["dr", "plr", "robust_plr"], default="plr")
    parser.add_argument("--env-steps", type=int, default=200_000)
    arguments = parser.parse_args()
    settings = ued.PLRConfig(buffer=ued.BufferConfig(capacity=200)) if arguments.method != "dr" else None
    method = ued.METHODS[arguments.method].load()(make(), ued.PPOConfig(num_steps=128), settings, seed=0)
    while method.env_steps < arguments.env_steps:
        metrics = method.update()
        print(f"{method.env_steps} env_steps, return {metrics['return/student']:.2f}")
    tested = ued.evaluate(method.student, make_new(), episodes=100, seed=0)
    print(f"new rooms: {100 * tested.success.mean():.0f}% of 100 solved")


if __name__ == "__main__":
    main()
