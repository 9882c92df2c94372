"""Built-in players against an opponent: stay between opponent and goal, press, tackle, and keep the line.

As measured in Google Research Football, a lone defender retreats before a carrier and stays between carrier and goal.
It attacks the ball only near it or near the own goal. Read next: `ai.positions`, which combines all this; `ai.keeper`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.attack import run_by_forces
from regista.envs.football.ai.formation import LINE, MINDSET, between
from regista.envs.football.ai.run_speed import go, reaction_time
from regista.envs.football.constants import HALF_LENGTH, LEFT, NOBODY, RIGHT
from regista.envs.football.physics.pitch import forward, own_goal_x
from regista.envs.football.physics.possession import look_ahead, man_on_ball, meeting_time, travelled
from regista.envs.football.physics.vectors import apart, length, squared_apart, toward
from regista.envs.football.skills.steering import AWAIT, await_ball, go_for_ball, slide
from regista.kernels.jit import kernel


class Duel(NamedTuple):
    """Going for a carrier's ball: tackles and slides."""

    slide_near: float = 0.7  # m to the ball at least, for a slide
    slide_far: float = 1.6  # m at most
    slide_cosine: float = 0.7  # cosine of the angle to the ball
    slide_loose: float = 1.4  # m from the carrier to the ball, for which the carrier needs more than 0.26 s
    tackle_range: float = 2.0  # m to the ball, for a tackle
    coming: float = 1.5  # m/s at which the ball must approach


class Race(NamedTuple):
    """A race to a carrier's ball: speed fades while a circle of reach grows around the player, as in `Run`."""

    longest: float = 1.5  # s; a player who needs longer does not go for the ball
    nearest: float = 12.0  # m to the ball; a player further away does not either
    on_his_way: float = 0.3  # s since the carrier's last touch; after that, the carrier's next touch is expected
    touches_every: float = 0.7  # s between touches of the carrier
    in_time: float = 0.99  # minimum ratio of the carrier's time to the player's, with `patience`
    patience: float = 0.2  # s added to both times


class Guard(NamedTuple):
    """Parameters for staying between an opponent and the goal."""

    lead: float = 0.5  # s, minus the reaction time, by which the opponent's run is extrapolated
    own_lead: float = 0.14  # s by which the player's own run is extrapolated
    shot_from: float = 24.0  # m to the goal; the opponent on the ball shoots from there
    danger_from: float = 8.0  # m to the goal, at which other opponents are dangerous
    nearest: float = 0.4  # m in front of the opponent, at least
    buffer: float = 4.0  # m by which the guard is nearer to the expected place of the shot than the opponent
    late: float = 0.7  # m by which a late guard falls back, per m of delay
    rounds_from: float = 3.0  # m to an opponent on the way back, within which the player runs around this opponent
    clear_by: float = 1.5  # m beside the opponent
    abreast: float = 0.3  # m ahead along the way; a nearer opponent is abreast
    most: tuple[float, ...] = (1.9, 1.5, 1.3)  # how much backs, midfielders, forwards guard, less their possession
    curve: float = 0.7


class Meet(NamedTuple):
    """Where a presser meets the opponent on the way to the goal."""

    stride: float = 0.8  # m beyond the point at equal distance to both
    lead: float = 0.14  # s by which the opponent's run is extrapolated
    deep: float = 0.5  # m of the player behind the meeting point that do not count; each further m
    wide: float = 0.8  # allows this many m aside, before the presser must move


class DefensiveLine(NamedTuple):
    """The defensive line, which limits how far players fall back without the ball."""

    start: float = 40.0  # m from the own goal to the line, at most
    force: float = 6.0  # m from the own goal to the last position in which the line is held
    fall_back: float = 25.0  # m in front of the ball, while it is far
    future: float = 0.7  # s by which the ball is extrapolated
    caution: float = 4.0  # m in front of the opponent on the ball
    rival_lead: float = 0.15  # s by which that opponent's run is extrapolated
    slack: float = 4.0  # m that a teammate may be behind the line
    seen_lead: float = 0.24 - 0.11  # s by which opponents extrapolate runs, seen with a delay of a reaction time
    soft: float = 2.0  # m in front of the line in which positions are compressed


# Documented by Google Research Football; families tackles, academy and matches of `lab.benchmarks --suite grf`.
DUEL, RACE, GUARD, MEET, DEFENSIVE_LINE = Duel(), Race(), Guard(), Meet(), DefensiveLine()


@kernel
def tackles(match, player):
    """Return whether a player in front of an opponent's approaching ball tries to win it.

    A marker of the carrier waits until the carrier is close to the shooting position.
    """
    ball = match.ball
    dx, dy = ball.x - player.x, ball.y - player.y
    if match.carrier == NOBODY or dx * dx + dy * dy > DUEL.tackle_range * DUEL.tackle_range:
        return False
    if player.marked_opponent == match.carrier:
        carrier = match.players[match.carrier]
        if length(own_goal_x(player.team) - carrier.x, carrier.y) > GUARD.shot_from + GUARD.buffer:
            return False
    coming = -(dx * ball.vx + dy * ball.vy) / (length(dx, dy) + 1e-9)
    return coming > DUEL.coming and forward(player.team) * dx > 0.0


@kernel
def goes_for_led_ball(match, i):
    """Let player i, the first of the team at a carrier's ball, go for it if not later than the carrier; return whether
    it does.

    In GRF only the team's designated player does so, even if it marks another opponent. For example, after each touch
    of a sprinter, a back 6 m in front is first at the ball for a moment. The back stops and waits for the ball.
    """
    player, ball = match.players[i], match.ball
    if match.carrier == NOBODY or match.keeper_holding != NOBODY or match.chaser[player.team] != i:
        return False
    carrier = match.players[match.carrier]
    if carrier.team == player.team or squared_apart(player, ball.x, ball.y) > RACE.nearest * RACE.nearest:
        return False
    ahead = look_ahead(ball)
    mine = meeting_time(ball, ahead, player)
    if mine >= RACE.longest:
        return False
    theirs = meeting_time(ball, ahead, carrier)
    if carrier.stride < 0.0:
        theirs = min(theirs, -carrier.stride)  # about to play the ball
    elif carrier.stride > RACE.on_his_way:
        theirs = min(theirs, max(RACE.touches_every - carrier.stride, 0.0))
    in_time = (theirs + RACE.patience) / (mine + RACE.patience)
    if in_time < RACE.in_time:
        return False
    if in_time < AWAIT.in_time or not awaits_carrier(match, player, mine):
        share = travelled(ahead, mine) / (ahead.speed + 1e-9)
        go(player, ball.x + share * ball.vx - player.x, ball.y + share * ball.vy - player.y, player.top_speed)
    return True


@kernel
def awaits_carrier(match, player, time):
    """Let a player who reaches a carrier's ball in `time` s, clearly before the carrier, wait for it on the carrier's
    path; return whether the ball comes closer.
    """
    run_by_forces(match, player)
    ux, uy = toward(player.desired_vx, player.desired_vy)
    return await_ball(match.ball, player, time, ux, uy)


@kernel
def tackle(match, i):
    """Run at a carrier's ball; slide if only a slide reaches it."""
    player = match.players[i]
    go_for_ball(match, i, player.top_speed)
    if may_slide(match, player):
        slide(match, i)


@kernel
def may_slide(match, player):
    """Return whether a slide reaches a ball that is loose for long enough; in teams with agents only agents slide."""
    ball, carrier = match.ball, match.players[match.carrier]
    if match.num_agents[player.team] != 0 or apart(ball, carrier) < DUEL.slide_loose:
        return False
    dx, dy = ball.x - player.x, ball.y - player.y
    distance = length(dx, dy)
    ahead = player.facing_x * dx + player.facing_y * dy
    return DUEL.slide_near < distance < DUEL.slide_far and ahead > DUEL.slide_cosine * distance


@kernel
def must_move(player, rival):
    """Return whether a player has to move to meet an opponent, who otherwise runs into the player.

    The meeting point is on the opponent's way to the goal, at equal distance from both or just beyond.
    """
    goal_x = own_goal_x(player.team)
    way_x, way_y = goal_x - rival.x, -rival.y
    to_x, to_y = player.x - rival.x, player.y - rival.y
    along = way_x * to_x + way_y * to_y
    share = min(0.5 * (to_x * to_x + to_y * to_y) / along, 1.0) if along > 1e-9 else 0.0
    share += MEET.stride / (length(way_x, way_y) + 1e-9)
    x = rival.x + share * way_x + MEET.lead * rival.vx
    y = rival.y + share * way_y + MEET.lead * rival.vy
    deep = max(forward(player.team) * (x - player.x), 0.0) - MEET.deep
    return abs(y - player.y) > MEET.wide * deep


@kernel
def guard_share(match, player):
    """Return how closely a player guards the marked opponent, 0 to 1: more with less possession."""
    attacker = MINDSET[match.players[player.post].role]
    share = GUARD.most[LINE[player.role]] - attacker - match.hold[player.team]
    return share**GUARD.curve if 0.0 < share < 1.0 else min(max(share, 0.0), 1.0)


@kernel
def guarding_place(match, player, x, y):
    """Return the position in which a player with slot (x, y) guards the marked opponent: near that opponent's shooting
    position.

    The opponent's position is extrapolated far enough for a guard to retreat from a sprinter instead of colliding.
    """
    rival = match.players[player.marked_opponent]
    goal_x = own_goal_x(player.team)
    lead = GUARD.lead - reaction_time(player)
    from_x, from_y = rival.x + lead * rival.vx, rival.y + lead * rival.vy
    to_goal = length(goal_x - from_x, from_y) + 1e-9
    on_ball = player.marked_opponent == man_on_ball(match, rival.team) and match.team_in_possession == rival.team
    way = min(max(to_goal - (GUARD.shot_from if on_ball else GUARD.danger_from), GUARD.nearest), HALF_LENGTH)
    ahead, line = forward(player.team), match.trap[player.team]
    if ahead * (from_x + way / to_goal * (goal_x - from_x)) < line:
        way = to_goal * (ahead * line - from_x) / (goal_x - from_x + math.copysign(1e-9, goal_x))
    spot_x, spot_y = from_x + way / to_goal * (goal_x - from_x), from_y * (1.0 - way / to_goal)
    way = abs(way)  # the crossing point, for an opponent who has passed the line
    off = length(spot_x - x, spot_y - y) + 1e-9
    share = min(max(off - way + GUARD.buffer, 0.0) / off, 1.0)
    x, y = x + share * (spot_x - x), y + share * (spot_y - y)
    late = length(spot_x - player.x - GUARD.own_lead * player.vx, spot_y - player.y - GUARD.own_lead * player.vy) - way
    if late > 0.0:
        back = GUARD.late * late / (length(goal_x - x, y) + 1e-9)
        x, y = x + back * (goal_x - x), y * (1.0 - back)
    return x, y


@kernel
def run_round(player, rival, x, y):
    """Run around an opponent on the way to (x, y); return whether there is one."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    to_x, to_y = rival.x - player.x, rival.y - player.y
    along, across = (to_x * dx + to_y * dy) / distance, (to_x * dy - to_y * dx) / distance
    if not GUARD.abreast < along < min(distance, GUARD.rounds_from) or abs(across) > GUARD.clear_by:
        return False
    aside = math.copysign(GUARD.clear_by, across)  # to the free side
    x, y = rival.x - aside * dy / distance, rival.y + aside * dx / distance
    go(player, x + dx / distance - player.x, y + dy / distance - player.y, player.top_speed)
    return True


@kernel
def set_defensive_lines(match):
    """Set both teams' defensive lines and second-last players."""
    for team in (LEFT, RIGHT):
        match.trap[team] = -deepest_danger(match, team)


@kernel
def deepest_danger(match, team):
    """Return the depth of a team's line in m from the middle, given by the ball, the carrier, and slow teammates."""
    depth = -forward(team)
    ball = depth * match.ball.x
    low = HALF_LENGTH - DEFENSIVE_LINE.start - DEFENSIVE_LINE.fall_back
    near = between(ball, low, HALF_LENGTH - DEFENSIVE_LINE.force)
    deepest = max(HALF_LENGTH - DEFENSIVE_LINE.start, ball + DEFENSIVE_LINE.fall_back * (1.0 - near))
    deepest = max(deepest, ball + DEFENSIVE_LINE.future * depth * match.ball.vx)
    on_ball = man_on_ball(match, 1 - team)
    if on_ball != NOBODY:
        rival = match.players[on_ball]
        deepest = max(deepest, depth * (rival.x + DEFENSIVE_LINE.rival_lead * rival.vx) + DEFENSIVE_LINE.caution)
    last, second, led_last, led_second = -math.inf, -math.inf, -math.inf, -math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team == team and not player.has_left:
            now = depth * player.x
            last, second = max(last, now), max(second, min(last, now))
            soon = now + DEFENSIVE_LINE.seen_lead * depth * player.vx
            led_last, led_second = max(led_last, soon), max(led_second, min(led_last, soon))
    match.second_last[team] = led_second
    return max(deepest, max(second, ball, 0.0) - DEFENSIVE_LINE.slack)


@kernel
def held_by_line(match, team, x):
    """Return the x of a position in m, compressed in front of the defensive line."""
    depth = -forward(team)
    start = -match.trap[team] - DEFENSIVE_LINE.soft
    if depth * x <= start:
        return x
    return depth * (start + DEFENSIVE_LINE.soft * min((depth * x - start) / (2.0 * DEFENSIVE_LINE.soft), 1.0))
