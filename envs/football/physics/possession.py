"""Possession: the player who has the ball, and the players who can be first at it.

Read next: `control.actions`, which turns actions into desired velocities and kicks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import LEFT, NOBODY, RIGHT, STEP, THROW_IN
from regista.envs.football.physics.ball import AIR, GROUND, MEAN_DRAG, rolled
from regista.envs.football.physics.bodies import PUSH
from regista.envs.football.physics.vectors import apart, length
from regista.kernels.jit import kernel


class Owned(NamedTuple):
    """When the last player at the ball is reported as its owner."""

    lead: float = 0.05  # s by which the player's run is extrapolated,
    ahead: float = 0.1  # m ahead of the player
    within: float = 1.0  # m to the ball
    below: float = 0.5  # m, its height
    speed: float = 6.0  # m/s, relative to the player


class Chase(NamedTuple):
    """Parameters for the estimate of which player is first at the ball."""

    over_heads: float = 1.3  # m, height above which no player reaches a ball in flight
    caught_at: float = 0.9  # m, height at which players reach it as it comes down
    landed: float = 0.6  # share of its speed that a ball keeps after landing


class Run(NamedTuple):
    """GRF's estimate of the time that a player needs to a point."""

    leg: float = 0.28  # m of leg, which reaches ahead of the run
    foot: float = 0.1  # m of ball in front of the foot
    stands: float = 1.8  # m/s; a faster player faces along the run, a slower one towards the point
    fades: float = 0.7  # s in which the run fades out and the reach grows
    pace: float = 0.94  # share of top speed at which the reach finally grows
    tick: float = 0.01  # s of running before that
    looks: int = 12  # maximum number of iterations
    near: float = 0.01  # m by which the player may miss the ball
    least: float = 0.1  # minimum of the closing speed, as a share of the largest one
    longest: float = 3.0  # s for which the ball is predicted
    far_run: float = 0.2  # s of running, and
    far_pace: float = 0.75  # share of top speed, for the estimate of longer times
    at_hand: float = 0.1  # s; a shorter time is replaced by this, times min(distance from the ball by then / `hand`, 1)
    hand: float = 0.6  # m


class Ahead(NamedTuple):
    """The ball's path without a touch: shared by all players who run for it, so it is computed once."""

    speed: float  # m/s, in the plane
    flight: float  # s until it comes down to the players
    air: float  # m of flight until then
    left: float  # m/s at which the ball then rolls on
    lasts: float  # s until the ball would come to rest if it kept its current speed, which gives its range


# Ownership follows Google Research Football's definition; the estimates are checked by `lab.benchmarks --suite grf`,
# family matches.
OWNED, CHASE, RUN = Owned(), Chase(), Run()
PLAYED = 0.05  # m from the ball's initial position; beyond it the ball has been touched
CARRIED_WITHIN = 3.0  # m; beyond it a led ball is lost
SURE = 1e-6  # m, more than the rounding errors of distances
NEVER = 100.0  # s to the ball, for a team without players


@kernel
def ball_speed(ball):
    """Return the speed of the ball in m/s in the plane."""
    return length(ball.vx, ball.vy)


@kernel
def fall_time(ball):
    """Return the time in s until a ball in flight above the players comes down to them; 0 for one that stays low."""
    if ball.vz * ball.vz + 2.0 * AIR.gravity * ball.z < 2.0 * AIR.gravity * CHASE.over_heads:
        return 0.0
    return (
        ball.vz + math.sqrt(max(ball.vz * ball.vz + 2.0 * AIR.gravity * (ball.z - CHASE.caught_at), 0.0))
    ) / AIR.gravity


@kernel
def travelled(ahead, time):
    """Estimate the distance in m that a ball with the prediction `ahead` travels in `time` s."""
    if time < ahead.flight:
        return flown(ahead.speed, time)[0]
    return ahead.air + rolled(ahead.left, time - ahead.flight)


@kernel
def flown(speed, flight):
    """Estimate the distance in m that a ball flies in `flight` s, and its speed in m/s afterwards."""
    if flight == 0.0:
        return 0.0, speed
    drag = 1.0 + AIR.drag * speed * flight
    return math.log(drag) / AIR.drag, CHASE.landed * speed / drag


@kernel
def look_ahead(ball):
    """Predict the ball's path."""
    speed, flight = ball_speed(ball), fall_time(ball)
    air, left = flown(speed, flight)
    return Ahead(speed, flight, air, left, (air + rolled(left, math.inf)) / max(speed, 1e-9))


@kernel
def meeting_time(ball, ahead, player):
    """Estimate the time in s after which a player can play the ball with the prediction `ahead`, as GRF does.

    The run carries the player on while it fades, and a circle of reach grows around the resulting point.
    """
    return time_if_before(ball, ahead, player, math.inf)


@kernel
def time_if_before(ball, ahead, player, latest):
    """Return `meeting_time`, or if it is later than `latest` s, any time after `latest`.

    It uses the secant method; invariants are computed first, since this function is called very often.
    """
    speed, pace, lands = length(player.vx, player.vy), RUN.pace * player.top_speed, ahead.flight
    ux, uy = ball.vx / (ahead.speed + 1e-9), ball.vy / (ahead.speed + 1e-9)
    slowing = GROUND.friction + MEAN_DRAG * ahead.left * ahead.left
    rests = ahead.left / slowing
    on, reach = stands_at(speed)
    x = ball.x + ahead.air * ux - player.x - on * player.vx
    y = ball.y + ahead.air * uy - player.y - on * player.vy
    closing = most = ahead.speed + max(speed, pace)
    time, last, lacks = lands, 0.0, 0.0
    for look in range(RUN.looks):
        rolls, fading = min(time - lands, rests), min(time, RUN.fades)
        way = rolls * (ahead.left - 0.5 * slowing * rolls)
        run = fading - 0.5 / RUN.fades * fading * fading
        before = lacks
        lacks = length(x + way * ux - run * player.vx, y + way * uy - run * player.vy) - reach - pace * (time - run)
        if lacks < RUN.near and (look == 0 or lacks > -RUN.near):
            break
        if lacks > 0.0 and time > max(latest, RUN.at_hand):
            return time
        if look > 0:  # the secant of the last iteration, limited to a minimum closing speed
            closing = max((before - lacks) / (time - last), RUN.least * most)
        last, time = time, min(max(time + lacks / closing, lands), max(RUN.longest, lands))
        if time == last or (look == 0 and lacks > RUN.longest * most):
            return far_time(ball, ahead, player)
    if time >= RUN.at_hand:
        return time
    dx = ball.x - player.x + RUN.at_hand * (ball.vx - player.vx)
    dy = ball.y - player.y + RUN.at_hand * (ball.vy - player.vy)
    return RUN.at_hand * min(length(dx, dy) / RUN.hand, 1.0)


@kernel
def stands_at(speed):
    """Return the time in s by which the run of a player at `speed` m/s is extended, and the reach in m."""
    if speed > RUN.stands:
        return RUN.foot / speed + RUN.tick, RUN.leg
    return 0.0, RUN.leg + RUN.foot


@kernel
def short_of(player, speed, dx, dy, time):
    """Return the distance in m by which a player at `speed` m/s misses a point (dx, dy) m away after `time` s."""
    fading = min(time, RUN.fades)
    run = fading - 0.5 * fading * fading / RUN.fades
    on, reach = stands_at(speed)
    on += run
    return length(dx - on * player.vx, dy - on * player.vy) - reach - RUN.pace * player.top_speed * (time - run)


@kernel
def far_time(ball, ahead, player):
    """Return a lower bound in s of the time to a ball that a player does not reach within the predicted time."""
    share = travelled(ahead, RUN.longest) / (ahead.speed + 1e-9)
    dx = ball.x + share * ball.vx - player.x - RUN.far_run * player.vx
    dy = ball.y + share * ball.vy - player.y - RUN.far_run * player.vy
    return max(length(dx, dy) / (RUN.far_pace * player.top_speed), RUN.longest)


@kernel
def time_needed(player, dx, dy):
    """Return the time in s that a player needs to a ball (dx, dy) m away, as GRF estimates it.

    A run towards the ball shortens the time, since it carries the player on while it fades.
    """
    time = 0.0
    speed = length(player.vx, player.vy)
    closing = max(speed, RUN.pace * player.top_speed)
    for _ in range(RUN.looks):
        lacks = short_of(player, speed, dx, dy, time)
        if lacks < RUN.near:
            break
        time += lacks / closing
        if time >= RUN.fades:
            return time + short_of(player, speed, dx, dy, time) / (RUN.pace * player.top_speed)
    return time


@kernel
def is_too_far(ball, ahead, player, time):
    """Return whether the ball's path stays out of a player's reach within `time` s."""
    dx, dy = player.x - ball.x, player.y - ball.y
    share = (dx * ball.vx + dy * ball.vy) / max(ahead.speed * ahead.speed, 1e-9)
    share = min(max(share, 0.0), ahead.lasts)
    dx, dy = dx - share * ball.vx, dy - share * ball.vy
    most = max(length(player.vx, player.vy), RUN.pace * player.top_speed)
    reach = most * (time + RUN.tick) + RUN.leg + RUN.foot + RUN.near + SURE
    return dx * dx + dy * dy > reach * reach


@kernel
def find_chasers(match):
    """Find each team's first player at the ball (the carrier, or the one with the least meeting time) and its time."""
    ball, ahead = match.ball, look_ahead(match.ball)
    lasts = match.chaser[LEFT], match.chaser[RIGHT]
    for team in (LEFT, RIGHT):
        match.chaser[team], match.arrival[team] = NOBODY, NEVER
        if lasts[team] != NOBODY:  # it mostly stays the first, so the others are quickly ruled out
            consider_chaser(match, lasts[team], ahead)
    for i in range(match.num_players):
        player = match.players[i]
        last = lasts[LEFT] if player.team == LEFT else lasts[RIGHT]
        if last == i and match.carrier != i:
            continue
        if match.carrier == i or not is_too_far(ball, ahead, player, match.arrival[player.team]):
            consider_chaser(match, i, ahead)


@kernel
def consider_chaser(match, i, ahead):
    """Make player i the team's chaser if sooner than the present chaser at the ball with the prediction `ahead`."""
    player = match.players[i]
    chaser, soonest = match.chaser[player.team], match.arrival[player.team]
    time = 0.0
    if match.carrier != i:
        time = time_if_before(match.ball, ahead, player, soonest - player.down_wait) + player.down_wait
    if match.carrier == i or time < soonest or (time == soonest and i < chaser):
        match.chaser[player.team], match.arrival[player.team] = i, time


@kernel
def time_to_meet(match, i, ahead):
    """Return `meeting_time` of player i in s; for chasers it is stored."""
    player = match.players[i]
    if match.chaser[player.team] == i and match.carrier != i and player.down_wait == 0.0:
        return match.arrival[player.team]
    return meeting_time(match.ball, ahead, player)


@kernel
def man_on_ball(match, team):
    """Return the player of `team` who has the ball or will be first of the team at it, -1 none."""
    i = match.carrier
    if i != NOBODY and match.players[i].team == team:
        return i
    return match.chaser[team]


@kernel
def first_at_ball(match):
    """Return the player who has the ball or will be first at it; -1 if both teams are equally near."""
    return NOBODY if match.team_in_possession == NOBODY else man_on_ball(match, match.team_in_possession)


@kernel
def update_possession(match):
    """Update the owner of the ball after a step, by GRF's definition, and the flag of a possession change."""
    if match.carrier != NOBODY and match.keeper_holding == NOBODY:
        carrier = match.players[match.carrier]
        if apart(match.ball, carrier) > CARRIED_WITHIN:
            match.carrier = NOBODY
    match.reported_owner = NOBODY
    if match.keeper_holding != NOBODY:
        match.reported_owner = match.keeper_holding
    elif match.last_touch != NOBODY and has_moved(match) and owns(match.ball, match.players[match.last_touch]):
        match.reported_owner = match.last_touch
    compare_owner(match)


@kernel
def has_moved(match):
    """Return whether the ball has been played at all; before its first movement it has no reported owner."""
    ball = match.ball
    return match.last_owned_team != NOBODY or length(ball.x - match.ball_start_x, ball.y - match.ball_start_y) > PLAYED


@kernel
def own_at_restart(match):
    """Report no owner while play is stopped, except a player who holds the ball for a throw-in."""
    match.reported_owner = match.taker if match.game_mode == THROW_IN else NOBODY
    compare_owner(match)


@kernel
def compare_owner(match):
    """Detect whether another team than that of the last owner owns the ball; without an owner nothing changes."""
    match.possession_changed = False
    if match.reported_owner != NOBODY:
        team = match.players[match.reported_owner].team
        match.possession_changed = match.last_owned_team != NOBODY and match.last_owned_team != team
        match.last_owned_team = team


@kernel
def owns(ball, player):
    """Return whether the last player at the ball possesses it: near, low and hardly faster than the player."""
    dx = ball.x - player.x - OWNED.lead * player.vx - OWNED.ahead * player.facing_x
    dy = ball.y - player.y - OWNED.lead * player.vy - OWNED.ahead * player.facing_y
    slip_x, slip_y = ball.vx - player.vx, ball.vy - player.vy
    return (
        ball.z < OWNED.below
        and dx * dx + dy * dy < OWNED.within * OWNED.within
        and slip_x * slip_x + slip_y * slip_y < OWNED.speed * OWNED.speed
    )


@kernel
def lose_ball(match):
    """Make the ball free; cancel a kick under way."""
    if match.kicker != NOBODY:
        forget_kick(match.players[match.kicker])
    match.carrier = NOBODY
    match.keeper_holding = NOBODY
    match.kicker = NOBODY


@kernel
def forget_kick(player):
    """Clear a player's kick."""
    player.kick, player.kick_held, player.kick_wait = 0, 0, 0.0
    player.kick_ready, player.is_aimed, player.kick_mate = False, False, NOBODY


@kernel
def advance_timers(match):
    """Advance the timers of the players and of the last kick by one step."""
    match.kick_age += STEP
    for i in range(match.num_players):
        player = match.players[i]
        player.touch_wait = max(player.touch_wait - STEP, 0.0)
        player.down_wait = max(player.down_wait - STEP, 0.0)
        player.pushed *= PUSH.kept
        if player.touch_wait == 0.0:
            player.brings_down = False
        if player.down_wait == 0.0:
            player.is_sliding, player.is_slide_spent = False, False
