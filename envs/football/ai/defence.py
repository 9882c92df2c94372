"""Built-in players whose team has not got the ball: press, hold up, mark, or keep the line.

As measured of Google Research Football, a lone defender retreats before a carrier, staying between him and the
goal, and attacks the ball only near it or near his own goal. Read next: `ai.keeper`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from envs.football.ai.formation import BLOCK, block_x, formation_place
from envs.football.ai.marking import man_on_ball
from envs.football.ai.run_speed import go, head_for, reaction_time
from envs.football.constants import GK, HALF_LENGTH, NOBODY
from envs.football.physics.pitch import forward, own_goal_x
from envs.football.physics.vectors import apart, length
from envs.football.skills.steering import go_for_ball, run_to, slide
from scenic_lite.kernels.jit import kernel


class Duel(NamedTuple):
    """Going for a led ball: tackles, slides, pressing."""

    slide_near: float = 0.7  # m to the ball, at least
    slide_far: float = 1.6  # m, at most
    slide_cosine: float = 0.7  # how nearly straight ahead it lies
    slide_loose: float = 1.4  # m from the carrier to the ball, for which he needs more than 0.26 s
    tackle_range: float = 2.0  # m to a ball
    coming: float = 1.5  # m/s at which it comes: whoever it comes to tries for it
    patience: float = 110.0  # steps a carrier may keep the ball, against several,
    patience_range: float = 40.0  # m to the goal, within which
    speed: float = 7.5  # m/s, for estimates of when a presser is where


class Guard(NamedTuple):
    """Staying between the opponent on the ball and the goal."""

    lead: float = 0.5  # s by which the opponent's run is led
    own_lead: float = 0.14  # s by which his own is
    shot_from: float = 24.0  # m to the goal: from where the opponent shoots
    nearest: float = 0.4  # m in front of him at least
    buffer: float = 4.0  # m nearer than he is to where he will shoot
    trap_depth: float = 25.0  # m behind a ball that is far away
    trap_least: float = 4.0  # m behind it at least
    trap_from: float = -10.0  # m from the half-way line to a ball that is far
    trap_to: float = 49.0  # m, to one that is near
    clear_by: float = 1.5  # m by which he passes him on the way back,
    abreast: float = 0.3  # m, until he is abreast of him
    beaten: float = 0.7  # share of the m by which a guard is too late that he falls back


class Mark(NamedTuple):
    """Standing loosely by the others."""

    gap: float = 1.5  # m left to an opponent without the ball,
    share: float = 0.04  # and this share of his distance to the ball more,
    most: float = 3.5  # m at most
    close: float = 0.6  # of the way there from his slot: opponents who wait for a pass have some 5 m of room
    small_game: float = 8.0  # players: up to so many there is no block to keep


class Line(NamedTuple):
    """The back line."""

    slot: float = -0.5  # slots further back than this form it
    nearest: float = 6.0  # m from the goal
    farthest: float = 55.0  # m from the goal
    behind: float = 3.0  # m behind a ball that has come close


# Documented of Google Research Football; leads, room and line are fitted: `regista benchmark --suite grf`, families
# tackles and matches.
DUEL, GUARD, MARK, LINE = Duel(), Guard(), Mark(), Line()


@kernel
def defend(match, i):
    """Do what suits a player whose team has not got the ball."""
    player = match.players[i]
    on_ball = man_on_ball(match, 1 - player.team)
    if tackles(match, player):
        go_for_ball(match, i, player.top_speed)
        if may_slide(match, player):
            slide(match, i)
    elif on_ball != NOBODY and (match.presser[player.team, 0] == i or match.presser[player.team, 1] == i):
        press(match, i, on_ball)
    elif player.marked_opponent == NOBODY:
        x, y = slot_place(match, player)
        head_for(match, player, x, y)
    elif player.marked_opponent != on_ball:
        mark(match, player)
    elif loses_patience(match, player, on_ball):
        go_for_ball(match, i, player.top_speed)
    else:
        guard(match, player)


@kernel
def tackles(match, player):
    """Return whether a player tries for a led ball that comes to him, from where he is not behind it.

    Who marks the carrier waits for that until he has come close to where he will shoot.
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
def may_slide(match, player):
    """Return whether a slide reaches a ball that is loose for long enough; teams with agents leave that to them."""
    ball, carrier = match.ball, match.players[match.carrier]
    if match.num_agents[player.team] != 0 or apart(ball, carrier) < DUEL.slide_loose:
        return False
    dx, dy = ball.x - player.x, ball.y - player.y
    distance = length(dx, dy)
    ahead = player.facing_x * dx + player.facing_y * dy
    return DUEL.slide_near < distance < DUEL.slide_far and ahead > DUEL.slide_cosine * distance


@kernel
def press(match, i, on_ball):
    """Run to where the opponent on the ball can be met on his way to the goal, and there at the ball."""
    player, rival = match.players[i], match.players[on_ball]
    goal_x = own_goal_x(player.team)
    to_goal = length(goal_x - rival.x, rival.y) + 1e-9
    pace = -(rival.vx * (rival.x - goal_x) + rival.vy * rival.y) / to_goal
    time = apart(player, rival) / (DUEL.speed + max(pace, 0.0))
    if time < 0.35 or pace < 1.0:
        go_for_ball(match, i, player.top_speed)
        return
    share = min(pace * time / to_goal, 0.9)
    run_to(player, rival.x + share * (goal_x - rival.x), rival.y * (1.0 - share), player.top_speed)


@kernel
def guard(match, player):
    """Stay nearer than the opponent on the ball to where that one will shoot: far off loosely, then in front of him.

    Where that opponent will be is led so far that a guard goes back before a sprinter rather than into him.
    """
    rival = match.players[player.marked_opponent]
    goal_x = own_goal_x(player.team)
    lead = GUARD.lead - reaction_time(player)
    x, y = rival.x + lead * rival.vx, rival.y + lead * rival.vy
    to_goal = length(goal_x - x, y) + 1e-9
    way = max(to_goal - GUARD.shot_from, GUARD.nearest)
    line = trap_x(match, player.team)
    if forward(player.team) * (x + way / to_goal * (goal_x - x) - line) < 0.0:
        way = max(to_goal * (line - x) / (goal_x - x), GUARD.nearest)
    spot_x, spot_y = x + way / to_goal * (goal_x - x), y * (1.0 - way / to_goal)
    x, y = slot_place(match, player)
    off = length(spot_x - x, spot_y - y) + 1e-9
    share = min(max(off - way + GUARD.buffer, 0.0) / off, 1.0)
    x, y = x + share * (spot_x - x), y + share * (spot_y - y)
    late = length(spot_x - player.x - GUARD.own_lead * player.vx, spot_y - player.y - GUARD.own_lead * player.vy) - way
    if late > 0.0:
        back = min(GUARD.beaten * late / (length(goal_x - x, y) + 1e-9), 1.0)
        x, y = x + back * (goal_x - x), y * (1.0 - back)
    if not run_round(player, rival, x, y):
        head_for(match, player, x, y)


@kernel
def run_round(player, rival, x, y):
    """Run round an opponent who is in the way to (x, y); return whether one is."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    to_x, to_y = rival.x - player.x, rival.y - player.y
    along, across = (to_x * dx + to_y * dy) / distance, (to_x * dy - to_y * dx) / distance
    if not GUARD.abreast < along < distance or abs(across) > GUARD.clear_by:
        return False
    aside = math.copysign(GUARD.clear_by - abs(across), across)  # to the side on which he is not
    x, y = rival.x - aside * dy / distance, rival.y + aside * dx / distance
    go(player, x + dx / distance - player.x, y + dy / distance - player.y, player.top_speed)
    return True


@kernel
def mark(match, player):
    """Stand loosely between the opponent whom he marks and the goal."""
    rival = match.players[player.marked_opponent]
    goal_x = own_goal_x(player.team)
    late = reaction_time(player)
    x, y = rival.x - late * rival.vx, rival.y - late * rival.vy
    to_goal = length(goal_x - x, y) + 1e-9
    gap = min(MARK.gap + MARK.share * apart(match.ball, rival), MARK.most) / to_goal
    post_x, post_y = slot_place(match, player)
    x, y = x + gap * (goal_x - x), y * (1.0 - gap)
    close = MARK.close if match.num_players > MARK.small_game else 1.0
    head_for(match, player, post_x + close * (x - post_x), post_y + close * (y - post_y))


@kernel
def loses_patience(match, player, on_ball):
    """Return whether a guard attacks an opponent who keeps the ball without getting anywhere, as mates cover him."""
    rival = match.players[on_ball]
    if match.carry_age <= DUEL.patience or length(own_goal_x(player.team) - rival.x, rival.y) > DUEL.patience_range:
        return False
    mates = 0
    for j in range(match.num_players):
        mates += match.players[j].team == player.team and match.players[j].role != GK
    return mates > 1


@kernel
def slot_place(match, player):
    """Return place in m in the block, those at the back in line, all closing up to a ball that comes near the goal."""
    x, y = formation_place(match, player)
    ball = match.ball
    if player.slot_x < LINE.slot:
        x = line_x(match, player.team)
    goal_x = own_goal_x(player.team)
    close = BLOCK.focus * max(1.0 - abs(goal_x - ball.x) / HALF_LENGTH, 0.0)
    close *= max(1.0 - length(ball.x - x, ball.y - y) / BLOCK.focus_range, 0.0)
    return x + close * 0.5 * (ball.x - x), y + close * (ball.y - y)


@kernel
def trap_x(match, team):
    """Return x behind which guards leave an opponent offside: far behind a far ball, close behind one near the goal."""
    depth = -forward(team) * match.ball.x
    near = min(max((depth - GUARD.trap_from) / (GUARD.trap_to - GUARD.trap_from), 0.0), 1.0)
    return -forward(team) * max(depth + GUARD.trap_depth * (1.0 - near), depth + GUARD.trap_least)


@kernel
def line_x(match, team):
    """Return x of a team's back line: it moves with the block, from near the goal to some way out, and not past the
    ball.
    """
    ahead = forward(team)
    line = ahead * block_x(match, team) - BLOCK.depth
    line = min(max(line, LINE.nearest - HALF_LENGTH), LINE.farthest - HALF_LENGTH)
    line = min(line, max(ahead * match.ball.x - LINE.behind, LINE.nearest - HALF_LENGTH))
    return ahead * line
