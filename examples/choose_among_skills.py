"""Three football skills in one batch: the program is part of the level, so a curriculum chooses among skills.

    python examples/choose_among_skills.py --env-steps 300000

PLR replays the levels with the highest learning potential. Each line reports, for every skill, its share of the levels
and their success rate.
"""

import argparse

import numpy as np
import torch

from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames.suites import MINIGAMES
from ued import PLR, PLRConfig, PPOConfig
from ued.adapters.mixture import Mixture

SKILLS = ("1v1Restricted", "1v1Free", "ChoosePassing")
EVERY = 10  # updates between printed lines

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--env-steps", type=int, default=300_000)
budget = parser.parse_args().env_steps
torch.set_num_threads(1)

members = []
for name in SKILLS:
    members.append(FootballVectorEnv(MINIGAMES[name].program, num_envs=64))
    members[-1].reset(seed=0)
skills = Mixture(members, SKILLS)
method = PLR(skills, PPOConfig(), PLRConfig(score="positive_value_loss"), seed=0)
seen = []
while method.env_steps < budget:
    method.update()
    seen.append(method.last)
    if method.updates % EVERY == 0 or method.env_steps >= budget:
        program = skills.program_of(np.concatenate([levels.theta for levels in seen]))
        goal = np.concatenate([levels.returns["student"] for levels in seen]) > 0
        info = [
            f"{name} {np.mean(program == k):4.0%}, goals {goal[program == k].mean():4.0%}"
            for k, name in enumerate(SKILLS)
        ]
        print(f"{method.env_steps:8d} steps  " + "  ".join(info), flush=True)
        seen = []
