"""A rule-based player: dribble to the goal, shoot in range, pass under pressure, win the ball back.

It needs only a `raw` observation and returns the number of an action, so it also plays Google Research Football:

    action = act(observation)               # our simulator:  FootballEnv(program, representation="raw")
    action = act(observations[0])           # GRF:            gfootball, representation="raw", one controlled player

It has no memory between steps: `sticky_actions` holds the active actions. Read next: `observation.raw`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

LONG_PASS, HIGH_PASS, SHORT_PASS, SHOT, SPRINT, RELEASE_SPRINT = 9, 10, 11, 12, 13, 15
SPRINT_INDEX = 8  # in `sticky_actions`, after the eight directions
NORMAL, GOAL_KICK, FREE_KICK, CORNER, THROW_IN, PENALTY = 0, 2, 3, 4, 5, 6
KEEPER = 0  # role

X, Y = 54.4, -83.6  # m per unit; y points down in observations, and up in this module
GOAL = (55.0, 0.0)
DIAGONAL = math.sqrt(0.5)
DIRECTIONS = (  # of actions 1 to 8
    (-1.0, 0.0),
    (-DIAGONAL, DIAGONAL),
    (0.0, 1.0),
    (DIAGONAL, DIAGONAL),
    (1.0, 0.0),
    (DIAGONAL, -DIAGONAL),
    (0.0, -1.0),
    (-DIAGONAL, -DIAGONAL),
)

SHOT_RANGE = 16.0  # m
LONG_SHOT = 21.0  # m, if an opponent is about to take the ball
PRESSED = 5.0  # m to an opponent who is not behind the player
LOOK_AHEAD = 7.0  # m ahead; opponents within this distance count when dribbling
LANE = 3.5  # m that opponents must be away from the lane of a pass
PASS_LEAST, PASS_MOST = 5.0, 28.0  # m
SIDE = 33.0  # m from the middle, beyond which the dribbler moves away from the side line
LEAD = 0.5  # s by which an opponent's run or a ball is extrapolated
Point = tuple[float, float]


def act(observation: Mapping[str, Any]) -> int:
    """Return the action, 0 to 18, for a `raw` observation (a dict in Google Research Football's format)."""
    pitch = Pitch(observation)
    if observation["game_mode"] != NORMAL:
        return restart(pitch, observation)
    if observation["ball_owned_team"] == 0 and observation["ball_owned_player"] == observation["active"]:
        return attack(pitch)
    return defend(pitch, observation)


class Pitch:
    """The content of an observation, in meters and seconds, with +y up."""

    def __init__(self, observation: Mapping[str, Any]) -> None:
        me = int(observation["active"])
        self.me = _metres(observation["left_team"][me])
        self.is_keeper = int(observation["left_team_roles"][me]) == KEEPER
        self.mates = [
            _metres(place)
            for index, place in enumerate(observation["left_team"])
            if index != me and observation["left_team_roles"][index] != KEEPER
        ]
        self.rivals = [_metres(place) for place in observation["right_team"]]
        runs = [_metres(run) for run in observation["right_team_direction"]]
        self.rivals_soon = [
            (place[0] + 10 * LEAD * run[0], place[1] + 10 * LEAD * run[1])
            for place, run in zip(self.rivals, runs, strict=True)
        ]
        self.ball = _metres(observation["ball"])
        self.ball_run = tuple(10 * speed for speed in _metres(observation["ball_direction"]))
        self.even = int(observation["steps_left"]) % 2 == 0
        self.sticky_actions = [bool(held) for held in observation["sticky_actions"]]


# ---------------------------------------------------------------- with the ball


def attack(pitch: Pitch) -> int:
    """Shoot in range, pass under pressure, else dribble."""
    distance = _distance(pitch.me, GOAL)
    pressed = min((_distance(pitch.me, rival) for rival in pitch.rivals if rival[0] > pitch.me[0] - 1.0), default=99.0)
    if distance < SHOT_RANGE or (distance < LONG_SHOT and pressed < PRESSED):
        return _kick(pitch, _shot_direction(pitch), SHOT)
    if pitch.is_keeper:
        return _kick(pitch, 5, HIGH_PASS)
    if pressed < PRESSED:
        mate = best_mate(pitch)
        if mate is not None:
            far = _distance(pitch.me, mate) > PASS_MOST / 2
            return _kick(pitch, _towards(pitch.me, mate), LONG_PASS if far else SHORT_PASS)
    return _run(pitch, dribble_direction(pitch))


def best_mate(pitch: Pitch) -> Point | None:
    """Return a teammate with a free lane, preferably close to the goal; None if no teammate is placed well enough."""
    best, best_worth = None, -8.0
    for mate in pitch.mates:
        distance = _distance(pitch.me, mate)
        if not PASS_LEAST < distance < PASS_MOST or _blocked(pitch, mate):
            continue
        room = min((_distance(mate, rival) for rival in pitch.rivals), default=10.0)
        worth = _distance(pitch.me, GOAL) - _distance(mate, GOAL) + min(room, 10.0)
        if worth > best_worth:
            best, best_worth = mate, worth
    return best


def dribble_direction(pitch: Pitch) -> int:
    """Return the direction that gains the most ground towards the goal past the opponents."""
    goal = _unit(pitch.me, GOAL)
    best, best_worth = 5, -math.inf
    for action, (dx, dy) in enumerate(DIRECTIONS, start=1):
        worth = dx * goal[0] + dy * goal[1]
        for rival in pitch.rivals_soon:
            ahead = (rival[0] - pitch.me[0]) * dx + (rival[1] - pitch.me[1]) * dy
            across = abs((rival[0] - pitch.me[0]) * dy - (rival[1] - pitch.me[1]) * dx)
            if 0.0 < ahead < LOOK_AHEAD and across < LANE:
                worth -= 1.5 * (1.0 - ahead / LOOK_AHEAD) * (1.0 - across / LANE) + 0.3
        if abs(pitch.me[1]) > SIDE and dy * pitch.me[1] > 0:
            worth -= 1.0
        if pitch.sticky_actions[action - 1]:
            worth += 0.1  # turning takes time
        if worth > best_worth:
            best, best_worth = action, worth
    return best


def _shot_direction(pitch: Pitch) -> int:
    """Return the direction that points at the goal; from the side, at its far half."""
    x, y = pitch.me
    return _towards((x, y), (GOAL[0], -math.copysign(min(abs(y), 2.0), y)))


def _kick(pitch: Pitch, direction: int, kick: int) -> int:
    """Hold the direction that aims the kick, then press the kick in every other step, since its release kicks."""
    return kick if pitch.sticky_actions[direction - 1] and pitch.even else direction


# ---------------------------------------------------------------- without the ball


def defend(pitch: Pitch, observation: Mapping[str, Any]) -> int:
    """Run to where the ball will be; a little towards our goal if the opponents have it."""
    x = pitch.ball[0] + LEAD * pitch.ball_run[0]
    y = pitch.ball[1] + LEAD * pitch.ball_run[1]
    if observation["ball_owned_team"] == 1 and _distance(pitch.me, (x, y)) > 3.0:
        back = _unit((x, y), (-GOAL[0], 0.0))
        x, y = x + 1.5 * back[0], y + 1.5 * back[1]
    return _run(pitch, _towards(pitch.me, (x, y)))


def restart(pitch: Pitch, observation: Mapping[str, Any]) -> int:
    """Take our set pieces: shoot a penalty, pass otherwise."""
    mode = observation["game_mode"]
    if mode == PENALTY:
        return _kick(pitch, 5, SHOT)
    if mode == FREE_KICK and _distance(pitch.me, GOAL) < LONG_SHOT:
        return _kick(pitch, _shot_direction(pitch), SHOT)
    if mode == CORNER:
        return _kick(pitch, _towards(pitch.me, (GOAL[0] - 11.0, 0.0)), HIGH_PASS)
    mate = best_mate(pitch)
    direction = 5 if mate is None else _towards(pitch.me, mate)
    return _kick(pitch, direction, HIGH_PASS if mode == GOAL_KICK else SHORT_PASS)


# ---------------------------------------------------------------- geometry


def _run(pitch: Pitch, direction: int) -> int:
    """Hold a direction, and sprint once it is held."""
    if not pitch.sticky_actions[direction - 1]:
        return direction
    return direction if pitch.sticky_actions[SPRINT_INDEX] else SPRINT


def _metres(place: Any) -> Point:
    return float(place[0]) * X, float(place[1]) * Y


def _distance(a: Point, b: Point) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])


def _unit(a: Point, b: Point) -> Point:
    """Return the unit vector from a to b."""
    size = _distance(a, b) + 1e-9
    return (b[0] - a[0]) / size, (b[1] - a[1]) / size


def _towards(a: Point, b: Point) -> int:
    """Return the action 1 to 8 that leads best from a to b."""
    ux, uy = _unit(a, b)
    return max(range(1, 9), key=lambda action: DIRECTIONS[action - 1][0] * ux + DIRECTIONS[action - 1][1] * uy)


def _blocked(pitch: Pitch, mate: Point) -> bool:
    """Return whether an opponent stands in the way of a pass."""
    ux, uy = _unit(pitch.me, mate)
    distance = _distance(pitch.me, mate)
    for rival in pitch.rivals:
        ahead = (rival[0] - pitch.me[0]) * ux + (rival[1] - pitch.me[1]) * uy
        across = abs((rival[0] - pitch.me[0]) * uy - (rival[1] - pitch.me[1]) * ux)
        if 0.0 < ahead < distance + 1.0 and across < LANE:
            return True
    return False
