"""Origin of goals: distance of the last kick and position of the keeper, to reveal exploits.

Nine in ten goals from 35 m, past a keeper far off the line, indicate that the policy exploits the simulator. Read next:
`transfer.replaying`, which compares both engines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from regista.envs.football.constants import GK, HALF_LENGTH, LEFT, RIGHT, STEP
from regista.envs.football.kick_off import Roster
from regista.experiments.transfer.episodes import Episodes

FAR = (11.0, 20.0, 30.0)  # m from the middle of the goal: penalty spot, edge of the box, beyond
JOLT = 4.0  # m/s, minimum change of the ball's velocity within a step that indicates a touch
REACH = 2.0  # m, maximum distance of a player who touched the ball
OUT = (2.0, 5.5, 16.5)  # m from the keeper to the goal line: on it, in the goal area, in the box, beyond


@dataclass(frozen=True)
class Goals:
    """The left team's G goals, at the last touch of the left team.

    `keeper_out` and `keeper_wide` are the right keeper's distances from the goal line and from the middle, in m; nan
    without a keeper.
    """

    distance: np.ndarray  # [G] m of the ball from the middle of the goal
    keeper_out: np.ndarray  # [G]
    keeper_wide: np.ndarray  # [G]

    def __len__(self) -> int:
        return len(self.distance)

    def summary(self) -> dict[str, Any]:
        """Return medians, and shares by distance and by the keeper's position; empty without goals."""
        if not len(self):
            return {"goals": 0}
        return {
            "goals": len(self),
            "median_distance": float(np.median(self.distance)),
            "distance_shares": shares(self.distance, FAR),
            "median_keeper_out": _median(self.keeper_out),
            "keeper_shares": shares(self.keeper_out, OUT),
            "median_keeper_wide": _median(self.keeper_wide),
        }


def goals_of(episodes: Episodes, roster: Roster) -> Goals:
    """Find the left team's last goal of each episode, and the touch before it."""
    teams, roles = np.asarray(roster.teams), np.asarray(roster.roles)
    keepers = np.flatnonzero((teams == RIGHT) & (roles == GK))
    rows = np.flatnonzero(episodes.scored)
    steps = np.array([last_kick(episodes, int(row), teams) for row in rows], int)
    ball = episodes.ball[rows, steps]
    keeper = np.full((len(rows), 2), np.nan)
    if len(keepers):
        keeper = episodes.places[rows, steps, keepers[0]]
    return Goals(np.hypot(HALF_LENGTH - ball[:, 0], ball[:, 1]), HALF_LENGTH - keeper[:, 0], np.abs(keeper[:, 1]))


def last_kick(episodes: Episodes, row: int, teams: np.ndarray) -> int:
    """Return the step of the left team's last touch in an episode; `teams` `[P]` gives the team of each player.

    After a first-time kick, no player has owned the ball. So a change of the ball's velocity near a player also counts
    as a touch.
    """
    length = int(episodes.lengths[row])
    owner, ball = episodes.owner[row, : length + 1], episodes.ball[row, : length + 1, :2]
    played = (owner >= 0) & (teams[np.maximum(owner, 0)] == LEFT)
    jolt = np.linalg.norm(np.diff(ball, 2, axis=0), axis=1) / STEP  # [length - 1] m/s
    away = np.linalg.norm(episodes.places[row, : length + 1] - ball[:, None], axis=2)  # [length + 1, P] m
    beside = (away.min(1) <= REACH) & (teams[away.argmin(1)] == LEFT)
    played[1:-1] |= (jolt > JOLT) & beside[1:-1]
    return int(np.flatnonzero(played)[-1]) if played.any() else 0


def shares(values: np.ndarray, limits: Sequence[float]) -> dict[str, float]:
    """Return the share of the values up to each limit, and beyond the last; nan is ignored."""
    edges = (-np.inf, *limits, np.inf)
    between = [f"{low:g} to {high:g}" for low, high in pairwise(limits)]
    words = [f"<{limits[0]:g}", *between, f">{limits[-1]:g}"]
    bins = zip(words, edges, edges[1:], strict=False)
    return {word: float(((values > low) & (values <= high)).mean()) for word, low, high in bins}


def line(goals: dict[str, Any]) -> str:
    """Return a summary of goals as one line."""
    if not goals["goals"]:
        return "no goal"
    far = f"{goals['median_distance']:.0f} m ({_spelled(goals['distance_shares'])})"
    if goals["median_keeper_out"] is None:
        return f"{goals['goals']} goals from {far}, no keeper"
    keeper = f"{goals['median_keeper_out']:.1f} m ({_spelled(goals['keeper_shares'])})"
    return f"{goals['goals']} goals from {far}, keeper off the line by {keeper}"


def _median(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else None


def _spelled(shares: dict[str, float]) -> str:
    return ", ".join(f"{share:.0%} {word}" for word, share in shares.items() if share)
