"""Does PLR over seeds help if the layout of a level matters? A toy environment in which it must, and a comparison.

The environment is a corridor of rooms. Resetting it draws the room in which a hidden door leads out. In each room, one
of four actions leads on, the same one in all corridors. Near doors are rare, so random corridors are mostly too long to
teach anything. PLR can replay corridors at the edge of the student's ability, but only if a replayed level is the
corridor that was scored. There are 200 seeds, the same for DR and PLR. Writes a row for each run:

    python -m lab.hidden_door --seeds 10 --csv lab/results/hidden_door.csv
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import gymnasium
import numpy as np
import torch
from gymnasium.spaces import Box, Discrete

import ued

CORRIDORS, LONGEST, ACTIONS = 200, 15, 4
RIGHT = np.random.default_rng(0).integers(0, ACTIONS, LONGEST)  # the action that leads on, room by room


class HiddenDoor(gymnasium.Env):
    """Walk to the hidden door: reward 1 at the door if all actions were right, else 0.

    The observation is the room, and whether any action was wrong.
    """

    observation_space, action_space = Box(0.0, 1.0, (LONGEST + 1,), np.float32), Discrete(ACTIONS)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.door = int(np.ceil(self.np_random.random(3).max() * LONGEST))  # rooms to walk, at least 1
        self.room, self.lost = 0, False
        return self._observe(), {}

    def step(self, action):
        self.lost |= bool(action != RIGHT[self.room])
        self.room += 1
        out = self.room == self.door
        return self._observe(), float(out and not self.lost), out, False, {}

    def _observe(self):
        seen = np.zeros(LONGEST + 1, np.float32)
        seen[min(self.room, LONGEST - 1)], seen[-1] = 1.0, self.lost
        return seen


def corridor(seed: int | None) -> int | None:
    """Return the number of a corridor, one of 200, for the seed of a level."""
    return None if seed is None else seed % CORRIDORS


def make(num_envs: int = 32) -> ued.GymUPOMDP:
    """Make corridors. Their one parameter has no effect: a level is its seed, for which `ued.Seeds` is shorter."""
    return ued.GymUPOMDP(HiddenDoor, lambda env, values: None, {"unused": (0, 1)}, num_envs, seed_episodes=corridor)


def known(method: ued.Method) -> float:
    """Return the share of rooms that a student passes with its most likely actions, up to the first failure.

    This measures learning on all 200 corridors: the student gets out of those whose door is no farther.
    """
    farthest = max(range(CORRIDORS), key=door_of)
    env = HiddenDoor()
    seen, _ = env.reset(seed=farthest)
    while not env.lost and env.room < env.door:
        seen, *_ = env.step(method.student.play(seen[None], torch.Generator(), greedy=True)[0])
    return (env.room - env.lost) / env.door


def door_of(number: int) -> int:
    """Return the distance of a corridor's door."""
    env = HiddenDoor()
    env.reset(seed=number)
    return env.door


def train(name: str, seed: int, env_steps: int) -> dict[str, object]:
    """Train a student, and return the row of the run."""
    ppo = ued.PPOConfig(num_steps=64, learning_rate=2e-3, num_minibatches=4, ent_coef=0.05)
    plr = ued.PLRConfig(buffer=ued.BufferConfig(capacity=CORRIDORS))
    method = ued.METHODS[name].load()(make(), ppo, plr if name == "plr" else None, seed=seed)
    while method.env_steps < env_steps:
        method.update()
    return {"method": name, "seed": seed, "env_steps": method.env_steps, "known": known(method)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--env-steps", type=int, default=100_000)
    parser.add_argument("--csv", type=Path, default=None)
    parser.add_argument("--version", default="", help="written into the rows")
    arguments = parser.parse_args()
    rows = []
    for seed in range(arguments.seeds):
        for name in ("dr", "plr"):
            rows.append({"version": arguments.version, **train(name, seed, arguments.env_steps)})
            print(rows[-1], flush=True)
    for column in ("known",):
        by_method = [np.array([row[column] for row in rows if row["method"] == name]) for name in ("plr", "dr")]
        difference = by_method[0] - by_method[1]  # of runs with the same seed, which begin alike
        half = 2.262 * difference.std(ddof=1) / np.sqrt(len(difference)) if len(difference) == 10 else np.nan
        print(
            f"{column}: PLR {by_method[0].mean():.3f}, DR {by_method[1].mean():.3f}, "
            f"difference {difference.mean():+.3f} [{difference.mean() - half:+.3f}, {difference.mean() + half:+.3f}]"
        )
    if arguments.csv:
        new = not arguments.csv.exists()
        with open(arguments.csv, "a", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            if new:
                writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
