"""The record of a football match: all that changes in it, declared once.

Each table below names a field, its type, its shape, its unit and its meaning; the NumPy dtypes are made from
them. Resetting is `matches[e] = starts[e]`, saving is `np.save`, comparing is `==`. Players of the left team
attack +x; +y is up. Read next: `simulator`, which moves a match on by one step.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from envs.football.ai.formation import posts
from envs.football.constants import BALL_RADIUS, GK, LEFT, MAX_PLAYERS, NOBODY, RIGHT, TOP_SPEEDS
from envs.football.control.control_modes import appoint
from scenic_lite.kernels.rng import streams

BALL_FIELDS = (
    ("x", "f8", (), "m", "place of the centre"),
    ("y", "f8", (), "m", ""),
    ("z", "f8", (), "m", "height of the centre above the ground"),
    ("vx", "f8", (), "m/s", "velocity"),
    ("vy", "f8", (), "m/s", ""),
    ("vz", "f8", (), "m/s", ""),
    ("spin_x", "f8", (), "m/s", "speed of the surface at the bottom, seen from the centre, reversed: v when rolling"),
    ("spin_y", "f8", (), "m/s", ""),
    ("curl", "f8", (), "rad/s", "spin about the vertical: positive bends the flight to the left"),
)

PLAYER_FIELDS = (
    ("x", "f8", (), "m", "place"),
    ("y", "f8", (), "m", ""),
    ("vx", "f8", (), "m/s", "velocity"),
    ("vy", "f8", (), "m/s", ""),
    ("facing_x", "f8", (), "", "unit vector, where the body looks"),
    ("facing_y", "f8", (), "", ""),
    ("want_x", "f8", (), "m/s", "velocity that the player's command asks for"),
    ("want_y", "f8", (), "m/s", ""),
    ("start_x", "f8", (), "m", "place at kick-off; formations are built around it"),
    ("start_y", "f8", (), "m", ""),
    ("top_speed", "f8", (), "m/s", "full sprint without the ball"),
    ("tired", "f8", (), "", "0 fresh .. 0.99"),
    ("skill", "f8", (), "", "0.3 + 0.7 × difficulty of the team"),
    ("aim_x", "f8", (), "m", "where the kick is meant to go; for a learner, set when it leaves the foot"),
    ("aim_y", "f8", (), "m", ""),
    ("kick_wait", "f8", (), "s", "until the foot meets the ball"),
    ("touch_wait", "f8", (), "s", "until this player can touch the ball again"),
    ("down", "f8", (), "s", "until he is on his feet again after a slide or a dive"),
    ("team", "i8", (), "", "0 left, 1 right"),
    ("role", "i8", (), "", "0 keeper .. 9 forward"),
    ("shirt", "i8", (), "", "index within the team, in program order"),
    ("order", "i8", (), "", "place among the players of the program: who comes first where two are equal"),
    ("agent", "i8", (), "", "agent whose next action moves him, an index into `agents`; -1 none"),
    ("action", "i8", (), "", "this step's action, 0..18, 19 the built-in AI decides, -1 to stand; several in base 20"),
    ("direction", "i8", (), "", "sticky: 1..8 as the actions are numbered, 0 none"),
    ("sprint", "?", (), "", "sticky"),
    ("dribble", "?", (), "", "sticky"),
    ("aimed", "?", (), "", "the kick goes to (aim_x, aim_y), not where the direction keys say"),
    ("kick", "i8", (), "", "0 none, or the action asked for: 9..12"),
    ("kick_held", "i8", (), "steps", "how long the button has been held"),
    ("kick_ready", "?", (), "", "the button has been released: kick when possible"),
    ("kick_patience", "i8", (), "steps", "left until a kick that found no ball is forgotten"),
    ("kick_mate", "i8", (), "", "player for whom the pass asked for is meant, -1 nobody"),
    ("turning", "i8", (), "steps", "since velocity and command differ"),
    ("stride", "f8", (), "s", "since he last played the ball that he leads; negative until he does, going for it"),
    ("held", "f8", (), "m/s", "by which going for that touch holds him back, or negative drives him on"),
    ("sliding", "?", (), "", "the player is down because he slides into a tackle"),
    ("met", "?", (), "", "his slide has met the carrier: felled him, or not"),
    ("cards", "i8", (), "", "1 cautioned (yellow), 2 sent off (red, or the second yellow)"),
    ("leave_wait", "f8", (), "s", "until a player who has been sent off leaves the pitch"),
    ("off", "?", (), "", "has left the pitch: stands far beside it, does nothing and is in nobody's way"),
    # What the built-in AI remembers of him
    ("post_x", "f8", (), "", "his post in the formation: -1 back .. 1 front"),
    ("post_y", "f8", (), "", "-1 .. 1 across the pitch, upwards"),
    ("place_x", "f8", (), "m", "where he supports the ball, from one decision to the next"),
    ("place_y", "f8", (), "m", ""),
    ("mark", "i8", (), "", "opponent whom he marks, -1 none"),
)

MATCH_FIELDS = (
    ("num_players", "i8", (), "", "rows of `players` in use"),
    ("control", "i8", (2,), "", "how each team's agents get their players: `constants.NO_AGENTS` to `FIXED`"),
    ("num_agents", "i8", (2,), "", "of the left and of the right team"),
    ("agents", "i8", (MAX_PLAYERS,), "", "player whom each agent's next action moves, left agents first; -1 nobody"),
    ("random", "u8", (), "", "state of the stream of random numbers"),
    ("step", "i8", (), "steps", "played in this episode"),
    ("ball_start_x", "f8", (), "m", "where the ball was at kick-off"),
    ("ball_start_y", "f8", (), "m", ""),
    # Settings of the episode
    ("game_duration", "i8", (), "steps", ""),
    ("end_episode_on_score", "?", (), "", ""),
    ("end_episode_on_out_of_play", "?", (), "", ""),
    ("end_episode_on_possession_change", "?", (), "", ""),
    ("offsides", "?", (), "", ""),
    ("use_magnet", "?", (), "", "a free ball pulls the best placed player whatever his agent's direction"),
    ("second_half", "i8", (), "steps", "played when the second half begins; beyond the duration there is none"),
    # The state of play
    ("score", "i8", (2,), "", "goals of the left and of the right team"),
    ("game_mode", "i8", (), "", "0 normal, 1 kick-off, 2 goal kick, 3 free kick, 4 corner, 5 throw-in, 6 penalty"),
    ("restart_team", "i8", (), "", "who takes the restart, -1 when none is due"),
    ("restart_wait", "i8", (), "steps", "since play stopped"),
    ("restart_kick", "i8", (), "steps", "until the taker meets the ball, -1 while he has not decided"),
    ("taker", "i8", (), "", "player who takes the restart, -1 none"),
    ("line_wait", "f8", (), "s", "after a set piece for which the side lines do not count"),
    ("starter", "i8", (), "", "team that was nearer to the ball at the start; the other one starts the second half"),
    ("half", "i8", (), "", "0 the first, 1 the second"),
    ("owner", "i8", (), "", "player in possession as the original reports it, -1 none"),
    ("carrier", "i8", (), "", "player who leads the ball with his feet or holds it, -1 for a free ball"),
    ("holder", "i8", (), "", "keeper with the ball in his hands, -1 none"),
    ("hold_wait", "i8", (), "steps", "until the holder kicks it out"),
    ("kicker", "i8", (), "", "player in the middle of a kick, -1 none"),
    ("last_touch", "i8", (), "", "player, -1 none yet"),
    ("kicked", "?", (), "", "the last touch was a kick: of a mate's, keepers must not take it with their hands"),
    ("kick_age", "f8", (), "s", "since the last kick"),
    ("last_owned_team", "i8", (), "", "team of the last owner, -1 none yet"),
    ("receiver", "i8", (), "", "player for whom the last kick was meant, -1 nobody; he need not have the ball yet"),
    ("offside_bits", "i8", (), "", "bit i: player i was offside when a mate last kicked"),
    # A foul that has been seen (`fouls.report_foul`) and that the rules have not dealt with yet
    ("foul_player", "i8", (), "", "who committed it, -1 none"),
    ("foul_victim", "i8", (), "", "who was fouled, -1 none"),
    ("foul_severity", "f8", (), "", "above 1 a foul, above 1.4 yellow, above 2 red"),
    ("foul_x", "f8", (), "m", "where the victim was"),
    ("foul_y", "f8", (), "m", ""),
    ("foul_age", "f8", (), "s", "since then, while play goes on for the victim's advantage"),
    ("advantage", "?", (), "", "a trip, for which play goes on; a slide stops it at once"),
    # Who goes for the ball
    ("chaser", "i8", (2,), "", "player of each team who can be first at the ball"),
    ("saver", "i8", (), "", "keeper against whom a shot is under way, -1 none"),
    ("save_x", "f8", (), "m", "where he means to meet it"),
    ("save_y", "f8", (), "m", ""),
    ("save_wait", "f8", (), "s", "until the ball is there"),
    ("save_gap", "f8", (), "m", "from where he was to there, when the shot left the foot"),
    ("save_succeeds", "?", (), "", "drawn when the shot left the foot"),
    # What the built-in AI remembers of the match
    ("slow_x", "f8", (), "m", "place of the ball, averaged over the last seconds"),
    ("slow_y", "f8", (), "m", ""),
    ("favoured", "i8", (), "", "team that has the ball or will be first at it, -1 none"),
    ("late", "f8", (), "s", "by which the left team will be later at a free ball than the right one"),
    ("bearer", "i8", (), "", "player who has the ball or had it last, as the AI counts"),
    ("borne", "i8", (), "steps", "since he got it"),
    ("hunter", "i8", (2, 2), "", "per team, players who hunt the opponent on the ball, -1 none"),
    ("runner", "i8", (2,), "", "player of each team on an attacking run, -1 none"),
    ("run_left", "i8", (2,), "steps", "until that run ends"),
    # What the last step brought
    ("goal", "i8", (), "", "+1 the left team scored in this step, -1 the right one"),
    ("checkpoint_reward", "f8", (MAX_PLAYERS,), "", "per agent: 0.1 for each checkpoint newly passed in this step"),
    ("checkpoints", "i8", (MAX_PLAYERS,), "", "per agent: of the 10, passed in this episode"),
    ("program_reward", "f8", (), "", "what monitors of the program paid for this step"),
    ("possession_changed", "?", (), "", "the other team than the last owner's came into possession"),
    ("ended", "i8", (), "", "0 running, 1 goal, 2 out of play, 3 possession change, 4 duration, 5 program, 6 rejected"),
    ("terminated", "?", (), "", "ended by an event"),
    ("truncated", "?", (), "", "ended by the duration alone, or rejected"),
    ("fault", "i8", (), "", "0 none, 1 a value is not a number, 2 no such action, 3 in the program"),
)

NOBODY_YET = (
    *("owner", "carrier", "holder", "kicker", "last_touch", "last_owned_team", "saver", "chaser", "receiver"),
    *("restart_team", "restart_kick", "taker", "foul_player", "foul_victim"),
    *("favoured", "bearer", "hunter", "runner"),
)


def _dtype(table: tuple) -> np.dtype:
    return np.dtype([(name, kind, shape) for name, kind, shape, _, _ in table], align=True)


BALL = _dtype(BALL_FIELDS)
PLAYER = _dtype(PLAYER_FIELDS)
MATCH = np.dtype(
    [(name, kind, shape) for name, kind, shape, _, _ in MATCH_FIELDS]
    + [("ball", BALL), ("players", PLAYER, (MAX_PLAYERS,))],
    align=True,
)


@dataclass(frozen=True)
class MatchConfig:
    """Settings of an episode, named as in Google Research Football; each one value or an array [N].

    What ends an episode means what it means there. A goal by either side. Out of play: the first step that shows a
    mode other than 0, so a throw-in, a corner, a goal kick, a foul or an offside; never a kick-off. Possession: the
    ball is owned by the other team than the last that owned it, however long nobody did, and goals do not make that
    forgotten. An episode has exactly `game_duration` steps, and the second half begins after exactly `second_half` of
    them. (Theirs has one step more, because its first action is lost.)
    """

    game_duration: npt.ArrayLike = 400
    end_episode_on_score: npt.ArrayLike = True
    end_episode_on_out_of_play: npt.ArrayLike = True
    end_episode_on_possession_change: npt.ArrayLike = True
    offsides: npt.ArrayLike = False
    second_half: npt.ArrayLike = 999_999_999  # step at which the other team kicks off again; never
    left_team_difficulty: npt.ArrayLike = 1.0
    right_team_difficulty: npt.ArrayLike = 0.6
    deterministic: npt.ArrayLike = False  # the same random numbers in every episode
    use_magnet: npt.ArrayLike = True  # a free ball pulls the best placed player whatever his agent's direction
    control: str | int = "closest1"  # which left players agents move: see `control_modes`
    right_control: str | int = "none"  # which right ones


@dataclass(frozen=True)
class Lineup:
    """Who plays: `teams` [P] (0 left, 1 right) and `roles` [P] (0 keeper .. 9 forward), the left team first.

    `order` [P] is the place of each in the program, which settles ties; None: they come in that order.
    """

    teams: npt.ArrayLike
    roles: npt.ArrayLike
    order: npt.ArrayLike | None = None


def kick_off(
    positions: npt.ArrayLike,
    ball: npt.ArrayLike,
    lineup: Lineup,
    seeds: npt.ArrayLike,
    config: MatchConfig = MatchConfig(),
) -> np.ndarray:
    """Make matches MATCH [N] about to begin: everyone stands, the ball lies still and is nobody's.

    `positions` [N, P, 2] and `ball` [N, 2] are in metres, `seeds` [N] start the random streams. Raises ValueError
    if the shapes disagree, there are more than 22 players, or a control mode does not fit the team.
    """
    positions, ball = np.asarray(positions, float), np.asarray(ball, float)
    teams, roles = np.asarray(lineup.teams, np.int64), np.asarray(lineup.roles, np.int64)
    _check(positions, ball, teams, roles)
    matches = np.zeros(len(positions), MATCH)
    for name in NOBODY_YET:
        matches[name] = NOBODY
    matches["players"]["kick_mate"] = NOBODY
    _settle(matches, config, seeds)
    matches["num_players"] = len(teams)
    for axis, name in enumerate("xy"):
        matches["ball"][name] = ball[:, axis]
        matches["ball_start_" + name] = ball[:, axis]
        matches["slow_" + name] = ball[:, axis]
    matches["ball"]["z"] = BALL_RADIUS
    _line_up(matches["players"][:, : len(teams)], positions, teams, roles)
    matches["starter"] = _starter(positions, ball, teams)
    _look_at(matches["players"][:, : len(teams)], ball)
    difficulty = np.stack(np.broadcast_arrays(config.left_team_difficulty, config.right_team_difficulty), axis=-1)
    matches["players"]["skill"][:, : len(teams)] = 0.3 + 0.7 * np.take(difficulty, teams, axis=-1)
    matches["players"]["order"][:, : len(teams)] = np.arange(len(teams)) if lineup.order is None else lineup.order
    appoint(matches, (config.control, config.right_control))
    return matches


def _check(positions: np.ndarray, ball: np.ndarray, teams: np.ndarray, roles: np.ndarray) -> None:
    if positions.ndim != 3 or positions.shape[2] != 2 or ball.shape != (len(positions), 2):
        raise ValueError(f"positions must be [N, P, 2] and ball [N, 2], not {positions.shape} and {ball.shape}")
    if not (teams.shape == roles.shape == positions.shape[1:2]):
        raise ValueError(f"{positions.shape[1]} players, but teams {teams.shape} and roles {roles.shape}")
    if not 1 <= len(teams) <= MAX_PLAYERS:
        raise ValueError(f"a match has 1 to {MAX_PLAYERS} players, not {len(teams)}")


def _settle(matches: np.ndarray, config: MatchConfig, seeds: npt.ArrayLike) -> None:
    """Write the settings of the episode; equal seeds, or a deterministic match, give equal streams."""
    for field in fields(config):
        if field.name in MATCH.names and field.name != "control":  # type: ignore[operator]
            matches[field.name] = getattr(config, field.name)
    matches["random"] = streams(np.where(config.deterministic, 0, np.asarray(seeds)).astype(np.uint64))


def _line_up(players: np.ndarray, positions: np.ndarray, teams: np.ndarray, roles: np.ndarray) -> None:
    """Place players [N, P]."""
    for axis, name in enumerate("xy"):
        players[name] = positions[..., axis]
        players["start_" + name] = positions[..., axis]
        players["place_" + name] = positions[..., axis]
    players["team"], players["role"] = teams, roles
    players["mark"] = NOBODY
    for team in (LEFT, RIGHT):
        own = teams == team
        players["shirt"][:, own] = np.arange(np.count_nonzero(own))
        forward = positions[:, own, 0] * (1.0 if team == LEFT else -1.0)
        depth_and_width = posts(forward, positions[:, own, 1], roles[own])
        players["post_x"][:, own], players["post_y"][:, own] = depth_and_width[:, 0], depth_and_width[:, 1]
    speeds = np.where(roles == GK, TOP_SPEEDS[0], np.take(TOP_SPEEDS, players["shirt"][0] % len(TOP_SPEEDS)))
    players["top_speed"] = speeds


def _starter(positions: np.ndarray, ball: np.ndarray, teams: np.ndarray) -> np.ndarray:
    """Team [N] whose nearest player is nearer to the ball; as in the original, the right one if both are equal."""
    squared = np.sum((positions - ball[:, None]) ** 2, axis=-1)
    left, right = (np.where(teams == team, squared, np.inf).min(axis=1) for team in (LEFT, RIGHT))
    return np.where(left < right, LEFT, RIGHT)


def _look_at(players: np.ndarray, ball: np.ndarray) -> None:
    """Let players [N, P] look at the ball [N, 2], on top of it at the goal that they attack."""
    away = ball[:, None] - np.stack([players["x"], players["y"]], axis=-1)
    size = np.hypot(away[..., 0], away[..., 1])
    on_top = size < 1e-9
    players["facing_x"] = np.where(on_top, np.where(players["team"] == LEFT, 1.0, -1.0), away[..., 0] / (size + on_top))
    players["facing_y"] = np.where(on_top, 0.0, away[..., 1] / (size + on_top))
