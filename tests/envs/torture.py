"""Matches under random and adversarial play, watched for what must never be.

    python -m tests.envs.torture MATCHES STEPS SEED

plays MATCHES matches for STEPS steps each, from line-ups of 0 to 11 a side in piles, corners, on posts and on the ball,
with players who mash keys, hold them, slide without end, run into one corner, or are the built-in AI, and with fouls
out of the blue. It prints the player-steps played, and stops at the first match that is not sane.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from regista.envs.football.constants import GK, LEFT, MAX_PLAYERS, RIGHT
from regista.envs.football.kick_off import MatchConfig, Roster, kick_off
from regista.envs.football.limits import Limits, fields_of
from regista.envs.football.simulator import step_everybody, step_matches
from regista.envs.football.state import ENGINE, MATCH, TABLES
from tests.envs.torment import COMPLAINTS, STYLES, first_complaint, prepare

LIMITED_EVERY = 50  # steps, after which every number is to be within its limits
LISTS = ("players", "agents")  # of the record


def scene(rng: np.random.Generator, seed: int) -> np.ndarray:
    """Return one match MATCH [1] about to begin from a strange position, under random settings."""
    while True:
        left, right = rng.integers(0, 12, 2)
        if left + right > 0:
            break
    teams = np.array([LEFT] * left + [RIGHT] * right)
    roles = rng.integers(0, 10, left + right)
    if rng.random() < 0.7:  # one keeper a side
        roles[roles == GK] = 5
        roles[[0] * bool(left) + [left] * bool(right)] = GK
    places, ball = strange_places(rng, left + right)
    config = MatchConfig(
        game_duration=int(rng.choice([50, 400, 3000])),
        end_episode_on_score=rng.random() < 0.2,
        end_episode_on_out_of_play=rng.random() < 0.2,
        end_episode_on_possession_change=rng.random() < 0.2,
        offsides=rng.random() < 0.5,
        second_half=int(rng.choice([30, 1500, 10**9])),
        left_team_difficulty=rng.random(),
        right_team_difficulty=rng.random(),
        use_magnet=rng.random() < 0.5,
        control=control(rng, left, np.count_nonzero(roles[:left] == GK)),
        right_control=control(rng, right, np.count_nonzero(roles[left:] == GK)),
        **(engine(rng) if rng.random() < 0.3 else {}),
    )
    return kick_off(places[None], ball[None], Roster(teams, roles), [seed], config)


def engine(rng: np.random.Generator) -> dict[str, float]:
    """Return an engine that differs from the measured one as far as programs have it differ."""
    factors = {name: float(rng.uniform(0.75, 1.25)) for name in ENGINE.names or ()}
    return factors | {"sticky_noise": float(rng.choice([0.0, 0.25])), "engine_spread": 0.0}


def control(rng: np.random.Generator, size: int, keepers: int) -> str:
    """Return whom agents of a team of this size move; mostly nobody, so that everybody else's keys are mashed, too."""
    if size == 0 or rng.random() < 0.7:
        return "none"
    modes = ["closest1", "closest2", "closest3"][:size] + ["active", "all", str(rng.integers(1, size + 1))]
    return str(rng.choice([*modes, "allNonGK"] if keepers == 1 and size > 1 else modes))


def strange_places(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw places [count, 2] and the ball's [2]: anywhere, in a pile, in a corner, on a post, the ball or the lines."""
    places = rng.uniform([-55, -36], [55, 36], (count, 2))
    ball = rng.uniform([-54, -35], [54, 35])
    kind = rng.integers(0, 7)
    if kind == 1:  # all in one place
        places[:] = rng.uniform([-55, -36], [55, 36])
    elif kind == 2:  # in a corner, the ball too
        corner = rng.choice([-1.0, 1.0], 2) * [55.0, 36.0]
        places[:], ball = corner + rng.normal(0.0, 0.5, (count, 2)), corner
    elif kind == 3:  # the ball on a post, or inside it
        ball = rng.choice([-1.0, 1.0], 2) * [55.0, 3.7] + rng.choice([0.0, 0.01, 0.17], 2)
    elif kind == 4:  # somebody, or everybody, exactly on the ball
        places[: rng.integers(1, count + 1)] = ball
    elif kind == 5:  # before the goal
        places = rng.normal([50.0, 0.0], 3.0, (count, 2))
        ball = rng.normal([50.0, 0.0], 2.0)
    elif kind == 6:  # on one line, evenly
        places[:] = np.stack([np.linspace(-50, 50, count), np.zeros(count)], axis=1)
        ball = np.zeros(2)
    return np.clip(places, [-58, -39], [58, 39]), np.clip(ball, [-55, -36], [55, 36])


def torture(count: int, steps: int, seed: int) -> int:
    """Play and return the number of player-steps; raises AssertionError at the first match that is not sane."""
    rng = np.random.default_rng(seed)
    matches = np.concatenate([scene(rng, 1000 * seed + k) for k in range(count)])
    without_agents = matches["num_agents"].sum(axis=1) == 0
    matches = matches[np.argsort(without_agents, kind="stable")].view(np.recarray)
    torment, limits = Torment(matches, rng), Limits(list(fields_of(MATCH, TABLES)), dict.fromkeys(LISTS, MAX_PLAYERS))
    for step in range(steps):
        where, wrong = torment.step()
        if step % LIMITED_EVERY == 0 or step == steps - 1:
            limits.check(matches, "matches")
        if wrong:
            match = matches[where]
            state = f"mode {match['game_mode']}, style {torment.styles[where]}, {match['num_players']} players"
            raise AssertionError(
                f"{COMPLAINTS[wrong]}: match {where} of torture({count}, {steps}, {seed}) at step {match['step']}, "
                f"{state}, ball {match['ball']}"
            )
    return steps * int(matches["num_players"].sum())


class Torment:
    """Matches MATCH [N], those with agents first, and what is needed to watch them."""

    def __init__(self, matches: np.ndarray, rng: np.random.Generator) -> None:
        count = len(matches)
        self.matches, self.starts, self.befores = matches, matches.copy(), matches.copy()
        self.with_agents = int(np.count_nonzero(matches["num_agents"].sum(axis=1)))
        self.styles, self.energies = rng.integers(0, STYLES, count), np.zeros(count)
        self.actions = np.zeros((count, matches["players"].shape[1]), np.int64)

    def step(self) -> tuple[int, int]:
        """Play a step of every match; return the first that is not sane and why, or (-1, 0)."""
        prepare(self.matches, self.starts, self.befores, self.styles, self.actions, self.energies)
        agents = self.with_agents
        step_matches(self.matches[:agents], self.actions[:agents])
        step_everybody(self.matches[agents:], self.actions[agents:])
        return first_complaint(self.matches, self.befores, self.energies)


def main(count: int, steps: int, seed: int) -> None:
    """Torture in rounds of 64 matches, and say how far it has come."""
    begun, total = time.time(), 0
    for k in range(0, count, 64):
        total += torture(min(64, count - k), steps, seed + k)
        print(f"{total:,} player-steps in {time.time() - begun:.0f} s, all sane (seed {seed + k})", flush=True)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:4]))
