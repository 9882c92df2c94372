"""How often does a lone back take the ball off a carrier who sprints or runs straight at goal, in both engines?

The carrier starts just behind a resting ball; the back stands 3 to 10 m in front and up to 3 m aside, drawn for every
episode. Both engines play the same scenes, with independent random numbers. These scenes test the odds of a built-in
player's standing tackle (`TACKLE` of `envs/football/skills/tackles.py`). GRF must be installed (`make grf`):

    python -m lab.calibration.lone_back --scenes 400 --seed 4
"""

from __future__ import annotations

import argparse
from contextlib import closing
from dataclasses import replace

import numpy as np

from lab.grf.differential import OURS
from regista.envs.football.constants import DIRECTION_RIGHT, IDLE, SPRINT
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.transfer.episodes import Episodes, play_keys
from ued.core.level_space import level_dtype

STEPS, LOOKED_AT = 40, (15, 25, 40)
WORKERS = 16  # GRF engines in parallel
PROGRAM = """
param game_duration = 401
param offsides = False
param right_team_difficulty = {difficulty}
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
x = Range(5, 50)
y = Range(-20, 20)
ahead = Range(5.45, 18.18)
aside = Range(-3.57, 3.57)
ego = LeftGK at -101 @ 0, with allowCollisions True, with regionContainedIn everywhere
LeftCF at (x - 2) @ y, with allowCollisions True
RightGK at 101 @ 0, with allowCollisions True, with regionContainedIn everywhere
RightCB at (x + ahead) @ (y + aside), with allowCollisions True
Ball at x @ y, with allowCollisions True
"""


def keys(seed: int, count: int, sprints: bool) -> np.ndarray:
    """Return the carrier's actions `[count, STEPS]`: a direction for one or two steps, then perhaps sprint."""
    rng = np.random.default_rng(seed)
    pressed = np.full((count, STEPS), IDLE)
    for row in pressed:
        first = int(rng.integers(1, 3))
        row[:first] = DIRECTION_RIGHT
        if sprints:
            row[first] = SPRINT
    return pressed


def play(engine: str, difficulty: float, seed: int, count: int, sprints: bool) -> Episodes:
    """Play `count` drawn scenes, one episode each."""
    program, config = PROGRAM.format(difficulty=difficulty), replace(OURS, engine=engine)
    with closing(FootballVectorEnv(program, min(count, WORKERS), config=config)) as env:
        levels = np.zeros(count, level_dtype(env.theta_dim))
        levels["theta"] = np.random.default_rng([seed, 7]).uniform(-1.0, 1.0, (count, env.theta_dim))
        levels["seed"] = np.arange(count) + seed * 100_000
        return play_keys(env, keys(seed, count, sprints), levels)


def line(engine: str, episodes: Episodes) -> str:
    """Return the shares of episodes in which the back gets the ball, with 95% intervals."""
    lost = episodes.endings() == "possession"
    shares = [float(np.mean(lost & (episodes.lengths <= step))) for step in LOOKED_AT]
    errors = [1.96 * np.sqrt(share * (1.0 - share) / len(episodes)) for share in shares]
    told = ", ".join(
        f"{step} steps {share:.3f} ± {error:.3f}" for step, share, error in zip(LOOKED_AT, shares, errors, strict=True)
    )
    return f"{engine:8s} {told}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--difficulties", type=float, nargs="+", default=[1.0, 0.6, 0.05])
    parser.add_argument("--engines", nargs="+", default=["regista", "grf"])
    parser.add_argument("--runs", action="store_true", help="the carrier runs instead of sprinting")
    args = parser.parse_args()
    for difficulty in args.difficulties:
        print(f"difficulty {difficulty}, {args.scenes} scenes of seed {args.seed}: the back has the ball within")
        for engine in args.engines:
            print(line(engine, play(engine, difficulty, args.seed, args.scenes, not args.runs)), flush=True)


if __name__ == "__main__":
    main()
