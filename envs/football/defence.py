"""Built-in players whose team has not got the ball: hunt the carrier, hold him up, or mark.

As measured of Google Research Football, a defender retreats before a carrier, staying between him and the
goal, and attacks the ball only near it or near his own goal. Read next: `keeper`.
"""

from __future__ import annotations

from envs.football.attack import formation_place
from envs.football.constants import GK, NOBODY, RUN_SPEED
from envs.football.control import go_for_ball, run_to
from envs.football.saves import own_goal_x
from envs.football.vectors import apart, length
from scenic_lite.jit import kernel

HUNTING_RANGE, HUNTING_STANDING = 6.0, 18.0  # m to a carrier who runs, who stands, for a player of full skill
STANDING = 1.5  # m/s
DANGER_RANGE = 24.0  # m from the carrier to the goal: from here on he is attacked
HOLD_UP_GAP, HOLD_UP_SHARE = 3.0, 0.12  # m, and share of the way to the goal, that is left to a carrier
MARK_RANGE, MARK_GAP = 16.0, 1.6  # m


@kernel
def hunt(match, i):
    """As the defender nearest to the ball: attack it when close enough to it or to the goal, else hold up."""
    player, carrier = match.players[i], match.players[match.carrier]
    goal_x = own_goal_x(player.team)
    distance = apart(player, carrier)
    to_goal = length(goal_x - carrier.x, carrier.y)
    stands = length(carrier.vx, carrier.vy) < STANDING
    if to_goal < DANGER_RANGE or distance < player.skill * (HUNTING_STANDING if stands else HUNTING_RANGE):
        go_for_ball(match, i, player.top_speed)
        return
    gap = HOLD_UP_GAP + HOLD_UP_SHARE * to_goal
    share = min(gap / (to_goal + 1e-9), 0.9)
    run_to(player, carrier.x + share * (goal_x - carrier.x), carrier.y * (1.0 - share), player.top_speed)


@kernel
def defend(match, i):
    """Mark the nearest opponent without the ball, from the side of the goal, or keep the formation."""
    player = match.players[i]
    goal_x = own_goal_x(player.team)
    rival = nearest_rival(match, i)
    if rival == NOBODY:
        x, y = formation_place(match, i)
        x += 0.15 * (goal_x - x)
    else:
        marked = match.players[rival]
        to_x, to_y = goal_x - marked.x, -marked.y
        size = length(to_x, to_y) + 1e-9
        x, y = marked.x + MARK_GAP * to_x / size, marked.y + MARK_GAP * to_y / size
    distance = length(x - player.x, y - player.y)
    run_to(player, x, y, player.top_speed if distance > 6.0 else RUN_SPEED)


@kernel
def nearest_rival(match, i):
    """Return the nearest outfield opponent in marking range who does not carry the ball, -1 if none."""
    player = match.players[i]
    nearest, best = MARK_RANGE, NOBODY
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team or rival.role == GK or j == match.carrier:
            continue
        distance = apart(rival, player)
        if distance < nearest:
            nearest, best = distance, j
    return best
