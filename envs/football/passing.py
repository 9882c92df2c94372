"""Passes of the built-in AI: to whom, which kind, and when; and the clearance of a defender under pressure.

As documented of Google Research Football: what is gained times the odds that it arrives, with more patience the
shorter he has had the ball. Read next: `kicks`, which carries passes out.
"""

from __future__ import annotations

from envs.football.constants import GK, HALF_LENGTH, HALF_WIDTH, HIGH_PASS, LONG_PASS, NOBODY, SHORT_PASS
from envs.football.formation import forward
from envs.football.offside import second_last
from envs.football.saves import own_goal_x
from envs.football.situation import attacked_goal_x, eagerness, nearest_opponent, situation
from envs.football.vectors import apart, length
from scenic_lite.jit import kernel

DECIDED_EVERY = 2  # steps
GROUND_LEAST, GROUND_MOST, HIGH_LEAST, HIGH_MOST = 4.0, 32.0, 12.0, 36.0  # m
BETTER = 0.1  # by how much a mate's situation must be better
GAIN_MOST = 1.2  # more is not worth more
EAGER, PATIENT, PATIENCE = 0.08, 0.36, 50  # least gain times odds after PATIENCE steps on the ball, and at once
IMPATIENCE = 0.1  # of the weight of ground: what it is worth after PATIENCE steps to be rid of the ball
KEEPER_SHARE = 0.7  # of its worth that a pass to the own keeper has
HIGH_LOSS = 0.4  # of the odds
LEAD_TIME, LONG_LEAD = 0.4, 0.2  # s; of the distance, towards the goal
BALL_START, BALL_GAIN = 9.0, 0.45  # m/s, and per m of distance: mean speed of a pass on the ground
BALL_MOST = 20.0  # m/s
RIVAL_SPEED, RIVAL_REACH, RIVAL_DELAY = 6.5, 0.8, 0.2  # m/s, m, s
SURE = 0.6  # s between the ball and a rival: odds of 1
LANDING = 8.0  # m from where a high ball lands to the nearest rival: odds of 1
ONSIDE = -1.8  # m: he misjudges by this much who is offside

# Clearances
PANIC_POST, PANIC_RANGE, PANIC_NEAR = -0.4, 30.0, 2.5  # posts further back; m to the own goal; m to an opponent
CLEARED = 38.0  # m


@kernel
def consider_pass(match, i):
    """Ask for the best pass if it is worth it by now, or for a clearance; return whether a kick was asked for."""
    player = match.players[i]
    if (match.step + player.shirt) % DECIDED_EVERY != 0:
        return False
    waited = min(match.borne / PATIENCE, 1.0)
    threshold = PATIENT + (EAGER - PATIENT) * waited
    if best_pass(match, i, threshold, IMPATIENCE * eagerness(player) * waited * waited):
        return True
    return clear_in_panic(match, i)


@kernel
def best_pass(match, i, threshold, bonus):
    """Ask for the pass with the greatest worth above `threshold`; return whether there is one.

    `bonus` is what it is worth to be rid of the ball.
    """
    player = match.players[i]
    own = situation(match, player, player.x, player.y) - bonus
    line = max(second_last(match, 1 - player.team, forward(player.team)), forward(player.team) * match.ball.x, 0.0)
    best, found = threshold, False
    for j in range(match.num_players):
        mate = match.players[j]
        distance = apart(mate, player)
        if j == i or mate.team != player.team or not GROUND_LEAST < distance < HIGH_MOST or mate.down > 0.0:
            continue
        if match.offsides and forward(player.team) * mate.x > line - ONSIDE:
            continue
        x, y = mate.x + LEAD_TIME * mate.vx, mate.y + LEAD_TIME * mate.vy
        gain = min(situation(match, player, x, y) - own, GAIN_MOST)
        gain *= KEEPER_SHARE if mate.role == GK else 1.0
        if gain < max(BETTER, best):
            continue
        kind, worth, x, y = best_kind(match, player, mate, own, gain)
        if worth > best:
            best, found = worth, True
            ask_kick(player, kind, x, y)
            player.kick_mate = j
    return found


@kernel
def best_kind(match, player, mate, own, gain):
    """Compare a pass to a mate's feet, into his run, and through the air: kind, worth, and where it is aimed.

    `own` is the player's own situation, `gain` what the mate's is better.
    """
    distance = apart(mate, player)
    x, y = mate.x + LEAD_TIME * mate.vx, mate.y + LEAD_TIME * mate.vy
    kind, worth, aim_x, aim_y = SHORT_PASS, -1.0, x, y
    if distance < GROUND_MOST:
        worth = gain * ground_odds(match, player, x, y)
        through_x, through_y = into_run(player, mate, distance)
        if forward(player.team) * mate.vx > 2.0:
            through = min(situation(match, player, through_x, through_y) - own, GAIN_MOST)
            through *= ground_odds(match, player, through_x, through_y)
            if through > worth:
                kind, worth, aim_x, aim_y = LONG_PASS, through, through_x, through_y
    if distance > HIGH_LEAST:
        high = gain * high_odds(match, player, x, y)
        if high > worth:
            kind, worth, aim_x, aim_y = HIGH_PASS, high, x, y
    return kind, worth, aim_x, aim_y


@kernel
def into_run(player, mate, distance):
    """The place ahead of a mate to which a through ball goes."""
    to_x, to_y = attacked_goal_x(player) - mate.x, -mate.y
    share = LONG_LEAD * distance / max(length(to_x, to_y), 1.0)
    return mate.x + LEAD_TIME * mate.vx + share * to_x, mate.y + LEAD_TIME * mate.vy + share * to_y


@kernel
def ground_odds(match, player, x, y):
    """Odds in [0, 1] that a pass along the ground from a player to (x, y) gets past his opponents."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    speed = min(BALL_START + BALL_GAIN * distance, BALL_MOST)
    slack = SURE
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team == player.team:
            continue
        to_x, to_y = rival.x - player.x, rival.y - player.y
        along = (to_x * dx + to_y * dy) / distance
        if along <= 0.0:
            continue
        if along > distance:
            across = length(rival.x - x, rival.y - y)
            along = distance
        else:
            across = abs(to_x * dy - to_y * dx) / distance
        if across > RIVAL_REACH + RIVAL_SPEED * (along / speed + SURE):
            continue
        slack = min(slack, (across - RIVAL_REACH) / RIVAL_SPEED + RIVAL_DELAY - along / speed)
    return min(max(0.5 + 0.5 * slack / SURE, 0.0), 1.0)


@kernel
def high_odds(match, player, x, y):
    """Odds in [0, 1] that a high pass to (x, y) comes down where no opponent is."""
    nearest = LANDING
    for j in range(match.num_players):
        rival = match.players[j]
        if rival.team != player.team:
            nearest = min(nearest, length(rival.x - x, rival.y - y))
    return max(nearest / LANDING - HIGH_LOSS, 0.0)


@kernel
def clear_in_panic(match, i):
    """Under pressure near the own goal, as a defender: kick the ball high and far; return whether."""
    player = match.players[i]
    to_own_goal = length(own_goal_x(player.team) - player.x, player.y)
    if player.post_x > PANIC_POST or to_own_goal > PANIC_RANGE or nearest_opponent(match, player) > PANIC_NEAR:
        return False
    x = player.x + forward(player.team) * CLEARED
    y = player.y * 1.3 + 4.0 * player.vy / (1.0 + abs(player.vy))
    limit_x, limit_y = HALF_LENGTH - 5.0, HALF_WIDTH - 5.0
    ask_kick(player, HIGH_PASS, min(max(x, -limit_x), limit_x), min(max(y, -limit_y), limit_y))
    return True


@kernel
def ask_kick(player, kick, x, y):
    """Ask for a kick to a chosen place."""
    player.kick, player.kick_held, player.kick_ready = kick, 1, True
    player.aimed, player.aim_x, player.aim_y, player.kick_mate = True, x, y, NOBODY
