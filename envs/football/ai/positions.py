"""The target position of a built-in player without the ball: slot, support of the ball, marking, defensive line.

The stages are those of Google Research Football and the same with and without the ball: the share of possession
determines their weights. Read next: `ai.formation`, `ai.support`, `ai.defence`, in that order.
"""

from __future__ import annotations

from typing import NamedTuple

from regista.envs.football.ai.defence import guard_share, guarding_place, held_by_line, run_round
from regista.envs.football.ai.formation import LINE, between, slot_position, slot_position_for, smooth
from regista.envs.football.ai.run_speed import head_for
from regista.envs.football.ai.support import runs_behind, support_share, supporting_place
from regista.envs.football.constants import CF, NOBODY
from regista.envs.football.physics.possession import first_at_ball, man_on_ball
from regista.envs.football.physics.vectors import apart
from regista.kernels.jit import kernel


class Own(NamedTuple):
    """The weight of a player's own slot against the exchanged one, far from the ball."""

    share: tuple[float, ...] = (1.0, 0.9, 0.8)  # backs, midfield, forwards
    near: float = 15.0  # m to the player on the ball; up to here the exchanged slot counts
    far: float = 20.0  # m; from here on the player's own slot counts


# Documented by Google Research Football; families academy and matches of `lab.benchmarks --suite grf`.
OWN = Own()
STRIDE = 3  # steps of a stride, at whose end a player chooses a new target; the phase depends on the shirt number
NEAR_BALL = 10.0  # m to the ball; nearer players choose a target in every step


@kernel
def take_position(match, i):
    """Run to player i's target. It is chosen at the end of each stride, or in every step near the ball and when
    marking the carrier.
    """
    player = match.players[i]
    rival = man_on_ball(match, 1 - player.team)
    on_carrier = player.marked_opponent != NOBODY and player.marked_opponent == match.carrier
    is_back = player.place_step < match.step - 1
    player.place_step = match.step
    is_first = match.chaser[player.team] == i
    at_once = match.step <= 1 or is_back or on_carrier or is_first or apart(match.ball, player) < NEAR_BALL
    if not at_once and (match.step + player.shirt) % STRIDE != 0:
        return
    choose_place(match, i)
    if on_carrier and run_round(player, match.players[match.carrier], player.place_x, player.place_y):
        return
    head_for(match, player, player.place_x, player.place_y, match.players[rival if rival != NOBODY else i])


@kernel
def choose_place(match, i):
    """Set player i's target."""
    player = match.players[i]
    first = first_at_ball(match)
    if first == NOBODY:
        return
    x, y = own_place(match, i, first)
    carrier = man_on_ball(match, player.team)
    share = support_share(match, player)
    if carrier != NOBODY and share > 0.0:
        help_x, help_y = supporting_place(match, i, x, y, carrier, runs_behind(match, i, share))
        x, y = x + share * (help_x - x), y + share * (help_y - y)
    if player.marked_opponent != NOBODY:
        share = guard_share(match, player)
        if share > 0.0:
            guard_x, guard_y = guarding_place(match, player, x, y)
            x, y = x + share * (guard_x - x), y + share * (guard_y - y)
    if player.role != CF:
        x = held_by_line(match, player.team, x)
    player.place_x, player.place_y = x, y


@kernel
def own_place(match, i, first):
    """Return the position of player i's slot: the exchanged slot near the ball, the player's own slot far from it."""
    player = match.players[i]
    far = between(apart(player, match.players[first]), OWN.near, OWN.far)
    if player.post == i:
        return slot_position(match, i, first)
    if far == 0.0:
        return slot_position_for(match, player, player.post, first)
    share = smooth(OWN.share[LINE[player.role]] * far, 1.0)
    x, y = slot_position(match, i, first)
    if share < 1.0:
        slot_x, slot_y = slot_position_for(match, player, player.post, first)
        x, y = slot_x + share * (x - slot_x), slot_y + share * (y - slot_y)
    return x, y
