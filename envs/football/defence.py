"""Built-in players whose team has not got the ball: hunt, hold up, mark, or keep the line.

As measured of Google Research Football, a lone defender retreats before a carrier, staying between him and the
goal, and attacks the ball only near it or near his own goal. Read next: `keeper`.
"""

from __future__ import annotations

import math

from envs.football.constants import GK, HALF_LENGTH, NOBODY, RUN_SPEED
from envs.football.control import go_for_ball, run_to, slide
from envs.football.effort import head_for, reaction_time
from envs.football.formation import DEPTH, FOCUS, FOCUS_RANGE, block_x, formation_place, forward
from envs.football.marking import man_on_ball
from envs.football.saves import own_goal_x
from envs.football.vectors import apart, length
from scenic_lite.jit import kernel

SLIDE_NEAR, SLIDE_FAR, SLIDE_COSINE = 0.7, 1.6, 0.7  # m to the ball, and how nearly straight ahead it lies
SLIDE_LOOSE = 1.4  # m from the carrier to the ball, for which he needs more than 0.26 s
CATCH_UP, STEADY = 1.5, 0.5  # 1/s by which a gap that is too wide or too narrow is mended; m/s too little to move for
CLOSED_DOWN = 3.0  # m to the ball, from where a defender before his goal sprints at it
CLEAR_BY = 2.5  # m by which the opponent on the ball is passed on the way back
TACKLE_RANGE, COMING = 2.0, 1.5  # m to the ball, and m/s at which it comes: whoever it comes to tries for it
DANGER_RANGE = 29.0  # m from the carrier to the goal: from here on he is attacked, and loses the ball some 5 m later
CLOSE_RANGE = 20.0  # m: the same where a keeper is behind the defender
PATIENCE, PRESSED_RANGE = 110, 40.0  # steps a carrier may keep the ball within this many m of the goal, against several
HOLD_UP_MOST, HOLD_UP_FROM = 7.0, 24.0  # m left to a carrier who is far away; m to the goal, from where on less is
HOLD_UP_GAP, HOLD_UP_SHARE = 3.0, 0.5  # m that are left at least, and more per m that he is further from the goal
INTERCEPTION = 7.5  # m/s, for estimates of when a hunter is where
MARK_GAP, MARK_SHARE = 1.5, 0.04  # m, and share of the way to the goal, that is left to an opponent without the ball
MARK_MOST = 3.5  # m
MARK_CLOSE = 0.6  # of the way there from his post: opponents who wait for a pass have some 5 m of room
SMALL_GAME = 8  # players: up to so many there is no block to keep
LINE_POST = -0.5  # posts further back than this form the back line
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
    elif on_ball != NOBODY and (match.hunter[player.team, 0] == i or match.hunter[player.team, 1] == i):
        hunt(match, i, on_ball)
    elif player.mark == NOBODY:
        x, y = post_place(match, player)
        head_for(match, player, x, y)
    elif player.mark == on_ball:
        hold_up(match, i, on_ball)
    else:
        mark(match, player)


@kernel
def tackles(match, player):
    """Tell whether a player tries for a led ball that comes close to him, from where he is not behind it."""
    ball = match.ball
    dx, dy = ball.x - player.x, ball.y - player.y
    if match.carrier == NOBODY or dx * dx + dy * dy > TACKLE_RANGE * TACKLE_RANGE:
        return False
    coming = -(dx * ball.vx + dy * ball.vy) / (length(dx, dy) + 1e-9)
    return coming > COMING and forward(player.team) * dx > 0.0


@kernel
def may_slide(match, player):
    """Tell whether a slide reaches a ball that is loose for long enough; teams with agents leave that to them."""
    ball, carrier = match.ball, match.players[match.carrier]
    if match.num_agents[player.team] != 0 or apart(ball, carrier) < SLIDE_LOOSE:
        return False
    dx, dy = ball.x - player.x, ball.y - player.y
    distance = length(dx, dy)
    ahead = player.facing_x * dx + player.facing_y * dy
    return SLIDE_NEAR < distance < SLIDE_FAR and ahead > SLIDE_COSINE * distance


@kernel
def hunt(match, i, on_ball):
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
def hold_up(match, i, on_ball):
    """Stay between the opponent on the ball and the goal at a distance; attack the ball near the goal."""
    player, rival = match.players[i], match.players[on_ball]
    goal_x = own_goal_x(player.team)
    late = reaction_time(player)
    x, y = rival.x - late * rival.vx, rival.y - late * rival.vy
    to_goal = length(goal_x - x, y) + 1e-9
    if to_goal < attacked_from(match, player):
        attack_ball(match, i, rival, to_goal)
        return
    gap = HOLD_UP_GAP + HOLD_UP_SHARE * max(to_goal - HOLD_UP_FROM, 0.0)
    share = min(min(gap, HOLD_UP_MOST) / to_goal, 0.9)
    x, y = x + share * (goal_x - x), y * (1.0 - share)
    if length(goal_x - player.x, player.y) < to_goal:
        go_along(player, rival, x, y)
    else:
        run_round(player, rival, x, y)


@kernel
def go_along(player, rival, x, y):
    """Move as an opponent does, and meanwhile towards (x, y)."""
    want_x, want_y = rival.vx + CATCH_UP * (x - player.x), rival.vy + CATCH_UP * (y - player.y)
    size = length(want_x, want_y)
    share = min(player.top_speed / size, 1.0) if size > STEADY else 0.0
    player.want_x, player.want_y = share * want_x, share * want_y


@kernel
def attacked_from(match, player):
    """Distance in m from the goal within which a player attacks the opponent whom he holds up."""
    goal_x = own_goal_x(player.team)
    own = length(goal_x - player.x, player.y)
    mates, keeper_behind = 0, False
    for j in range(match.num_players):
        mate = match.players[j]
        if mate.team != player.team:
            continue
        if mate.role == GK:
            keeper_behind = length(goal_x - mate.x, mate.y) < own
        else:
            mates += 1
    if mates > 1 and match.borne > PATIENCE:
        return PRESSED_RANGE
    return CLOSE_RANGE if keeper_behind else DANGER_RANGE


@kernel
def attack_ball(match, i, rival, to_goal):
    """Go for the ball near the goal: at a run while between it and the goal, sprinting when close or behind it."""
    player, ball = match.players[i], match.ball
    goal_side = length(own_goal_x(player.team) - player.x, player.y) < to_goal
    far = apart(ball, player) > CLOSED_DOWN
    go_for_ball(match, i, RUN_SPEED if goal_side and far else player.top_speed)


@kernel
def run_round(player, rival, x, y):
    """Run to (x, y), keeping clear of an opponent who is in between."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    to_x, to_y = rival.x - player.x, rival.y - player.y
    along, across = (to_x * dx + to_y * dy) / distance, (to_x * dy - to_y * dx) / distance
    if 0.0 < along < distance and abs(across) < CLEAR_BY:
        aside = math.copysign(CLEAR_BY - abs(across), across)  # to the side on which he is not
        x, y = rival.x - aside * dy / distance, rival.y + aside * dx / distance
        x, y = x + dx / distance, y + dy / distance
    run_to(player, x, y, player.top_speed)


@kernel
def mark(match, player):
    """Stand loosely between the opponent whom he marks and the goal."""
    rival = match.players[player.mark]
    goal_x = own_goal_x(player.team)
    late = reaction_time(player)
    x, y = rival.x - late * rival.vx, rival.y - late * rival.vy
    to_goal = length(goal_x - x, y) + 1e-9
    gap = min(MARK_GAP + MARK_SHARE * apart(match.ball, rival), MARK_MOST) / to_goal
    post_x, post_y = post_place(match, player)
    x, y = x + gap * (goal_x - x), y * (1.0 - gap)
    close = MARK_CLOSE if match.num_players > SMALL_GAME else 1.0
    head_for(match, player, post_x + close * (x - post_x), post_y + close * (y - post_y))


@kernel
def post_place(match, player):
    """Place in m in the block, those at the back in line, all closing up to a ball that comes near the goal."""
    x, y = formation_place(match, player)
    ball = match.ball
    if player.post_x < LINE_POST:
        x = line_x(match, player.team)
    goal_x = own_goal_x(player.team)
    close = FOCUS * max(1.0 - abs(goal_x - ball.x) / HALF_LENGTH, 0.0)
    close *= max(1.0 - length(ball.x - x, ball.y - y) / FOCUS_RANGE, 0.0)
    return x + close * 0.5 * (ball.x - x), y + close * (ball.y - y)


@kernel
def line_x(match, team):
    """x of a team's back line: it moves with the block, from near the goal to some way out, and not past the ball."""
    ahead = forward(team)
    line = ahead * block_x(match, team) - DEPTH
    line = min(max(line, LINE_NEAREST - HALF_LENGTH), LINE_FARTHEST - HALF_LENGTH)
    line = min(line, max(ahead * match.ball.x - LINE_BEHIND, LINE_NEAREST - HALF_LENGTH))
    return ahead * line
