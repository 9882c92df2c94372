"""A situation of Google Research Football set up in our simulator: positions and actions of the players.

Positions are GRF's: x in [-1, 1] towards the goal of the right team, y in [-0.42, 0.42] downwards. Read next:
`grf.motion`, the family that is easiest to follow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from regista.envs.football.kick_off import MatchConfig, Roster, kick_off
from regista.envs.football.simulator import step_everybody

METRES_X, METRES_Y = 54.4, 83.6  # m per GRF unit
OPEN_END = MatchConfig(
    game_duration=3000,
    end_episode_on_score=False,
    end_episode_on_out_of_play=False,
    end_episode_on_possession_change=False,
    control="none",
)

Policy = Callable[["Stage"], npt.ArrayLike]


def metres(places: npt.ArrayLike) -> np.ndarray:
    """Convert GRF positions `[..., 2]` to meters, y upwards."""
    return np.asarray(places, float) * (METRES_X, -METRES_Y)


def units(places: npt.ArrayLike) -> np.ndarray:
    """Convert positions `[..., 2]` in meters, y upwards, to GRF units."""
    return np.asarray(places, float) / (METRES_X, -METRES_Y)


@dataclass(frozen=True)
class Trace:
    """States of N matches at the end of each of T steps; positions in m, speeds in m/s, y upwards."""

    ball: np.ndarray  # [T, N, 3]
    ball_velocity: np.ndarray  # [T, N, 3]
    places: np.ndarray  # [T, N, P, 2]
    velocities: np.ndarray  # [T, N, P, 2]
    owner: np.ndarray  # [T, N], player as in `state.MATCH_FIELDS`, -1 none
    mode: np.ndarray  # [T, N]
    score: np.ndarray  # [T, N, 2]
    ended: np.ndarray  # [T, N]


class Stage:
    """N matches with the same start except for their random numbers; each player has its own actions.

    Args:
        positions: `[P, 2]` or `[N, P, 2]`, in GRF units; left players first, as in the lineup.
        ball: `[2]` or `[N, 2]`.
        lineup: teams and roles `[P]`.
        config: settings of the episode; by default only the duration of 3000 steps ends it.
        n: matches, each with its own random numbers.
        seed: of the first match; the others follow.
        mirrored: right players' positions are in their own frame, as in scenario files.

    `matches` are the records; change them before the first step to set anything else.
    """

    def __init__(
        self,
        positions: npt.ArrayLike,
        ball: npt.ArrayLike,
        roster: Roster,
        config: MatchConfig = OPEN_END,
        n: int = 1,
        seed: int = 0,
        mirrored: bool = False,
    ) -> None:
        places = np.array(positions, float)
        if mirrored:
            places[..., np.asarray(roster.teams) == 1, :] *= -1.0
        places = np.broadcast_to(metres(places), (n, *places.shape[-2:]))
        balls = np.broadcast_to(metres(ball), (n, 2))
        self.matches = kick_off(places, balls, roster, np.arange(seed, seed + n), config).view(np.recarray)
        self.num_players = places.shape[1]
        self._frames = [self._frame()]

    def step(self, actions: npt.ArrayLike) -> None:
        """Play 0.1 s: `actions` `[N, P]` (or what broadcasts) are actions 0..18, 19 for the built-in AI, -1 to stand.

        Directions are those of the pitch for either team.
        """
        everybody = np.broadcast_to(np.asarray(actions, np.int64), (len(self.matches), self.num_players))
        step_everybody(self.matches, np.require(everybody, requirements=("C", "W")))
        self._frames.append(self._frame())

    def play(self, actions: npt.ArrayLike | Policy, steps: int | None = None) -> Trace:
        """Play a list of actions `[T, P]` or `[T, N, P]`, or a policy for `steps` steps; return the trace so far."""
        if callable(actions):
            if steps is None:
                raise ValueError("how many steps? a policy has no length")
            for _ in range(steps):
                self.step(actions(self))
        else:
            for now in np.asarray(actions, np.int64):
                self.step(now)
        return self.trace()

    def trace(self) -> Trace:
        """Return the trace so far: row 0 is the start, row t the end of step t."""
        return Trace(*(np.stack(frames) for frames in zip(*self._frames, strict=True)))

    def _frame(self) -> tuple[np.ndarray, ...]:
        ball, players = self.matches["ball"], self.matches["players"][:, : self.num_players]
        return (
            np.stack([ball[name] for name in ("x", "y", "z")], axis=-1),
            np.stack([ball[name] for name in ("vx", "vy", "vz")], axis=-1),
            np.stack([players[name] for name in ("x", "y")], axis=-1),
            np.stack([players[name] for name in ("vx", "vy")], axis=-1),
            *(self.matches[name].copy() for name in ("reported_owner", "game_mode", "score", "ended")),
        )


def keys(*pressed: tuple[int, int], others: tuple[int, ...] = (), first: bool = True) -> np.ndarray:
    """Return the actions `[T, P]` of one player who repeats each action for a number of steps, and those of all others.

    That player is the first one, or the last one if `first` is False.
    """
    mine = np.concatenate([np.full(steps, action) for action, steps in pressed])
    rest = np.broadcast_to(np.array(others, np.int64), (len(mine), len(others)))
    return np.column_stack([mine, rest] if first else [rest, mine])
