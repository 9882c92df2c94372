"""Who has the ball, and who can be first at it.

Read next: `control.actions`, which turns actions into wanted velocities and kicks.
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

    lead: float = 0.05  # s: from where he will be then,
    ahead: float = 0.1  # m, and a little before him
    within: float = 1.0  # m to the ball
    below: float = 0.5  # m, its height
    speed: float = 6.0  # m/s, relative to him


class Chase(NamedTuple):
    """Estimates of who is soonest at the ball."""

    over_heads: float = 1.3  # m, height of a ball that nobody reaches in its flight
    caught_at: float = 0.9  # m, height at which he then does
    landed: float = 0.6  # share of its speed that a ball keeps when it comes down


class Run(NamedTuple):
    """How the original reckons how long somebody needs to a place."""

    leg: float = 0.28  # m that he need not run,
    foot: float = 0.1  # m, and the ball before his foot,
    stands: float = 1.8  # m/s: where he runs, if he is faster, or else where he is to go
    fades: float = 0.7  # s in which his run fades, and his reach grows, the faster the longer, to
    pace: float = 0.94  # share of his top speed
    tick: float = 0.01  # s that he runs on before that
    looks: int = 12  # how often it is looked at, at most
    near: float = 0.01  # m that he may be short of the ball
    least: float = 0.1  # share of the greatest speed at which they near each other, that is reckoned with at least
    longest: float = 3.0  # s for which the ball is looked ahead
    far_run: float = 0.2  # s of his run, and
    far_pace: float = 0.75  # share of his top speed, by which it is reckoned then
    at_hand: float = 0.1  # s: a ball that he reaches sooner is the sooner his, the nearer it is by then than
    hand: float = 0.6  # m


class Ahead(NamedTuple):
    """How the ball goes on while nobody touches it: the same for all who run for it, so it is worked out once."""

    speed: float  # m/s, in the plane
    flight: float  # s until it comes down to the players
    air: float  # m that it flies until then
    left: float  # m/s at which it then rolls on
    lasts: float  # s in which it would come to rest at its present speed: how far it gets


# Ownership is Google Research Football's own measure; the estimates are checked by `regista benchmark --suite grf`,
# family matches.
OWNED, CHASE, RUN = Owned(), Chase(), Run()
PLAYED = 0.05  # m from where the ball lay when the match began: it has been touched
CARRIED_WITHIN = 3.0  # m: further away, a led ball has been lost
SURE = 1e-6  # m, more than rounding makes of distances
NEVER = 100.0  # s until a team without players is at the ball


@kernel
def ball_speed(ball):
    """Return the speed of the ball in m/s in the plane."""
    return length(ball.vx, ball.vy)


@kernel
def fall_time(ball):
    """Time in s until a ball that flies over the players comes down to them; 0 for one that stays low."""
    if ball.vz * ball.vz + 2.0 * AIR.gravity * ball.z < 2.0 * AIR.gravity * CHASE.over_heads:
        return 0.0
    return (
        ball.vz + math.sqrt(max(ball.vz * ball.vz + 2.0 * AIR.gravity * (ball.z - CHASE.caught_at), 0.0))
    ) / AIR.gravity


@kernel
def travelled(ahead, time):
    """Estimate in m how far a ball that goes on as it is seen `ahead` gets in `time` s."""
    if time < ahead.flight:
        return flown(ahead.speed, time)[0]
    return ahead.air + rolled(ahead.left, time - ahead.flight)


@kernel
def flown(speed, flight):
    """Estimate in m how far a ball flies in `flight` s, and with which speed in m/s it then goes on."""
    if flight == 0.0:
        return 0.0, speed
    drag = 1.0 + AIR.drag * speed * flight
    return math.log(drag) / AIR.drag, CHASE.landed * speed / drag


@kernel
def look_ahead(ball):
    """Estimate how the ball goes on."""
    speed, flight = ball_speed(ball), fall_time(ball)
    air, left = flown(speed, flight)
    return Ahead(speed, flight, air, left, (air + rolled(left, math.inf)) / max(speed, 1e-9))


@kernel
def meeting_time(ball, ahead, player):
    """Estimate in s how soon a player can play the ball, which goes on as it is seen `ahead` meanwhile, as the original
    reckons: his run carries him on while it fades, and a circle that he reaches grows around where he is.
    """
    return time_if_before(ball, ahead, player, math.inf)


@kernel
def time_if_before(ball, ahead, player, latest):
    """Return `meeting_time`, or if that is later than `latest` s any later time.

    Found by the secant method; what does not change on the way is worked out before, for this is asked very often.
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
        if look > 0:  # as fast as seen over the last step, but it never stands still
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
    """Return by how many s of his run a player who runs at `speed` m/s is reckoned to be further on, and his reach in
    m.
    """
    if speed > RUN.stands:
        return RUN.foot / speed + RUN.tick, RUN.leg
    return 0.0, RUN.leg + RUN.foot


@kernel
def short_of(player, speed, dx, dy, time):
    """Return how many m a player, who runs at `speed` m/s, is short of a place (dx, dy) m away after `time` s."""
    fading = min(time, RUN.fades)
    run = fading - 0.5 * fading * fading / RUN.fades
    on, reach = stands_at(speed)
    on += run
    return length(dx - on * player.vx, dy - on * player.vy) - reach - RUN.pace * player.top_speed * (time - run)


@kernel
def far_time(ball, ahead, player):
    """Return in how many s at least a player is at a ball that he does not reach within the time looked ahead."""
    share = travelled(ahead, RUN.longest) / (ahead.speed + 1e-9)
    dx = ball.x + share * ball.vx - player.x - RUN.far_run * player.vx
    dy = ball.y + share * ball.vy - player.y - RUN.far_run * player.vy
    return max(length(dx, dy) / (RUN.far_pace * player.top_speed), RUN.longest)


@kernel
def time_needed(player, dx, dy):
    """Return in how many s a player can have a ball that lies (dx, dy) m away, as the original reckons: the sooner the
    more his run leads there, for that carries him on while it fades.
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
    """Return whether no place that the ball still comes to is near enough for a player to be there in `time` s."""
    dx, dy = player.x - ball.x, player.y - ball.y
    share = (dx * ball.vx + dy * ball.vy) / max(ahead.speed * ahead.speed, 1e-9)
    share = min(max(share, 0.0), ahead.lasts)
    dx, dy = dx - share * ball.vx, dy - share * ball.vy
    most = max(length(player.vx, player.vy), RUN.pace * player.top_speed)
    reach = most * (time + RUN.tick) + RUN.leg + RUN.foot + RUN.near + SURE
    return dx * dx + dy * dy > reach * reach


@kernel
def find_chasers(match):
    """Find for each team the player who can be first at the ball, the carrier or by meeting time, and how soon."""
    ball, ahead = match.ball, look_ahead(match.ball)
    lasts = match.chaser[LEFT], match.chaser[RIGHT]
    for team in (LEFT, RIGHT):
        match.chaser[team], match.arrival[team] = NOBODY, NEVER
        if lasts[team] != NOBODY:  # who mostly still is: then all the others are seen to be too far away
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
    """Make player i his team's chaser if he is sooner at the ball, as it goes on `ahead`, than who is so far."""
    player = match.players[i]
    chaser, soonest = match.chaser[player.team], match.arrival[player.team]
    time = 0.0
    if match.carrier != i:
        time = time_if_before(match.ball, ahead, player, soonest - player.down_wait) + player.down_wait
    if match.carrier == i or time < soonest or (time == soonest and i < chaser):
        match.chaser[player.team], match.arrival[player.team] = i, time


@kernel
def time_to_meet(match, i, ahead):
    """Return `meeting_time` of player i in s, which is known of those who have just been found to be chasers."""
    player = match.players[i]
    if match.chaser[player.team] == i and match.carrier != i and player.down_wait == 0.0:
        return match.arrival[player.team]
    return meeting_time(match.ball, ahead, player)


@kernel
def man_on_ball(match, team):
    """Return the player of `team` who has the ball or will be first of his team at it, -1 none."""
    i = match.carrier
    if i != NOBODY and match.players[i].team == team:
        return i
    return match.chaser[team]


@kernel
def first_at_ball(match):
    """Return the player who has the ball or will be first at it, -1 while both teams are equally near."""
    return NOBODY if match.team_in_possession == NOBODY else man_on_ball(match, match.team_in_possession)


@kernel
def update_possession(match):
    """Decide who owns the ball after a step, as the original reports it, and whether possession changed."""
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
    """Return whether the ball has been played at all: until it leaves its place nobody is reported to own it."""
    ball = match.ball
    return match.last_owned_team != NOBODY or length(ball.x - match.ball_start_x, ball.y - match.ball_start_y) > PLAYED


@kernel
def own_at_restart(match):
    """Report nobody as owner while play is stopped, but who holds the ball for a throw-in."""
    match.reported_owner = match.taker if match.game_mode == THROW_IN else NOBODY
    compare_owner(match)


@kernel
def compare_owner(match):
    """Find out whether another team owns the ball than the last that did; without an owner nothing changes."""
    match.possession_changed = False
    if match.reported_owner != NOBODY:
        team = match.players[match.reported_owner].team
        match.possession_changed = match.last_owned_team != NOBODY and match.last_owned_team != team
        match.last_owned_team = team


@kernel
def owns(ball, player):
    """Return whether the last player at the ball possesses it: near, low and hardly faster than he is."""
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
    """Make the ball free; who was about to kick it no longer is."""
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
    """Let the clocks of the players and of the last kick run by one step."""
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
