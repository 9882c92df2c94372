"""Passes of the built-in AI: to whom, which kind, and when; and the clearance of a defender under pressure.

As documented of Google Research Football: what is gained times the odds that it arrives, with more patience the
shorter he has had the ball. Read next: `skills.kicks`, which carries passes out.
"""

from __future__ import annotations

from envs.football.ai.interception import danger
from envs.football.ai.position_value import nearest_opponent, position_value
from envs.football.constants import GK, HALF_LENGTH, HALF_WIDTH, HIGH_PASS, LONG_PASS, NOBODY, SHORT_PASS
from envs.football.physics.pitch import attacked_goal_x, forward, own_goal_x
from envs.football.physics.vectors import apart, length
from envs.football.rules.offside import second_last
from scenic_lite.kernels.jit import kernel

DECIDED_EVERY = 2  # steps
GROUND_LEAST, GROUND_MOST, HIGH_LEAST, HIGH_MOST = 4.0, 32.0, 12.0, 36.0  # m
BETTER = 0.1  # by how much a mate's situation must be better
GAIN_MOST = 4.0  # more is not worth more
EAGER, PATIENT, PATIENCE = 0.035, 0.25, 50  # least gain times odds after PATIENCE steps on the ball, and at once
FIRST_TIME = 0.2  # the same for a ball that he would not stop
KEEPER_SHARE = 0.7  # of its worth that a pass to the own keeper has
HIGH_LOSS = 0.55  # of the odds
LEAD_TIME, LONG_LEAD = 0.4, 0.2  # s; of the distance, towards the goal
OVERHEAD = 0.6  # share of its way that a high pass is out of reach
ONSIDE = -1.8  # m: he misjudges by this much who is offside

# Clearances
PANIC_SLOT, PANIC_RANGE, PANIC_NEAR = -0.4, 30.0, 2.5  # slots further back; m to the own goal; m to an opponent
CLEARED = 38.0  # m


@kernel
def consider_pass(match, i):
    """Ask for the best pass if it is worth it by now, or for a clearance; return whether a kick was asked for."""
    player = match.players[i]
    if (match.step + player.shirt) % DECIDED_EVERY != 0:
        return False
    waited = min(match.carry_age / PATIENCE, 1.0)
    if best_pass(match, i, PATIENT + (EAGER - PATIENT) * waited):
        return True
    return clear_in_panic(match, i)


@kernel
def consider_first_time_pass(match, i):
    """Ask for the best pass of a ball that has yet to come, if it is a good one."""
    best_pass(match, i, FIRST_TIME)


@kernel
def best_pass(match, i, threshold):
    """Ask for the pass with the greatest worth above `threshold`; return whether there is one."""
    player = match.players[i]
    own = position_value(match, player, player.x, player.y)
    line = max(second_last(match, 1 - player.team, forward(player.team)), forward(player.team) * match.ball.x, 0.0)
    best, found = threshold, False
    for j in range(match.num_players):
        mate = match.players[j]
        distance = apart(mate, player)
        if j == i or mate.team != player.team or not GROUND_LEAST < distance < HIGH_MOST or mate.down_wait > 0.0:
            continue
        if match.offsides and forward(player.team) * mate.x > line - ONSIDE:
            continue
        x, y = mate.x + LEAD_TIME * mate.vx, mate.y + LEAD_TIME * mate.vy
        gain = min(position_value(match, player, x, y) - own, GAIN_MOST)
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
            through = min(position_value(match, player, through_x, through_y) - own, GAIN_MOST)
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
    """Return the place ahead of a mate to which a through ball goes."""
    to_x, to_y = attacked_goal_x(player.team) - mate.x, -mate.y
    share = LONG_LEAD * distance / max(length(to_x, to_y), 1.0)
    return mate.x + LEAD_TIME * mate.vx + share * to_x, mate.y + LEAD_TIME * mate.vy + share * to_y


@kernel
def ground_odds(match, player, x, y):
    """Return the odds in [0, 1] that a pass along the ground from a player to (x, y) gets past his opponents."""
    return max(1.0 - danger(match, player.team, match.ball.x, match.ball.y, x, y, 0.0, 1.0), 0.0)


@kernel
def high_odds(match, player, x, y):
    """Return the odds in [0, 1] that a high pass to (x, y) comes down where no opponent is."""
    found = danger(match, player.team, match.ball.x, match.ball.y, x, y, OVERHEAD, 1.0)
    return max(1.0 - HIGH_LOSS - found, 0.0)


@kernel
def clear_in_panic(match, i):
    """Under pressure near the own goal, as a defender: kick the ball high and far; return whether."""
    player = match.players[i]
    to_own_goal = length(own_goal_x(player.team) - player.x, player.y)
    if player.slot_x > PANIC_SLOT or to_own_goal > PANIC_RANGE or nearest_opponent(match, player) > PANIC_NEAR:
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
    player.is_aimed, player.aim_x, player.aim_y, player.kick_mate = True, x, y, NOBODY
