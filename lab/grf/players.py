"""Whole matches of three scripted players against the built-in team, in our simulator and in GRF.

The agent is `active`: the player of the left team with the ball, or nearest to it; the built-in AI moves the others. A
straight runner heads for goal and shoots; a dodger turns away from opponents in front; a passer passes forward to a
free teammate when an opponent is near. Read next: `grf.matches`, in which the built-in AI plays both sides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lab.grf.drawn_scenes import program_text
from lab.grf.figures import Panel, draw_panels
from lab.grf.policies import GOAL, TOWARDS
from lab.grf.report import read_data
from lab.grf.rows import Row, by_factor
from lab.grf.scenes import SCENES
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import GK, LEFT, NOBODY, SHORT_PASS, SHOT, SPRINT
from regista.envs.football.vector_env import FootballVectorEnv
from regista.experiments.run.config import TEST_ENVS
from regista.experiments.transfer.episodes import Episodes, play
from ued.core.level_space import level_dtype

TITLE = "scripted players against the built-in team"
REQUIRED = 0.8  # share of the rows that should be within tolerance
TOLERANCE = 1.0  # a factor of 2
SMALL = 0.5  # goals per match, added to both numbers: reduces the noise of ratios of few goals
DIFFICULTIES = {"easy": 0.05, "medium": 0.6, "hard": 0.95}  # of the right team
MATCHES, STEPS = 48, 3000  # of each player at each difficulty, at effort 1
GRF_MATCHES = 12
OURS = FootballConfig("features", control="active", rewards="scoring")
SEED = 30_000

SPRINT_EVERY = 8  # steps; the action is sticky, and a kick or a change of player ends it
SHOOT_WITHIN = 20.0  # m from the middle of the goal
CLOSE = 6.0  # m to an opponent to dodge or to pass away from
AHEAD = np.cos(np.radians(60))  # cosine of the largest angle from the way to goal at which an opponent is in front
MATE = (6.0, 25.0)  # m to the receiver of a pass, minimum and maximum
FREE = 4.0  # m from a teammate to the nearest opponent


class Sight(NamedTuple):
    """Observations of the agents of N matches in m, y upwards: positions of agent, ball, teammates and opponents."""

    me: np.ndarray  # [N, 2]
    ball: np.ndarray  # [N, 2]
    mates: np.ndarray  # [N, P, 2], nan for the agent, keepers and opponents
    opponents: np.ndarray  # [N, P, 2], nan for the left team
    mine: np.ndarray  # [N] bool, whether the agent has the ball


def look(matches: np.ndarray) -> Sight:
    """Return the observations of the agents in match records `[N]`."""
    row = np.arange(len(matches))
    agent, players = matches["agents"][:, 0], matches["players"]
    places = np.stack([players["x"], players["y"]], -1)  # [N, 22, 2]
    there = np.arange(places.shape[1]) < matches["num_players"][:, None]
    left, keeper = players["team"] == LEFT, players["role"] == GK
    mate = there & left & ~keeper
    mate[row, agent] = False
    ball = np.stack([matches["ball"]["x"], matches["ball"]["y"]], -1)
    owner = matches["reported_owner"]
    return Sight(
        places[row, agent],
        ball,
        np.where(mate[..., None], places, np.nan),
        np.where((there & ~left)[..., None], places, np.nan),
        (owner != NOBODY) & (owner == agent),
    )


def key_towards(way: np.ndarray) -> np.ndarray:
    """Return the direction action `[N]` of vectors `[N, 2]`."""
    return TOWARDS[np.round(np.arctan2(way[:, 1], way[:, 0]) / (np.pi / 4)).astype(int) % 8]


def turned(way: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return vectors `[N, 2]` turned by angles `[N]`, positive to the left."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * way[:, 0] - s * way[:, 1], s * way[:, 0] + c * way[:, 1]], -1)


class Player:
    """The straight runner: it runs at the ball, then with the ball at the goal, and shoots from near."""

    def begin(self, count: int) -> None:
        """Reset the state for `count` new matches."""
        self.passes = np.zeros(count, bool)  # the pass action follows that of its direction

    def __call__(self, matches: np.ndarray, step: int) -> np.ndarray:
        """Return the actions `[N]` of a step."""
        sight = look(matches)
        goal = np.asarray(GOAL) - sight.me
        keys = np.where(sight.mine, self.with_ball(sight, goal), key_towards(sight.ball - sight.me))
        shoots = sight.mine & (np.linalg.norm(goal, axis=1) < SHOOT_WITHIN)
        keys = np.where(shoots, SHOT, keys)
        keys = np.where(self.passes & sight.mine, SHORT_PASS, keys)
        self.passes = self.wants_pass(sight) & ~self.passes & ~shoots
        return np.where(step % SPRINT_EVERY == 1, SPRINT, keys)

    def with_ball(self, sight: Sight, goal: np.ndarray) -> np.ndarray:
        """Return the direction action of an agent with the ball; `goal` `[N, 2]` is the vector to the goal."""
        return key_towards(goal)

    def wants_pass(self, sight: Sight) -> np.ndarray:
        """Return which agents pass next, bool `[N]`."""
        return np.zeros(len(sight.me), bool)


class Dodger(Player):
    """Turns by 60 degrees away from a close opponent in front."""

    def with_ball(self, sight: Sight, goal: np.ndarray) -> np.ndarray:
        to_him, close = nearest(sight.opponents, sight.me)
        front = (to_him * goal).sum(1) > AHEAD * close * np.linalg.norm(goal, axis=1)
        side = np.sign(goal[:, 0] * to_him[:, 1] - goal[:, 1] * to_him[:, 0])  # 1: the player is on the left
        angle = np.where(front & (close < CLOSE), -np.where(side == 0, 1.0, side) * np.pi / 3, 0.0)
        return key_towards(turned(goal, angle))


class Passer(Player):
    """Passes to the foremost free teammate ahead and in reach, when an opponent is close."""

    def wants_pass(self, sight: Sight) -> np.ndarray:
        return sight.mine & (nearest(sight.opponents, sight.me)[1] < CLOSE) & np.isfinite(self.way_to_mate(sight)[:, 0])

    def with_ball(self, sight: Sight, goal: np.ndarray) -> np.ndarray:
        way = self.way_to_mate(sight)
        close = nearest(sight.opponents, sight.me)[1] < CLOSE
        passes = close & np.isfinite(way[:, 0])
        return key_towards(np.where(passes[:, None], way, goal))

    @staticmethod
    def way_to_mate(sight: Sight) -> np.ndarray:
        """Return the vector `[N, 2]` to the foremost free teammate in reach, nan if there is none."""
        way = sight.mates - sight.me[:, None]  # [N, P, 2]
        distance = np.linalg.norm(way, axis=-1)
        guard = np.linalg.norm(sight.mates[:, :, None] - sight.opponents[:, None], axis=-1)  # [N, P, P]
        free = np.where(np.isnan(guard), np.inf, guard).min(-1) > FREE
        fits = free & (distance > MATE[0]) & (distance < MATE[1]) & (way[..., 0] > 0)
        best = np.where(fits, sight.mates[..., 0], -np.inf).argmax(1)
        row = np.arange(len(way))
        return np.where(fits[row, best][:, None], way[row, best], np.nan)


PLAYERS: dict[str, Callable[[], Player]] = {"runner": Player, "dodger": Dodger, "passer": Passer}


def nearest(places: np.ndarray, me: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vector `[N, 2]` to the nearest of `places` `[N, P, 2]`, and its length `[N]`."""
    way = places - me[:, None]
    distance = np.linalg.norm(way, axis=-1)
    distance = np.where(np.isnan(distance), np.inf, distance)
    row, first = np.arange(len(me)), distance.argmin(1)
    return np.nan_to_num(way[row, first]), distance[row, first]


def play_matches(name: str, difficulty: float, count: int, config: FootballConfig = OURS) -> Episodes:
    """Play `count` whole matches of a scripted player in the engine of a configuration."""
    text = program_text(
        SCENES["11_vs_11"],
        game_duration=STEPS,
        right_team_difficulty=difficulty,
        offsides=True,
        end_episode_on_score=False,
        end_episode_on_out_of_play=False,
        end_episode_on_possession_change=False,
    )
    player = PLAYERS[name]()
    with closing(FootballVectorEnv(text, min(count, TEST_ENVS[config.engine]), config=config)) as env:

        def choose(observation: Any, step: int) -> np.ndarray:
            if step == 0:
                player.begin(env.num_envs)
            return player(env.matches, step)

        levels = np.zeros(count, level_dtype(env.theta_dim))
        levels["seed"] = np.arange(SEED, SEED + count)
        return play(env, choose, levels)


def numbers(episodes: Episodes) -> dict[str, float]:
    """Return the compared numbers of a player's matches, one match per episode."""
    owner = episodes.owner
    owned = owner != NOBODY
    goals = episodes.score.mean(0)
    return {
        "goals_for": float(goals[0]),
        "goals_against": float(goals[1]),
        "possession": float((owner[owned] < 11).mean()),
    }


def measure(effort: float = 1.0) -> list[Row]:
    """Compare goals of both teams; `effort` below 1 plays fewer matches."""
    rows = []
    played: dict[tuple[str, str], dict[str, float]] = {}
    for target in read_data("players"):
        key = (target["player"], target["difficulty"])
        if key not in played:
            played[key] = numbers(play_matches(key[0], DIFFICULTIES[key[1]], max(round(MATCHES * effort), 2)))
        for what in ("goals_for", "goals_against"):
            ours, grf = played[key][what] + SMALL, float(target[what]) + SMALL
            name = f"{' '.join(key)}: {what.replace('_', ' ')} + {SMALL}"
            rows.append(by_factor("players", name, ours, grf, "a match", TOLERANCE))
    return rows


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw both teams' goals, ours beside GRF's."""
    rows = measure(effort)
    panels = []
    for what in ("for", "against"):
        here = [row for row in rows if f"goals {what}" in row.name]
        order = np.arange(len(here))
        theirs, ours = ([getattr(row, side) - SMALL for row in here] for side in ("grf", "ours"))
        panels.append(Panel(f"goals {what}", (order, theirs), (order, ours), "row", "a match", points=True))
    draw_panels(path, TITLE, panels)


def measure_both(other: FootballConfig, count: int, told: Callable[[int], None]) -> list[dict[str, Any]]:
    """Play every player at every difficulty in both engines; return the rows of `data/players.csv`."""
    rows: list[dict[str, Any]] = []
    for name in PLAYERS:
        for words, difficulty in DIFFICULTIES.items():
            row: dict[str, Any] = {"player": name, "difficulty": words, "matches": count}
            both = [numbers(play_matches(name, difficulty, count, config)) for config in (OURS, other)]
            row |= both[1] | {f"ours_{what}": value for what, value in both[0].items()}
            rows.append(row)
            told(len(rows))
    return rows


def table(rows: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return a line for each row, ours and GRF's side by side."""
    head = [
        "player",
        "difficulty",
        "matches",
        *(f"{what}, {side}" for what in ("for", "against") for side in ("ours", "grf")),
    ]
    lines = [head]
    for row in rows:
        goals = [row[f"{side}goals_{what}"] for what in ("for", "against") for side in ("ours_", "")]
        lines.append([row["player"], row["difficulty"], str(row["matches"]), *(f"{value:.2f}" for value in goals)])
    return lines
