"""Creates matches in their initial states, from the players' positions and the settings of an episode.

Read next: `state`, the record that is filled; `scenic.lineup`, which reads positions and settings from a program.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from regista.envs.football.ai.balance import FULL_POSSESSION, NO_POSSESSION
from regista.envs.football.ai.formation import formation_slots
from regista.envs.football.constants import BALL_RADIUS, GK, LEFT, MAX_PLAYERS, NOBODY, RIGHT, TOP_SPEEDS
from regista.envs.football.control.control_modes import assign_agents
from regista.envs.football.state import ENGINE, MATCH, NOBODY_YET
from regista.kernels.rng import streams

NO_KICK = 9.0  # s since the last kick, if no kick has happened yet


@dataclass(frozen=True)
class MatchConfig:
    """Settings of an episode, with Google Research Football's names; each is one value or an array [N].

    Endings have the same meaning as in GRF. Score: a goal by either side. Out of play: the first step with a game mode
    other than 0 or kick-off, that is a throw-in, a corner, a goal kick, a foul or an offside. Possession change: the
    team that did not own the ball last now owns it; neither time without an owner nor a goal resets the last owner. An
    episode has exactly `game_duration` steps (GRF's has one more), and the second half begins after `second_half`
    steps.
    """

    game_duration: npt.ArrayLike = 400
    end_episode_on_score: npt.ArrayLike = True
    end_episode_on_out_of_play: npt.ArrayLike = True
    end_episode_on_possession_change: npt.ArrayLike = True
    defending: bool = False  # an episode succeeds if no goal is conceded: see `episode.has_succeeded`
    offsides: npt.ArrayLike = False
    second_half: npt.ArrayLike = 999_999_999  # step at which the other team kicks off; by default never
    left_team_difficulty: npt.ArrayLike = 1.0
    right_team_difficulty: npt.ArrayLike = 0.6
    deterministic: npt.ArrayLike = False  # use the same random numbers in every episode
    use_magnet: npt.ArrayLike = True  # a free ball attracts the best placed player, whatever direction an agent holds
    agents_only: npt.ArrayLike = False  # in a team with agents, behaviors move only the agents' players
    # Factors by which the engine differs from the measured one (`state.ENGINE_FIELDS`); their spread between episodes
    reaction_time: npt.ArrayLike = 1.0
    start_lag: npt.ArrayLike = 1.0
    keeper_speed: npt.ArrayLike = 1.0
    keeper_range: npt.ArrayLike = 1.0
    keeper_reach: npt.ArrayLike = 1.0
    tackle_odds: npt.ArrayLike = 1.0
    kick_spread: npt.ArrayLike = 1.0
    sticky_noise: npt.ArrayLike = 0.0
    engine_spread: npt.ArrayLike = 0.0
    control: str | int = "closest1"  # left players that agents move: see `control_modes`
    right_control: str | int = "none"  # right players that agents move


@dataclass(frozen=True)
class Roster:
    """The players: `teams` [P] (0 left, 1 right) and `roles` [P] (0 keeper .. 9 forward), the left team first.

    `order` [P] is the position of each player in the program, which breaks ties; None: the order of the arrays.
    """

    teams: npt.ArrayLike
    roles: npt.ArrayLike
    order: npt.ArrayLike | None = None


def kick_off(
    positions: npt.ArrayLike,
    ball: npt.ArrayLike,
    roster: Roster,
    seeds: npt.ArrayLike,
    config: MatchConfig = MatchConfig(),
) -> np.ndarray:
    """Make matches MATCH [N] in their initial state: all players stand, the ball is at rest and has no owner.

    `positions` [N, P, 2] and `ball` [N, 2] are in meters, `seeds` [N] start the random streams. Raises ValueError
    if the shapes disagree, there are more than 22 players, or a control mode does not fit the team.
    """
    positions, ball = np.asarray(positions, float), np.asarray(ball, float)
    _check(positions, ball, np.asarray(roster.teams), np.asarray(roster.roles))
    return placed(unplaced(roster, config, len(positions)), positions, ball, seeds, config)


def unplaced(roster: Roster, config: MatchConfig, count: int = 1) -> np.ndarray:
    """Make matches MATCH `[count]`, and fill all fields that depend on players and settings but not on positions."""
    teams, roles = np.asarray(roster.teams, np.int64), np.asarray(roster.roles, np.int64)
    matches = np.zeros(count, MATCH)
    for name in NOBODY_YET:
        matches[name] = NOBODY
    matches["players"]["kick_mate"] = NOBODY
    _write_settings(matches, config)
    matches["num_players"] = len(teams)
    matches["ball"]["z"] = BALL_RADIUS
    matches["kick_age"] = NO_KICK
    players = matches["players"][:, : len(teams)]
    _number_players(players, teams, roles)
    difficulty = np.stack(np.broadcast_arrays(config.left_team_difficulty, config.right_team_difficulty), axis=-1)
    players["skill"] = 0.3 + 0.7 * np.take(difficulty, teams, axis=-1)
    _apply_factors(players, matches["engine"], roles)
    players["order"] = np.arange(len(teams)) if roster.order is None else roster.order
    return matches


def placed(
    matches: np.ndarray, positions: np.ndarray, ball: np.ndarray, seeds: npt.ArrayLike, config: MatchConfig
) -> np.ndarray:
    """Return matches MATCH [N] from the result of `unplaced` for this config, [N] or one for all; see `kick_off`."""
    matches = matches[np.broadcast_to(np.arange(len(matches)), len(positions))]  # copies whole records
    matches["random"] = streams(np.where(config.deterministic, 0, np.asarray(seeds)).astype(np.uint64))
    for axis, name in enumerate("xy"):
        matches["ball"][name] = ball[:, axis]
        matches["ball_start_" + name] = ball[:, axis]
    players = matches["players"][:, : positions.shape[1]]
    for axis, name in enumerate("xy"):
        for field in (name, "start_" + name, "place_" + name):
            players[field] = positions[..., axis]
    left, right = _nearest(positions, ball, players["team"][0]).T
    matches["starter"] = np.where(left < right, LEFT, RIGHT)  # as in GRF, the right team if both distances are equal
    matches["hold"] = _possession_share(left, right)
    _look_at(players, ball)
    assign_agents(matches, (config.control, config.right_control))
    return matches


def _check(positions: np.ndarray, ball: np.ndarray, teams: np.ndarray, roles: np.ndarray) -> None:
    if positions.ndim != 3 or positions.shape[2] != 2 or ball.shape != (len(positions), 2):
        raise ValueError(f"positions must be [N, P, 2] and ball [N, 2], got {positions.shape} and {ball.shape}")
    if not (teams.shape == roles.shape == positions.shape[1:2]):
        raise ValueError(f"positions have {positions.shape[1]} players, teams {teams.shape} and roles {roles.shape}")
    if not 1 <= len(teams) <= MAX_PLAYERS:
        raise ValueError(f"a match has 1 to {MAX_PLAYERS} players, not {len(teams)}")


def _write_settings(matches: np.ndarray, config: MatchConfig) -> None:
    for name in ENGINE.names:  # type: ignore[union-attr]
        matches["engine"][name] = getattr(config, name)
    for field in fields(config):
        if field.name in MATCH.names and field.name != "control":  # type: ignore[operator]
            matches[field.name] = getattr(config, field.name)


def _apply_factors(players: np.ndarray, engine: np.ndarray, roles: np.ndarray) -> None:
    """Write each player's factors of the engine variation [N] into players [N, P]."""
    for name in ("reaction_time", "start_lag"):
        players[name] = engine[name][:, None]
    players["top_speed"] *= np.where(roles == GK, engine["keeper_speed"][:, None], 1.0)


def _number_players(players: np.ndarray, teams: np.ndarray, roles: np.ndarray) -> None:
    """Give players [N, P] their shirt numbers, and the formation slots of these numbers."""
    players["team"], players["role"] = teams, roles
    players["marked_opponent"] = NOBODY
    for team in (LEFT, RIGHT):
        own = teams == team
        players["shirt"][:, own] = np.arange(np.count_nonzero(own))
        slots = formation_slots(int(own.sum()))
        players["slot_x"][:, own], players["slot_y"][:, own] = slots.T[:, None]
    players["post"] = np.arange(len(teams))
    speeds = np.where(roles == GK, TOP_SPEEDS[0], np.take(TOP_SPEEDS, players["shirt"][0] % len(TOP_SPEEDS)))
    players["top_speed"] = speeds


def _nearest(positions: np.ndarray, ball: np.ndarray, teams: np.ndarray) -> np.ndarray:
    """Return for both teams the squared distance in m from the ball to the nearest player: [N, 2]."""
    squared = np.sum((positions - ball[:, None]) ** 2, axis=-1)
    return np.stack([np.where(teams == team, squared, np.inf).min(axis=1) for team in (LEFT, RIGHT)], axis=-1)


def _possession_share(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return both teams' share of possession [N, 2] at the start: the nearer team has the ball; in a tie, neither."""
    lead = np.sign(right - left)[:, None] * np.array([1.0, -1.0])
    return NO_POSSESSION + 0.5 * (1.0 + np.nan_to_num(lead)) * (FULL_POSSESSION - NO_POSSESSION)


def _look_at(players: np.ndarray, ball: np.ndarray) -> None:
    """Turn players [N, P] to the ball [N, 2]; a player on top of it faces the goal that the team attacks."""
    places = np.stack([players["x"], players["y"]], axis=-1)
    away = ball[:, None] - places
    size = np.hypot(away[..., 0], away[..., 1])
    on_top = size < 1e-9
    players["facing_x"] = np.where(on_top, np.where(players["team"] == LEFT, 1.0, -1.0), away[..., 0] / (size + on_top))
    players["facing_y"] = np.where(on_top, 0.0, away[..., 1] / (size + on_top))
