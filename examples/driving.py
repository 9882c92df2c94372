"""A Scenic 3 program as a task for any method: follow a car that will brake, and stop behind it.

    regista inspect examples/driving.scenic --engine scenic3 --mode-2d     # its random parameters
    regista train examples/driving.py:driving --method plr --num-envs 4
    regista train examples/driving.py:driving --method paired --num-envs 4

It requires `pip install 'regista[scenic3]'`. The program `driving.scenic` defines the traffic; `Driver` defines the
agent's observations, actions and rewards. Run as a script, this file trains PLR and evaluates the policy.
"""

import argparse
from pathlib import Path

import numpy as np
from gymnasium.spaces import Box, Discrete

import ued
from regista.envs.scenic3 import Role, ScenicProgram, ScenicUPOMDP

PROGRAM = Path(__file__).with_name("driving.scenic")
PEDALS = ((0.0, 1.0), (0.0, 0.3), (0.0, 0.0), (0.5, 0.0))  # throttle and brake of each action


class Driver(Role):
    """Observes the gap and both speeds; must stop close behind the other car, quickly and without a crash."""

    observation_space = Box(-np.inf, np.inf, (3,), np.float32)
    action_space = Discrete(len(PEDALS))
    max_steps = 150  # steps of 0.1 s

    def observe(self, simulation):
        ego, lead = simulation.objects
        gap = lead.position.x - ego.position.x - ego.length
        return np.array([gap / 30, ego.speed / 12, lead.speed / 12], np.float32)

    def act(self, action, simulation):
        from scenic.domains.driving.actions import SetBrakeAction, SetThrottleAction

        throttle, brake = PEDALS[action]
        return SetThrottleAction(throttle), SetBrakeAction(brake)

    def judge(self, simulation):
        gap, speed, other = self.observe(simulation)
        crashed = gap < 0
        arrived = not crashed and gap * 30 < 8 and max(speed, other) * 12 < 0.5
        return 10.0 * arrived - 10.0 * crashed - 0.02, crashed or arrived, bool(arrived)


def make(num_envs: int) -> ScenicUPOMDP:
    """Make training environments, each in its own process."""
    return ScenicUPOMDP(ScenicProgram(PROGRAM, mode_2d=True), Driver(), num_envs)


driving = ued.Task(
    make,
    tests={
        "gentle": {"speed": 8.0, "gap": 20.0, "pace": 8.0, "after": 3.0, "force": 0.3},
        "sudden": {"speed": 10.0, "gap": 10.0, "pace": 8.0, "after": 0.5, "force": 1.0},
    },
)


def main() -> None:
    import regista

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--env-steps", type=int, default=40_000)
    parser.add_argument("--out", type=Path, default=Path("runs/driving-plr-0"))
    arguments = parser.parse_args()
    settings = {"num_envs": 4, "eval_every": 0, "record": False}
    run = regista.train(driving, method="plr", out=arguments.out, total_env_steps=arguments.env_steps, **settings)
    print(regista.evaluate(run, episodes=8, levels=0).text())


if __name__ == "__main__":
    main()
