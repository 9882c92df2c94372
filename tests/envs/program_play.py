"""Programs of the minigames played by whoever mashes keys, watched for what must never be, and played again.

    python -m tests.envs.program_play ROUNDS SEED

A round plays one program in a batch as `FootballVectorEnv` steps it: with any control mode of both teams, observations
of any kind, a new random level for each episode, engines that differ, and actions that are drawn or those of the
program itself. Some steps are recorded and must come out the same when they are played again. Read next: `torture`,
matches from stranger places, of which every step is watched.
"""

from __future__ import annotations

import sys
import time
from functools import lru_cache
from typing import Any

import numpy as np

from regista.envs.football.config import REPRESENTATIONS, FootballConfig
from regista.envs.football.constants import NUM_ACTIONS
from regista.envs.football.replay import same
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames.suites import NAMED
from tests.envs.torment import COMPLAINTS, survey

NUM_ENVS, STEPS = 128, 600  # matches of a round, steps of each
WATCHED_EVERY = 8  # steps, of which one is watched
REPLAYED = 40  # steps at the end of a round, which are played again
HELD = 0.7  # of the actions that are the last one again
SEEN = (0.65, 0.32, 0.01, 0.01, 0.01)  # how often agents see each of REPRESENTATIONS: pictures take long
CONTROLS = ("closest1", "closest1", "closest2", "closest3", "active", "all", "allNonGK", "2", "none")


@lru_cache(maxsize=64)
def environment(game: str, config: FootballConfig) -> FootballVectorEnv:
    """Return an environment, made once. Raises ValueError for a control mode that does not fit the program."""
    return FootballVectorEnv(NAMED[game].program, NUM_ENVS, config=config)


def drawn(rng: np.random.Generator) -> tuple[str, FootballVectorEnv]:
    """Draw a program and how it is played; return what to call it, and its environment."""
    while True:
        game = str(rng.choice(list(NAMED)))
        try:
            config = FootballConfig(
                representation=str(rng.choice(REPRESENTATIONS, p=SEEN)),
                rewards=str(rng.choice(["scoring", "scoring,checkpoints"])),
                control=str(rng.choice(CONTROLS)),
                right_control=str(rng.choice(CONTROLS)) if rng.random() < 0.3 else "none",
                engine_spread=float(rng.choice([0.0, 0.15, 0.25])),
            )
            return f"{game}, {config}", environment(game, config)
        except ValueError:
            continue  # a team without that many players, or no agent at all


def actions_of(rng: np.random.Generator, steps: int, shape: tuple[int, ...]) -> np.ndarray:
    """Draw actions [steps, *shape], of which most are held for some steps."""
    actions = rng.integers(0, NUM_ACTIONS, (steps, *shape))
    held = rng.random(actions.shape) < HELD
    for step in range(1, steps):
        actions[step][held[step]] = actions[step - 1][held[step]]
    return actions


def play(seed: int) -> int:
    """Play a round; return its player-steps. Raises AssertionError at the first match that is not sane."""
    rng = np.random.default_rng(seed)
    called, env = drawn(rng)
    env.scripted = rng.random() < 0.2
    env.level_sampler = env.sample_levels if rng.random() < 0.8 else None
    env.idle[:] = False
    env.reset(seed=seed)
    actions = actions_of(rng, STEPS, env.action_space.shape or ())
    for step in range(STEPS - REPLAYED):
        watched = step % WATCHED_EVERY == 0
        before = env.matches if watched else None
        env.step(actions[step])
        if watched:
            watch(env, before, f"{called}, step {step} of play({seed})")
    env.level_sampler = None
    states = []
    state = env.get_state()
    for _ in range(2):
        env.set_state(state)
        for action in actions[-REPLAYED:]:
            env.step(action)
        states.append(env.matches)
    assert same(*states), f"{called}: played twice, the last steps of play({seed}) came out differently"
    return (STEPS + REPLAYED) * NUM_ENVS * env.num_players


def watch(env: FootballVectorEnv, before: Any, where: str) -> None:
    """Raise AssertionError unless matches MATCH [N] are sane, a step after `before`."""
    matches = env.matches
    env._limits["matches"].check(matches, "matches")
    index, wrong = survey(matches, before)
    assert not wrong, f"{COMPLAINTS[wrong]}: match {index} of {where}: ball {matches['ball'][index]}"


def main(rounds: int, seed: int) -> None:
    """Play rounds, and say how far it has come."""
    begun, total = time.process_time(), 0
    for k in range(rounds):
        total += play(seed + k)
        print(f"{total:,} player-steps in {time.process_time() - begun:.0f} s, all sane (seed {seed + k})", flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:3]))
