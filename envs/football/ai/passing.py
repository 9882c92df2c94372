"""Passes of the built-in AI: receiver, kind, and timing; and the clearance of a defender under pressure.

As documented by Google Research Football, the worth of a pass is the gain times the probability of arrival. A player
who has just received the ball waits for a better pass. Read next: `skills.kicks`, which executes passes.
"""

from __future__ import annotations

from typing import NamedTuple

from regista.envs.football.ai.formation import MINDSET
from regista.envs.football.ai.interception import danger
from regista.envs.football.ai.position_value import nearest_opponent, position_value
from regista.envs.football.ai.support import onside_line
from regista.envs.football.constants import GK, HALF_LENGTH, HALF_WIDTH, HIGH_PASS, LONG_PASS, NOBODY, SHORT_PASS
from regista.envs.football.physics.pitch import attacked_goal_x, forward, own_goal_x
from regista.envs.football.physics.vectors import apart, length
from regista.kernels.jit import kernel


class Worth(NamedTuple):
    """The worth of a pass, and the minimum worth of passes that are played. There is no maximum length."""

    ground_least: float = 4.0  # m to the receiver of any pass
    high_least: float = 12.0  # m to the receiver of a high pass
    better: float = 0.1  # minimum advantage of the receiver's situation
    gain_most: float = 4.0  # maximum of the gain
    at_once: float = 0.25  # minimum worth just after getting the ball,
    in_time: float = 0.035  # falling to this
    patience: float = 50.0  # within this many steps
    first_time: float = 0.2  # minimum worth of a first-time pass
    keeper_share: float = 0.7  # factor of the worth of a pass to the own keeper
    high_loss: float = 0.55  # factor of the odds of a high pass
    lead: float = 0.4  # s by which a receiver's run is extrapolated
    long_lead: float = 0.2  # share of the distance, by which the target is moved towards the goal
    overhead: float = 0.6  # share of its way on which a high pass is out of reach
    onside: float = -1.8  # m, error in judging offside


class Panic(NamedTuple):
    """Clearances."""

    mindset: float = 0.25  # players less attacking than this clear the ball
    range: float = 30.0  # m to the own goal
    near: float = 2.5  # m to an opponent
    cleared: float = 38.0  # m, length of a clearance


# Documented by Google Research Football; odds and patience are fitted: `lab.benchmarks --suite grf`, family matches.
WORTH, PANIC = Worth(), Panic()
DECIDED_EVERY = 2  # steps


@kernel
def consider_pass(match, i):
    """Request the best pass if its worth exceeds the current threshold, or a clearance; return whether either was
    requested.
    """
    player = match.players[i]
    if (match.step + player.shirt) % DECIDED_EVERY != 0:
        return False
    waited = min(match.carry_age / WORTH.patience, 1.0)
    if best_pass(match, i, WORTH.at_once + (WORTH.in_time - WORTH.at_once) * waited):
        return True
    return clear_in_panic(match, i)


@kernel
def consider_first_time_pass(match, i):
    """Request the best first-time pass of an approaching ball, if it is a good one."""
    best_pass(match, i, WORTH.first_time)


@kernel
def best_pass(match, i, threshold):
    """Request the pass with the greatest worth above `threshold`; return whether there is one."""
    player = match.players[i]
    own = position_value(match, player, player.x, player.y)
    line = onside_line(match, player.team)
    best, better = threshold, False
    for j in range(match.num_players):
        mate = match.players[j]
        distance = apart(mate, player)
        if j == i or mate.team != player.team or distance <= WORTH.ground_least or mate.down_wait > 0.0:
            continue
        if match.offsides and forward(player.team) * mate.x > line - WORTH.onside:
            continue
        x, y = mate.x + WORTH.lead * mate.vx, mate.y + WORTH.lead * mate.vy
        gain = min(position_value(match, player, x, y) - own, WORTH.gain_most)
        gain *= WORTH.keeper_share if mate.role == GK else 1.0
        if gain < max(WORTH.better, best):
            continue
        kind, worth, x, y = best_kind(match, player, mate, own, gain)
        if worth > best:
            best, better = worth, True
            ask_kick(player, kind, x, y)
            player.kick_mate = j
    return better


@kernel
def best_kind(match, player, mate, own, gain):
    """Compare a pass to a teammate's feet, into the run, and through the air: kind, worth, and target.

    `own` is the value of the player's own situation, `gain` the teammate's advantage over it.
    """
    distance = apart(mate, player)
    x, y = mate.x + WORTH.lead * mate.vx, mate.y + WORTH.lead * mate.vy
    kind, worth, aim_x, aim_y = SHORT_PASS, gain * ground_odds(match, player, x, y), x, y
    if forward(player.team) * mate.vx > 2.0:
        through_x, through_y = into_run(player, mate, distance)
        through = min(position_value(match, player, through_x, through_y) - own, WORTH.gain_most)
        through *= ground_odds(match, player, through_x, through_y)
        if through > worth:
            kind, worth, aim_x, aim_y = LONG_PASS, through, through_x, through_y
    if distance > WORTH.high_least:
        high = gain * high_odds(match, player, x, y)
        if high > worth:
            kind, worth, aim_x, aim_y = HIGH_PASS, high, x, y
    return kind, worth, aim_x, aim_y


@kernel
def into_run(player, mate, distance):
    """Return the point ahead of a teammate to which a through ball goes."""
    to_x, to_y = attacked_goal_x(player.team) - mate.x, -mate.y
    share = WORTH.long_lead * distance / max(length(to_x, to_y), 1.0)
    return mate.x + WORTH.lead * mate.vx + share * to_x, mate.y + WORTH.lead * mate.vy + share * to_y


@kernel
def ground_odds(match, player, x, y):
    """Return the odds in [0, 1] that a ground pass from a player to (x, y) gets past the opponents."""
    return max(1.0 - danger(match, player.team, match.ball.x, match.ball.y, x, y, 0.0, 1.0), 0.0)


@kernel
def high_odds(match, player, x, y):
    """Return the odds in [0, 1] that a high pass to (x, y) comes down away from opponents."""
    risk = danger(match, player.team, match.ball.x, match.ball.y, x, y, WORTH.overhead, 1.0)
    return max(1.0 - WORTH.high_loss - risk, 0.0)


@kernel
def clear_in_panic(match, i):
    """Let a defender under pressure near the own goal clear the ball; return whether it does."""
    player = match.players[i]
    to_own_goal = length(own_goal_x(player.team) - player.x, player.y)
    attacker = MINDSET[match.players[player.post].role]
    if attacker >= PANIC.mindset or to_own_goal > PANIC.range or nearest_opponent(match, player) > PANIC.near:
        return False
    x = player.x + forward(player.team) * PANIC.cleared
    y = player.y * 1.3 + 4.0 * player.vy / (1.0 + abs(player.vy))
    limit_x, limit_y = HALF_LENGTH - 5.0, HALF_WIDTH - 5.0
    ask_kick(player, HIGH_PASS, min(max(x, -limit_x), limit_x), min(max(y, -limit_y), limit_y))
    return True


@kernel
def ask_kick(player, kick, x, y):
    """Request a kick to a given target."""
    player.kick, player.kick_held, player.kick_ready = kick, 1, True
    player.is_aimed, player.aim_x, player.aim_y, player.kick_mate = True, x, y, NOBODY
