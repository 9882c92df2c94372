"""Built-in players whose team has not got the ball: press, hold up, mark, or keep the line.

As measured of Google Research Football, a lone defender retreats before a carrier, staying between him and the
goal, and attacks the ball only near it or near his own goal. Read next: `ai.keeper`.
"""

from __future__ import annotations

import math

from envs.football.ai.formation import DEPTH, FOCUS, FOCUS_RANGE, block_x, formation_place
from envs.football.ai.marking import man_on_ball
from envs.football.ai.run_speed import go, head_for, reaction_time
from envs.football.constants import GK, HALF_LENGTH, NOBODY
from envs.football.physics.pitch import forward, own_goal_x
from envs.football.physics.vectors import apart, length
from envs.football.skills.steering import go_for_ball, run_to, slide
from scenic_lite.kernels.jit import kernel

SLIDE_NEAR, SLIDE_FAR, SLIDE_COSINE = 0.7, 1.6, 0.7  # m to the ball, and how nearly straight ahead it lies
SLIDE_LOOSE = 1.4  # m from the carrier to the ball, for which he needs more than 0.26 s
TACKLE_RANGE, COMING = 2.0, 1.5  # m to the ball, and m/s at which it comes: whoever it comes to tries for it
PATIENCE, PRESSED_RANGE = 110, 40.0  # steps a carrier may keep the ball within this many m of the goal, against several
INTERCEPTION = 7.5  # m/s, for estimates of when a presser is where

# Guarding
GUARD_LEAD, OWN_LEAD = 0.5, 0.14  # s by which the opponent's and the own run are led
SHOT_FROM = 24.0  # m to the goal: from where he shoots
NEAREST, BUFFER = 0.4, 4.0  # m in front of him at least; m nearer than he is to where he will shoot
TRAP_DEPTH, TRAP_LEAST = 25.0, 4.0  # m behind a ball that is far away; at least
TRAP_FROM, TRAP_TO = -10.0, 49.0  # m from the half-way line to a ball: far, and near
CLEAR_BY, ABREAST = 1.5, 0.3  # m by which he passes him on the way back, until he is abreast of him
BEATEN = 0.7  # share of the m by which a guard is too late that he falls back

# Marking others
MARK_GAP, MARK_SHARE = 1.5, 0.04  # m, and share of the way to the goal, that is left to an opponent without the ball
MARK_MOST = 3.5  # m

MARK_CLOSE = 0.6  # of the way there from his slot: opponents who wait for a pass have some 5 m of room
SMALL_GAME = 8  # players: up to so many there is no block to keep

# Slots
LINE_SLOT = -0.5  # slots further back than this form the back line
LINE_NEAREST, LINE_FARTHEST = 6.0, 55.0  # m from the goal to the back line
LINE_BEHIND = 3.0  # m behind a ball that has come close


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
    if match.carrier == NOBODY or dx * dx + dy * dy > TACKLE_RANGE * TACKLE_RANGE:
        return False
    if player.marked_opponent == match.carrier:
        carrier = match.players[match.carrier]
        if length(own_goal_x(player.team) - carrier.x, carrier.y) > SHOT_FROM + BUFFER:
            return False
    coming = -(dx * ball.vx + dy * ball.vy) / (length(dx, dy) + 1e-9)
    return coming > COMING and forward(player.team) * dx > 0.0


@kernel
def may_slide(match, player):
    """Return whether a slide reaches a ball that is loose for long enough; teams with agents leave that to them."""
    ball, carrier = match.ball, match.players[match.carrier]
    if match.num_agents[player.team] != 0 or apart(ball, carrier) < SLIDE_LOOSE:
        return False
    dx, dy = ball.x - player.x, ball.y - player.y
    distance = length(dx, dy)
    ahead = player.facing_x * dx + player.facing_y * dy
    return SLIDE_NEAR < distance < SLIDE_FAR and ahead > SLIDE_COSINE * distance


@kernel
def press(match, i, on_ball):
    """Run to where the opponent on the ball can be met on his way to the goal, and there at the ball."""
    player, rival = match.players[i], match.players[on_ball]
    goal_x = own_goal_x(player.team)
    to_goal = length(goal_x - rival.x, rival.y) + 1e-9
    pace = -(rival.vx * (rival.x - goal_x) + rival.vy * rival.y) / to_goal
    time = apart(player, rival) / (INTERCEPTION + max(pace, 0.0))
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
    lead = GUARD_LEAD - reaction_time(player)
    x, y = rival.x + lead * rival.vx, rival.y + lead * rival.vy
    to_goal = length(goal_x - x, y) + 1e-9
    way = max(to_goal - SHOT_FROM, NEAREST)
    line = trap_x(match, player.team)
    if forward(player.team) * (x + way / to_goal * (goal_x - x) - line) < 0.0:
        way = max(to_goal * (line - x) / (goal_x - x), NEAREST)
    spot_x, spot_y = x + way / to_goal * (goal_x - x), y * (1.0 - way / to_goal)
    x, y = slot_place(match, player)
    off = length(spot_x - x, spot_y - y) + 1e-9
    share = min(max(off - way + BUFFER, 0.0) / off, 1.0)
    x, y = x + share * (spot_x - x), y + share * (spot_y - y)
    late = length(spot_x - player.x - OWN_LEAD * player.vx, spot_y - player.y - OWN_LEAD * player.vy) - way
    if late > 0.0:
        back = min(BEATEN * late / (length(goal_x - x, y) + 1e-9), 1.0)
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
    if not ABREAST < along < distance or abs(across) > CLEAR_BY:
        return False
    aside = math.copysign(CLEAR_BY - abs(across), across)  # to the side on which he is not
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
    gap = min(MARK_GAP + MARK_SHARE * apart(match.ball, rival), MARK_MOST) / to_goal
    post_x, post_y = slot_place(match, player)
    x, y = x + gap * (goal_x - x), y * (1.0 - gap)
    close = MARK_CLOSE if match.num_players > SMALL_GAME else 1.0
    head_for(match, player, post_x + close * (x - post_x), post_y + close * (y - post_y))


@kernel
def loses_patience(match, player, on_ball):
    """Return whether a guard attacks an opponent who keeps the ball without getting anywhere, as mates cover him."""
    rival = match.players[on_ball]
    if match.carry_age <= PATIENCE or length(own_goal_x(player.team) - rival.x, rival.y) > PRESSED_RANGE:
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
    if player.slot_x < LINE_SLOT:
        x = line_x(match, player.team)
    goal_x = own_goal_x(player.team)
    close = FOCUS * max(1.0 - abs(goal_x - ball.x) / HALF_LENGTH, 0.0)
    close *= max(1.0 - length(ball.x - x, ball.y - y) / FOCUS_RANGE, 0.0)
    return x + close * 0.5 * (ball.x - x), y + close * (ball.y - y)


@kernel
def trap_x(match, team):
    """Return x behind which guards leave an opponent offside: far behind a far ball, close behind one near the goal."""
    depth = -forward(team) * match.ball.x
    near = min(max((depth - TRAP_FROM) / (TRAP_TO - TRAP_FROM), 0.0), 1.0)
    return -forward(team) * max(depth + TRAP_DEPTH * (1.0 - near), depth + TRAP_LEAST)


@kernel
def line_x(match, team):
    """Return x of a team's back line: it moves with the block, from near the goal to some way out, and not past the
    ball.
    """
    ahead = forward(team)
    line = ahead * block_x(match, team) - DEPTH
    line = min(max(line, LINE_NEAREST - HALF_LENGTH), LINE_FARTHEST - HALF_LENGTH)
    line = min(line, max(ahead * match.ball.x - LINE_BEHIND, LINE_NEAREST - HALF_LENGTH))
    return ahead * line
