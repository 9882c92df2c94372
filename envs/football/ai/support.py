"""Supporting runs: a field of forces moves players from their slots to onside positions that support the ball.

As documented by Google Research Football; sometimes one player runs behind the defense. Read next: `ai.attack`, for the
player on the ball.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.formation import LINE, MINDSET, between, smooth
from regista.envs.football.constants import HALF_LENGTH, HALF_WIDTH, LEFT, NOBODY, RIGHT
from regista.envs.football.physics.pitch import attacked_goal_x, forward
from regista.envs.football.physics.possession import man_on_ball
from regista.envs.football.physics.vectors import apart, length
from regista.kernels.jit import kernel


class Forces(NamedTuple):
    """The field of forces: pulls, pushes, their strengths and ranges."""

    look_ahead: float = 0.1  # s by which all runs are extrapolated
    step: float = 8.0  # m, maximum displacement
    damped: float = 7.0  # m; nearer pulls are weaker
    slot: float = 0.7  # strength of the slot's pull
    slot_near: float = 0.3  # share of it close to the slot
    slot_far: float = 20.0  # m, from which on the slot pulls in full
    lane: float = 22.0  # m by which attackers' slots are moved forward, next to the lane
    lane_aside: float = 8.0  # m from the middle, on the side without the ball
    lane_width: float = 30.0  # m
    support: float = 12.0  # m by which the supporting player's slot is moved forward,
    support_least: float = 0.3  # share of it for defenders
    run: float = 2.0  # strength of the goal's pull on a player who runs behind the defense
    rivals: int = 3  # number of nearest opponents that push
    rival: float = 0.3
    rival_shadow: float = 2.0  # m behind the opponents, seen from the ball: the center of their push
    rival_reach: float = 5.0  # m
    rival_curve: float = 0.7
    run_reach: float = 2.0  # m, reach of opponents' push on a player who runs behind the defense
    run_share: float = 0.5  # factor of that push
    mates: int = 5  # number of nearest teammates that push
    mate: float = 0.4
    mate_reach: float = 10.5  # m
    mates_from: float = 1.02  # share of possession from which on teammates push
    ball_from: float = 1.06  # share of possession from which on the ball's path pushes
    ball: float = 1.0
    ball_reach: float = 2.0  # m
    ball_curve: float = 0.5
    carrier: float = 0.45  # strength of the pull of the player on the ball
    carrier_far: float = 21.0  # m; players further away are only pulled
    carrier_near: float = 12.0  # m; from here on the player on the ball also pushes


class Run(NamedTuple):
    """Runs behind the defense."""

    ahead: float = 26.0  # m in front of the player on the ball; the player nearest to this point may run
    within: float = 40.0  # m to the player on the ball, at most
    spot: float = 10.0  # m behind the runner, where opponents are counted
    rivals: int = 4
    range: float = 15.0  # m
    push: float = 0.3
    rating: float = 0.5  # minimum rating for a run
    steps: int = 40
    share: tuple[float, ...] = (1.0, 0.9, 0.7)  # minimum share of the forces for a run of back, midfielder, forward


# Documented by Google Research Football; families academy and matches of `lab.benchmarks --suite grf`.
FORCES, RUN = Forces(), Run()
SHARE_FROM, SHARE_TO = (0.2, 0.1, 0.1), (0.9, 0.7, 0.6)  # bounds of possession, less 0.5, between which forces grow
RIVAL_BY_ROLE = (1.0, 2.2, 2.2, 2.2, 2.0, 1.6, 1.6, 1.6, 1.2, 1.0)  # strength of opponents' pushes, by role
LANE_SHARE = tuple(attacker**1.5 for attacker in MINDSET)  # share of the lane's shift, by role
BALL_WAY = (0.2, 0.35, 0.5, 0.65)  # s ahead: the positions on the ball's path that push
ONSIDE = 0.08  # m short of the offside line
RUNS_EVERY, SUPPORT_EVERY = 5, 15  # steps


@kernel
def support_share(match, player):
    """Return the share of the way from the slot to the position given by the forces that a player moves."""
    line = LINE[player.role]
    return between(match.hold[player.team] - 0.5, SHARE_FROM[line], SHARE_TO[line])


@kernel
def runs_behind(match, i, share):
    """Return whether player i runs behind the defense."""
    player = match.players[i]
    return match.runner[player.team] == i and share > RUN.share[LINE[player.role]]


@kernel
def supporting_place(match, i, x, y, carrier, runs):
    """Return the position to which forces move player i with slot (x, y), while the teammate `carrier` has the ball."""
    player, first = match.players[i], match.players[carrier]
    ahead = forward(player.team)
    at_x, at_y = player.x + FORCES.look_ahead * player.vx, player.y + FORCES.look_ahead * player.vy
    from_x, from_y = first.x + FORCES.look_ahead * first.vx, first.y + FORCES.look_ahead * first.vy
    pull_x, pull_y, pulls = pull_of_slot(match, i, x, y, at_x, at_y, from_y)
    if runs:
        fx, fy, f = pulled(attacked_goal_x(player.team) - at_x, -0.5 * at_y, FORCES.run)
        pull_x, pull_y, pulls = pull_x + fx, pull_y + fy, pulls + f
    fx, fy, f = push_of_rivals(match, player, at_x, at_y, from_x, from_y, runs)
    pull_x, pull_y, pulls = pull_x + fx, pull_y + fy, pulls + f
    if match.hold[player.team] >= FORCES.mates_from:
        fx, fy, f = push_of_mates(match, i, at_x, at_y)
        pull_x, pull_y, pulls = pull_x + fx, pull_y + fy, pulls + f
    if carrier != i:
        if match.hold[player.team] >= FORCES.ball_from:
            fx, fy, f = push_of_ball(match, at_x, at_y)
            pull_x, pull_y, pulls = pull_x + fx, pull_y + fy, pulls + f
        fx, fy, f = pull_of_carrier(from_x - at_x, from_y - at_y)
        pull_x, pull_y, pulls = pull_x + fx, pull_y + fy, pulls + f
    u = ahead * (at_x + FORCES.step * pull_x / pulls)
    u = min(u, onside_line(match, player.team) - ONSIDE, HALF_LENGTH)
    v = at_y + FORCES.step * pull_y / pulls
    return ahead * max(u, -HALF_LENGTH), min(max(v, -HALF_WIDTH), HALF_WIDTH)


@kernel
def pulled(dx, dy, power):
    """Return the pull of a point at (dx, dy): a vector, weaker when near, and its weight."""
    distance = math.sqrt(dx * dx + dy * dy) + 1e-9
    share = power * min(distance / FORCES.damped, 1.0) / distance
    return share * dx, share * dy, power


@kernel
def pushed(dx, dy, power, reach, curve):
    """Return the push of a point at (dx, dy), 0 out of reach: a vector, and its weight."""
    distance = math.sqrt(dx * dx + dy * dy)
    if distance >= reach:
        return 0.0, 0.0, 0.0
    near = 1.0 - distance / reach
    power *= near if curve == 1.0 else near**curve
    share = -power / (distance + 1e-9)
    return share * dx, share * dy, power


@kernel
def pull_of_slot(match, i, x, y, at_x, at_y, carrier_y):
    """Return the pull of player i's slot, moved forward near the lane and for the supporting player."""
    player = match.players[i]
    attacker = MINDSET[match.players[player.post].role]
    if match.helper[player.team] == i:
        push = FORCES.support * (FORCES.support_least + (1.0 - FORCES.support_least) * attacker)
    else:
        ahead = forward(player.team)
        lane_y = -ahead * (FORCES.lane_aside if ahead * carrier_y >= 0.0 else -FORCES.lane_aside)
        near = 1.0 - between(abs(lane_y - at_y), 0.0, FORCES.lane_width)
        push = FORCES.lane * smooth(near, 1.0) * LANE_SHARE[match.players[player.post].role]
    dx, dy = x + forward(player.team) * push - at_x, y - at_y
    far = min(length(dx, dy) / FORCES.slot_far, 1.0)
    return pulled(dx, dy, FORCES.slot * (FORCES.slot_near + (1.0 - FORCES.slot_near) * far))


@kernel
def push_of_rivals(match, player, at_x, at_y, from_x, from_y, runs):
    """Return the push of the nearest opponents. It starts behind them as seen from the ball, where no pass arrives."""
    power = FORCES.rival * RIVAL_BY_ROLE[match.players[player.post].role] * (FORCES.run_share if runs else 1.0)
    reach = FORCES.run_reach if runs else FORCES.rival_reach
    push_x, push_y, pushes = 0.0, 0.0, 0.0
    limit = (reach + FORCES.rival_shadow) ** 2
    for j in range(match.num_players):
        rival = match.players[j]
        dx, dy = rival.x - at_x, rival.y - at_y
        if rival.team == player.team or dx * dx + dy * dy > limit:
            continue
        x, y = rival.x + FORCES.look_ahead * rival.vx, rival.y + FORCES.look_ahead * rival.vy
        off = length(x - from_x, y - from_y) + 1e-9
        x += FORCES.rival_shadow * (x - from_x) / off
        y += FORCES.rival_shadow * (y - from_y) / off
        fx, fy, f = pushed(x - at_x, y - at_y, power, reach, FORCES.rival_curve)
        push_x, push_y, pushes = push_x + fx, push_y + fy, pushes + f
    return push_x, push_y, pushes


@kernel
def push_of_mates(match, i, at_x, at_y):
    """Return the push of player i's teammates in reach."""
    push_x, push_y, pushes = 0.0, 0.0, 0.0
    for j in range(match.num_players):
        mate = match.players[j]
        if j == i or mate.team != match.players[i].team:
            continue
        dx, dy = mate.x + FORCES.look_ahead * mate.vx - at_x, mate.y + FORCES.look_ahead * mate.vy - at_y
        if dx * dx + dy * dy < FORCES.mate_reach * FORCES.mate_reach:
            fx, fy, f = pushed(dx, dy, FORCES.mate, FORCES.mate_reach, 1.0)
            push_x, push_y, pushes = push_x + fx, push_y + fy, pushes + f
    return push_x, push_y, pushes


@kernel
def push_of_ball(match, at_x, at_y):
    """Return the push of the ball's path."""
    ball = match.ball
    push_x, push_y, pushes = 0.0, 0.0, 0.0
    for k in range(len(BALL_WAY)):
        dx, dy = ball.x + BALL_WAY[k] * ball.vx - at_x, ball.y + BALL_WAY[k] * ball.vy - at_y
        fx, fy, f = pushed(dx, dy, FORCES.ball, FORCES.ball_reach, FORCES.ball_curve)
        push_x, push_y, pushes = push_x + fx, push_y + fy, pushes + f
    return push_x, push_y, pushes


@kernel
def pull_of_carrier(dx, dy):
    """Return the pull of the teammate on the ball at (dx, dy), who also pushes when near."""
    distance = math.sqrt(dx * dx + dy * dy)
    if distance >= FORCES.carrier_far:
        return 0.0, 0.0, 0.0
    pull_x, pull_y, pulls = pulled(dx, dy, FORCES.carrier * (1.0 - distance / FORCES.carrier_far))
    push_x, push_y, pushes = pushed(dx, dy, FORCES.carrier, FORCES.carrier_near, 1.0)
    return pull_x + push_x, pull_y + push_y, pulls + pushes


@kernel
def onside_line(match, team):
    """Return how far forward in m a player of `team` may stand without being offside."""
    return max(match.second_last[1 - team], forward(team) * match.ball.x, 0.0)


@kernel
def choose_runners(match):
    """Count down runs; every half second let the team on the ball start a run if it has no runner."""
    for team in (LEFT, RIGHT):
        match.run_steps_left[team] -= 1
        if match.run_steps_left[team] <= 0:
            match.runner[team] = NOBODY
        on_ball = man_on_ball(match, team)
        if on_ball == NOBODY:
            continue
        if match.step % SUPPORT_EVERY == 0:
            match.helper[team] = nearest_mate_to(match, on_ball, 1.5, False)
        if match.step % RUNS_EVERY == 0 and match.runner[team] == NOBODY and match.team_in_possession == team:
            start_run(match, team, on_ball)


@kernel
def start_run(match, team, on_ball):
    """Send the best-placed teammate behind the defense, if there is room."""
    runner = nearest_mate_to(match, on_ball, RUN.ahead, True)
    if runner == NOBODY or apart(match.players[runner], match.players[on_ball]) > RUN.within:
        return
    player = match.players[runner]
    near = math.sqrt(1.0 - apart(player, match.players[on_ball]) / RUN.within)
    if near * room_to_run(match, player) >= RUN.rating:
        match.runner[team], match.run_steps_left[team] = runner, RUN.steps


@kernel
def room_to_run(match, player):
    """Return the room for a run, by the opponents behind a player (1: none); GRF checks behind, not in front."""
    x, y = player.x - forward(player.team) * RUN.spot, 0.8 * player.y
    room = 1.0
    for j in range(match.num_players):
        rival = match.players[j]
        distance = length(rival.x - x, rival.y - y)
        if rival.team != player.team and distance < RUN.range:
            room -= RUN.push * math.sqrt(smooth(1.0 - distance / RUN.range, 1.0))
    return room


@kernel
def nearest_mate_to(match, i, ahead, is_free):
    """Return player i's teammate nearest to `ahead` m in front, -1 if none; with `is_free`, not an agent's player."""
    player = match.players[i]
    x, y = player.x + forward(player.team) * ahead, player.y
    best, nearest = NOBODY, math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        if j == i or mate.team != player.team or mate.has_left or (is_free and mate.agent != NOBODY):
            continue
        distance = length(mate.x - x, mate.y - y)
        if distance < nearest:
            best, nearest = j, distance
    return best
