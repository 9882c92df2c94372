"""The built-in goalkeeper: positioning, leaving the goal, and kick-outs.

As documented by Google Research Football. Read next: `skills.saves`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    GOAL_HALF_WIDTH,
    HALF_LENGTH,
    HIGH_PASS,
    NOBODY,
    RUN_SPEED,
)
from regista.envs.football.physics.ball import MEAN_DRAG
from regista.envs.football.physics.pitch import forward, own_goal_x
from regista.envs.football.physics.possession import fall_time, look_ahead, man_on_ball, time_to_meet, travelled
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.skills.hands import HOLD_STEPS, has_hands
from regista.envs.football.skills.saves import dive
from regista.envs.football.skills.steering import chase, slide
from regista.kernels.jit import kernel


class Stand(NamedTuple):
    """Where a keeper waits."""

    high_line: float = 10.0  # m in front of the goal line while the ball is in the other half
    foot: float = 0.7  # m in front of the goal line, the start of the line to the ball on which the keeper stands
    least: float = 0.7  # m from this start, at least
    urgency: float = 2.6  # 1/s, desired speed per m of distance
    still: float = 0.5  # m/s; at a lower desired speed the keeper stands
    on_way: float = 1.0  # m off the way to the ball, within which the keeper runs back facing the ball
    advance: float = 0.3  # share of the way to the ball while the keeper's team has it


class ComeOut(NamedTuple):
    """Parameters for when a keeper leaves the goal, and how far."""

    claim_margin: float = 0.15  # s by which the keeper must be first at a loose ball
    claim_range: float = 30.0  # m from the goal line to a loose ball, at most
    shot_from: float = 20.0  # m to the goal; an opponent on the ball shoots from there
    second_shot_from: float = 24.0  # m, the same for another opponent
    rival_lead: float = 0.32  # s by which opponents' runs are extrapolated
    mate_lead: float = 0.24  # s by which teammates' runs are extrapolated
    ball_lead: float = 0.6  # s by which the ball is extrapolated, at least,
    ball_lead_more: float = 0.2  # s, and per s of the keeper's time to the ball
    committed: float = 5.0  # m to a led ball, within which the keeper continues despite teammates
    too_late: float = 1.0  # m; a teammate further from the shooting position than the opponent by this is too late
    second_share: float = 0.7  # share of the way out that another free attacker at equal distance removes
    on_ball: float = 0.6  # weight of the ball against the opponent who has it
    off_ball: float = 0.4  # the same against the opponent who will have it
    stops_short: float = 0.5  # m by which the keeper stops short of the target
    slide_lead: float = 0.2  # s by which keeper and ball are extrapolated
    dive_lead: float = 0.35  # s, the same if the keeper may use hands
    slide_near: float = 1.2  # m between keeper and ball by then, within which the keeper dives at an opponent's ball
    dive_keeps: float = 0.9  # minimum share of the speed that the keeper keeps in such a step
    unshielded: float = 0.4  # cosine at the carrier between the ways to the ball and to the keeper, at least
    given_up: float = -0.4  # s, `save_wait` at which a shot is no longer expected


class SlideOut(NamedTuple):
    """When a keeper without hands slides at a carrier's feet, measured at the start of 19 slides."""

    lead: float = 0.2  # s by which keeper and ball are extrapolated
    nearest: float = 0.9  # m between them by then, at least
    farthest: float = 1.6  # m between them by then, at most
    body_nearest: float = 2.4  # m to the carrier, at least
    body_farthest: float = 3.8  # m to the carrier, at most
    frontal: float = 0.85  # cosine at the carrier between the ways to the ball and to the keeper, at least
    fresh: float = 0.15  # s since the carrier's touch, at most, so that the carrier cannot reach the ball sooner


class KickOut(NamedTuple):
    """Kick-outs: their receiver and their time."""

    free: float = 10.0  # m; a teammate with no opponent within this distance is free
    least: float = 8.0  # m to a free teammate
    most: float = 40.0  # m to a free teammate, at most
    longest: float = 40.0  # steps, after which the ball goes to the nearest teammate
    overdue: float = 30.0  # steps after which a commanded keeper kicks out automatically
    lead: float = 0.4  # s by which a teammate's run is extrapolated
    upfield: float = 30.0  # m, length of a kick upfield without a teammate


# Documented by Google Research Football; lead times are fitted: `lab.benchmarks --suite grf`, family keeper.
STAND, OUT, SLIDE_OUT, KICK_OUT = Stand(), ComeOut(), SlideOut(), KickOut()
FARTHEST_ROLL = 1.0 / MEAN_DRAG  # m; `rolled` gives at most half of it


@kernel
def choose_keeper_command(match, i):
    """Decide for keeper i."""
    player = match.players[i]
    if match.saver == i and match.save_wait < OUT.given_up:
        match.saver = NOBODY  # the shot did not arrive: wide, off the post, or too slow
    if match.keeper_holding == i:
        player.desired_vx, player.desired_vy = 0.0, 0.0
        match.hold_wait -= 1
        if player.kick == 0 and match.hold_wait < 0:
            distribute(match, i)
    elif match.saver == i:
        dive(match, player)
    elif match.carrier == i:
        kick_out(match, i)
    elif goes_for_loose_ball(match, i):
        chase(match, i, player.top_speed)
    elif slides_out(match, i):
        lunge(match, i)
    elif throws_himself(match, i):
        throw(match, i)
    else:
        share = boldness(match, i)
        if share > 0.0:
            come_out(match, i, share)
        else:
            stand(match, i)


@kernel
def kick_out_if_overdue(match, i):
    """Make a commanded keeper kick the ball out after holding it for too long."""
    if match.keeper_holding == i:
        match.hold_wait -= 1
        if match.hold_wait < -KICK_OUT.overdue and match.players[i].kick == 0:
            kick_out(match, i)


@kernel
def distribute(match, i):
    """Kick the ball out once the nearest teammate is free, or after holding it for too long."""
    mate = nearest_mate(match, i, 0.0)
    if mate == NOBODY or not opposed(match, mate, KICK_OUT.free) or match.hold_wait < HOLD_STEPS - KICK_OUT.longest:
        kick_out(match, i)


@kernel
def kick_out(match, i):
    """Kick or throw the ball high to the nearest free teammate at a distance, else to the nearest, else upfield."""
    player = match.players[i]
    ahead = forward(player.team)
    player.aim_x, player.aim_y = player.x + ahead * KICK_OUT.upfield, player.y
    j = nearest_mate(match, i, KICK_OUT.free)
    if j == NOBODY or apart(match.players[j], player) > KICK_OUT.most:
        j = nearest_mate(match, i, 0.0)
    if j != NOBODY:
        mate = match.players[j]
        player.aim_x, player.aim_y = mate.x + KICK_OUT.lead * mate.vx, mate.y + KICK_OUT.lead * mate.vy
    player.kick, player.kick_held, player.kick_ready, player.is_aimed = HIGH_PASS, 1, True, True
    player.kick_mate = j


@kernel
def nearest_mate(match, i, free):
    """Return player i's nearest teammate with no opponent within `free` m who is not too close; -1 if none."""
    player = match.players[i]
    best, nearest = NOBODY, math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        distance = apart(mate, player)
        if j == i or mate.team != player.team or mate.has_left:
            continue
        if KICK_OUT.least < distance < nearest and not opposed(match, j, free):
            best, nearest = j, distance
    return best


@kernel
def opposed(match, j, within):
    """Return whether player j has an opponent within `within` m."""
    player = match.players[j]
    for k in range(match.num_players):
        rival = match.players[k]
        if rival.team != player.team and apart(rival, player) < within:
            return True
    return False


@kernel
def goes_for_loose_ball(match, i):
    """Return whether keeper i, first at a loose ball, leaves the goal for it."""
    player, ball = match.players[i], match.ball
    goal_x = own_goal_x(player.team)
    if match.carrier != NOBODY:
        return False
    if ball.x * goal_x <= 0.0:
        return match.last_touch != NOBODY and lone(match, i)
    if abs(goal_x - ball.x) > OUT.claim_range * match.engine.keeper_range or match.chaser[player.team] != i:
        return lone(match, i)
    rival = match.chaser[1 - player.team]
    if rival == NOBODY:
        return True
    ahead = look_ahead(ball)
    return time_to_meet(match, i, ahead) + OUT.claim_margin < time_to_meet(match, rival, ahead)


@kernel
def throws_himself(match, i):
    """Return whether a carrier's ball is about to come into keeper i's reach, with no body in between."""
    player, ball = match.players[i], match.ball
    if match.carrier == NOBODY or match.players[match.carrier].team == player.team:
        return False
    carrier = match.players[match.carrier]
    lead = OUT.dive_lead if has_hands(match, i) else OUT.slide_lead
    x, y = player.x + lead * player.vx, player.y + lead * player.vy
    if length(ball.x + lead * ball.vx - x, ball.y + lead * ball.vy - y) >= OUT.slide_near:
        return False
    to_x, to_y = toward(x - carrier.x, y - carrier.y)
    ball_x, ball_y = toward(ball.x - carrier.x, ball.y - carrier.y)
    return to_x * ball_x + to_y * ball_y > OUT.unshielded


@kernel
def slides_out(match, i):
    """Return whether keeper i, without hands, slides at the feet of an opponent after a touch; agents' teams do not."""
    player, ball = match.players[i], match.ball
    if match.carrier == NOBODY or match.num_agents[player.team] != 0 or player.down_wait > 0.0 or has_hands(match, i):
        return False
    carrier = match.players[match.carrier]
    if carrier.team == player.team or not 0.0 <= carrier.stride < SLIDE_OUT.fresh:
        return False
    lead = SLIDE_OUT.lead
    away_x = ball.x - player.x + lead * (ball.vx - player.vx)
    away_y = ball.y - player.y + lead * (ball.vy - player.vy)
    if not SLIDE_OUT.body_nearest < apart(player, carrier) < SLIDE_OUT.body_farthest:
        return False
    if not SLIDE_OUT.nearest < length(away_x, away_y) < SLIDE_OUT.farthest:
        return False
    to_x, to_y = toward(player.x + lead * player.vx - carrier.x, player.y + lead * player.vy - carrier.y)
    ball_x, ball_y = toward(ball.x - carrier.x, ball.y - carrier.y)
    return to_x * ball_x + to_y * ball_y > SLIDE_OUT.frontal


@kernel
def lunge(match, i):
    """Start a slide of keeper i to where the ball will be played next."""
    player, ball, lead = match.players[i], match.ball, SLIDE_OUT.lead
    carrier = match.players[match.carrier]
    to_x = ball.x - player.x + lead * (ball.vx - player.vx + carrier.vx)
    to_y = ball.y - player.y + lead * (ball.vy - player.vy + carrier.vy)
    player.facing_x, player.facing_y = toward(to_x, to_y)
    player.desired_vx, player.desired_vy = player.top_speed * player.facing_x, player.top_speed * player.facing_y
    slide(match, i)
    speed = length(player.vx, player.vy)
    player.vx, player.vy = speed * player.facing_x, speed * player.facing_y


@kernel
def throw(match, i):
    """Run to the point where keeper i meets the ball; a dive does not stop there."""
    player = match.players[i]
    chase(match, i, player.top_speed)
    want, speed = length(player.desired_vx, player.desired_vy), OUT.dive_keeps * length(player.vx, player.vy)
    if 0.0 < want < speed and has_hands(match, i):
        player.desired_vx, player.desired_vy = speed / want * player.desired_vx, speed / want * player.desired_vy


@kernel
def lone(match, i):
    """Return whether keeper i is alone in the team; such a keeper goes for every loose ball once play has begun."""
    mates = 0
    for j in range(match.num_players):
        mates += match.players[j].team == match.players[i].team and not match.players[j].has_left
    return mates == 1


@kernel
def boldness(match, i):
    """Return the share of the way to the ball by which keeper i comes out to an opponent about to shoot.

    It is 0 if a teammate can stop the opponent, 1 if only that opponent is dangerous, and less if another opponent is
    near.
    """
    team = match.players[i].team
    goal_x = own_goal_x(team)
    first = man_on_ball(match, 1 - team)
    if match.ball.x * goal_x <= 0.0 or match.team_in_possession == team or first == NOBODY:
        return 0.0
    way, mate_way = ways_to_shot(match, i, first, OUT.shot_from)
    committed = match.carrier != NOBODY and apart(match.ball, match.players[i]) < OUT.committed
    if mate_way <= way + OUT.too_late and not committed:
        return 0.0
    second = nearest_to_goal(match, 1 - team, first)
    if second == NOBODY:
        return 1.0
    second_way, second_mate_way = ways_to_shot(match, i, second, OUT.second_shot_from)
    free = min(max(0.5 * (second_mate_way - second_way), 0.0), 1.0)
    close = 1.0 - min(max(2.0 * (second_way / (way + 1e-4) - 1.0), 0.0), 1.0)
    return 1.0 - free * OUT.second_share * close


@kernel
def ways_to_shot(match, i, j, range_of_shot):
    """Return the distances in m of opponent j and of keeper i's nearest teammate from the shooting position."""
    rival = match.players[j]
    goal_x = own_goal_x(match.players[i].team)
    x, y = rival.x + OUT.rival_lead * rival.vx, rival.y + OUT.rival_lead * rival.vy
    to_goal = length(goal_x - x, y) + 1e-9
    way = max(to_goal - range_of_shot * min(to_goal / (2.0 * range_of_shot), 1.0), 0.0)
    x, y = x + way / to_goal * (goal_x - x), y * (1.0 - way / to_goal)
    nearest = math.inf
    for k in range(match.num_players):
        mate = match.players[k]
        if k != i and mate.team != rival.team and not mate.has_left:
            nearest = min(nearest, length(mate.x + OUT.mate_lead * mate.vx - x, mate.y + OUT.mate_lead * mate.vy - y))
    return way, nearest


@kernel
def nearest_to_goal(match, team, but):
    """Return the player of `team`, except `but`, nearest to the goal that the team attacks; -1 if none."""
    goal_x = -own_goal_x(team)
    best, least = NOBODY, math.inf
    for j in range(match.num_players):
        player = match.players[j]
        if player.team != team or j == but or player.has_left:
            continue
        distance = length(goal_x - player.x, player.y)
        if distance < least:
            best, least = j, distance
    return best


@kernel
def come_out(match, i, share):
    """Run this share of the way from the goal to where the opponent on the ball will soon be."""
    player = match.players[i]
    rival = match.players[man_on_ball(match, 1 - player.team)]
    weight = OUT.on_ball if match.carrier != NOBODY else OUT.off_ball
    ball_x, ball_y = led_ball(match, i)
    to_x = weight * ball_x + (1.0 - weight) * (rival.x + OUT.rival_lead * rival.vx)
    to_y = weight * ball_y + (1.0 - weight) * (rival.y + OUT.rival_lead * rival.vy)
    guard_goal(player, ball_x, ball_y, to_x, to_y, min(share * match.engine.keeper_range, 1.0))


@kernel
def stand(match, i):
    """Stand on the bisector of the angle from the ball to the posts, or high up the pitch while the ball is far."""
    player = match.players[i]
    goal_x = own_goal_x(player.team)
    x, y = match.ball.x, match.ball.y
    near = x * goal_x > -HALF_LENGTH * FARTHEST_ROLL or fall_time(match.ball) > 0.0
    if x * goal_x > 0.0 or (near and match.ball.vx * goal_x > 0.0):  # otherwise the ball stays in the other half
        x, y = led_ball(match, i)
    if x * goal_x <= 0.0:
        hurry_to(player, goal_x - math.copysign(STAND.high_line, goal_x), 0.0, player.top_speed)
        return
    held = min(max(2.0 * (match.hold[player.team] - 1.0), 0.0), 1.0)
    guard_goal(player, x, y, x, y, STAND.advance * held)


@kernel
def led_ball(match, i):
    """Return where keeper i expects the ball, extrapolated along its roll or flight."""
    ball, ahead = match.ball, look_ahead(match.ball)
    time = OUT.ball_lead + OUT.ball_lead_more * time_to_meet(match, i, ahead)
    share = travelled(ahead, time) / max(ahead.speed, 1e-9)
    return ball.x + share * ball.vx, ball.y + share * ball.vy


@kernel
def guard_goal(player, ball_x, ball_y, to_x, to_y, share):
    """Start on the bisector of the angle from the ball to the posts, and go a share of the way to a point.

    On the way back towards the goal the keeper only runs instead of sprinting, unless the point is behind.
    """
    goal_x = own_goal_x(player.team)
    foot_x = goal_x - math.copysign(STAND.foot, goal_x)
    middle = bisector_foot(ball_x - goal_x, ball_y)  # on the goal line
    before = STAND.foot / max(abs(goal_x - ball_x), STAND.foot)  # the same share of the way from there to the ball
    foot_y = min(max(middle + before * (ball_y - middle), -GOAL_HALF_WIDTH), GOAL_HALF_WIDTH)
    dx, dy = to_x - foot_x, to_y - foot_y
    way = length(dx, dy) + 1e-9
    out = max(share * (way - OUT.stops_short), STAND.least) / way
    x, y = foot_x + out * dx, foot_y + out * dy
    off = abs(dx * (player.y - foot_y) - dy * (player.x - foot_x)) / way
    back = length(goal_x - x, y) < length(goal_x - player.x, player.y)
    back = back and (to_x - player.x) * dx + (to_y - player.y) * dy > 0.0
    hurry_to(player, x, y, RUN_SPEED if back and off < STAND.on_way else player.top_speed)


@kernel
def hurry_to(player, x, y, most):
    """Desire a velocity towards a point, proportional to the distance and limited to `most`."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy)
    speed = min(STAND.urgency * distance, most)
    share = speed / distance if speed > STAND.still else 0.0
    player.desired_vx, player.desired_vy = share * dx, share * dy


@kernel
def bisector_foot(dx, y):
    """Return the y at which the bisector of the angle from a ball at (dx, y) to both posts meets the goal line."""
    near, far = length(dx, y - GOAL_HALF_WIDTH), length(dx, y + GOAL_HALF_WIDTH)
    return GOAL_HALF_WIDTH * (far - near) / (far + near + 1e-9)
