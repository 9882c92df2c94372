"""Shots and saves: whether the keeper must react, where keeper and ball meet, and whether the shot is saved.

The outcome is drawn when the shot leaves the foot, with odds fitted to saves measured in Google Research Football;
the body then moves accordingly. Read next: `skills.contacts`, where hands and ball meet.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    DT,
    GK,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    HALF_LENGTH,
    NOBODY,
)
from regista.envs.football.physics.ball import advance_ball
from regista.envs.football.physics.pitch import in_box_of, own_goal_x
from regista.envs.football.physics.possession import ball_speed
from regista.envs.football.physics.running import READY
from regista.envs.football.physics.vectors import length, squared_apart
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class SaveOdds(NamedTuple):
    """Whether the keeper saves a shot: it hits the body before any reaction, or the keeper reaches it in time.

    P(body) = body * (1 - (gap / body_gap)²), if t < sudden

    logit P(hands) = hands * (t - halfway) - effort * cost

    Here t is the time in s until the shot passes the keeper, and gap is the distance in m between them at that time.
    cost is the speed in m/s that the keeper needs to meet the shot. On the line a keeper cannot go back to meet it:
    dives take longer there, and the effort does not count. Fitted to 4587 measured shots on target from 3 to 30 m, at
    keepers who stand and who come out.
    """

    body: float = 0.92  # share of shots straight at the body that hit it
    body_gap: float = 1.06  # m aside, beyond which no shot hits the body
    sudden: float = 0.22  # s until the shot reaches the keeper; later, the keeper has moved
    hands: float = 10.0  # logit per s
    halfway: float = 0.355  # s until the shot passes, at which the chance is one half,
    line_halfway: float = 0.127  # and s more for a dive on the line
    dive_from: float = 0.4  # m aside, from which on the keeper dives,
    dive_range: float = 1.06  # m more, for the full dive
    effort: float = 0.37  # logit per m/s, for a keeper off the line
    on_line: float = 1.5  # m in front of the line; up to here the keeper is on the line
    off_line: float = 2.0  # m more, at which the keeper is off the line
    foot_gap: float = 2.0  # m, at which the chance is 0 outside the box, where only feet may be used
    measured_skill: float = 0.72  # `skill` of the measured keeper
    skill: float = 5.0  # logit per unit of skill below that skill


class Dive(NamedTuple):
    """How a keeper gets to a shot, checked by the same family."""

    arm: float = 1.2  # m
    speed: float = 7.5  # m/s; a shot that needs more is never saved
    delay: float = 0.08  # s
    stride: float = 0.1  # s for which the keeper's velocity is kept
    before_line: float = 0.3  # m in front of the goal line, the last possible meeting point
    shot_speed: float = 9.0  # m/s; slower balls are not shots
    goal_margin: float = 1.3  # half widths of the goal, within which the keeper goes for the ball
    over_bar: float = 0.3  # m above the bar; the keeper ignores higher balls


SAVE, DIVE = SaveOdds(), Dive()
FORESEEN = 300  # frames for which a shot is predicted


@kernel
def dive(match, player):
    """Throw the keeper to the meeting point with the shot."""
    dx, dy = match.save_x - player.x, match.save_y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    speed = min(distance / max(match.save_wait, 0.1), DIVE.speed * match.engine.keeper_speed)
    share = speed / distance if distance > 0.05 else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def foresee_shot(match, team):
    """Determine after a kick by `team` whether the other keeper must save it, where, and whether the save succeeds."""
    match.was_kicked, match.kick_age = True, 0.0
    foresee(match, team)


@kernel
def foresee(match, team):
    """Make the other keeper save a ball of `team` that flies at the goal; draw whether the save succeeds."""
    match.saver = NOBODY
    goal_x = -own_goal_x(team)
    if ball_speed(match.ball) < DIVE.shot_speed or match.ball.vx * goal_x <= 0.0:
        return
    for i in range(match.num_players):
        player = match.players[i]
        if player.team == team or player.role != GK:
            continue
        is_on_goal, effort, gap, time = follow_shot(match, player, goal_x)
        if is_on_goal:
            match.saver, match.save_gap = i, gap
            effort /= match.engine.keeper_speed
            gap /= match.engine.keeper_reach
            match.save_succeeds = uniform(match) < save_chance(player, effort, gap, time)
            player.turning = READY
        return


@kernel
def follow_shot(match, player, goal_x):
    """Predict the ball's path to the goal line, and choose the meeting point with the least cost for a keeper.

    Returns whether the ball goes into the goal, near it or just over it; the speed in m/s that the keeper needs to meet
    it; the distance in m at which it passes the keeper, and the time in s until then.
    """
    ball = match.ball
    x, y, z, vx, vy, vz = ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz
    spin_x, spin_y, curl = ball.spin_x, ball.spin_y, ball.curl
    here_x, here_y = player.x + DIVE.stride * player.vx, player.y + DIVE.stride * player.vy
    least, nearest, gap, time, passing = math.inf, math.inf, math.inf, 0.0, 0.0  # `gap` squared
    for _ in range(FORESEEN):
        advance_ball(ball)
        time += DT
        squared = squared_apart(player, ball.x, ball.y)
        if squared < gap:
            gap, passing = squared, time
        away = length(ball.x - here_x, ball.y - here_y)
        effort = max(away - DIVE.arm * match.engine.keeper_reach, 0.0) / max(time - DIVE.delay, 0.02)
        outside = abs(ball.x) < HALF_LENGTH - DIVE.before_line or least == math.inf
        if outside and (effort < least or (effort == least and away < nearest)):
            least, nearest = effort, away
            match.save_x, match.save_y, match.save_wait = ball.x, ball.y, time
        if abs(ball.x) >= HALF_LENGTH:
            break
    inside = abs(ball.y) < DIVE.goal_margin * GOAL_HALF_WIDTH and ball.z < GOAL_HEIGHT + DIVE.over_bar
    is_on_goal = inside and ball.x * goal_x >= HALF_LENGTH * HALF_LENGTH
    ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz = x, y, z, vx, vy, vz
    ball.spin_x, ball.spin_y, ball.curl = spin_x, spin_y, curl
    return is_on_goal, least, math.sqrt(gap), passing


@kernel
def save_chance(player, effort, gap, time):
    """Return the chance of saving a shot that passes `gap` m away in `time` s and needs `effort` m/s to be met."""
    body = SAVE.body * max(1.0 - (gap / SAVE.body_gap) ** 2, 0.0) if time < SAVE.sudden else 0.0
    able = effort < DIVE.speed and player.down_wait <= 0.0
    hands = hands_chance(player, effort, gap, time) if able else 0.0
    if not in_box_of(player.team, player.x, player.y):
        hands *= max(1.0 - (gap / SAVE.foot_gap) ** 2, 0.0)
    return 1.0 - (1.0 - hands) * (1.0 - body)


@kernel
def hands_chance(player, effort, gap, time):
    """Return the chance that the keeper reaches a shot that does not hit the body."""
    out = min(max((HALF_LENGTH - abs(player.x) - SAVE.on_line) / SAVE.off_line, 0.0), 1.0)
    dives = min(max((gap - SAVE.dive_from) / SAVE.dive_range, 0.0), 1.0)
    late = time - SAVE.halfway - (1.0 - out) * SAVE.line_halfway * dives
    unskilled = SAVE.skill * max(SAVE.measured_skill - player.skill, 0.0)
    return 1.0 / (1.0 + math.exp(out * SAVE.effort * effort + unskilled - SAVE.hands * late))
