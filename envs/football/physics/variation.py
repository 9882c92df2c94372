"""Engine variation: properties of GRF that our measurements leave uncertain differ between episodes.

A policy should not rely on differences below 0.1 s in a keeper's reaction, since engines differ by that much. A program
sets factors by parameters: `param keeper_speed = Range(0.85, 1.15)` is a column of θ, which a teacher may choose.
`engine_spread` samples all factors in each episode, around the program's values.
Read next: `state`, the table of the factors.
"""

from __future__ import annotations

from regista.envs.football.constants import GK
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


@kernel
def vary_engine(match):
    """Sample the factors of a new episode, each within `engine_spread` of its value; the noise only upwards.

    Nothing is sampled if the spread is 0.
    """
    if match.engine_spread == 0.0:
        return
    engine, faster = match.engine, drawn_factor(match)
    engine.keeper_speed *= faster
    engine.reaction_time *= drawn_factor(match)
    engine.start_lag *= drawn_factor(match)
    engine.keeper_range *= drawn_factor(match)
    engine.keeper_reach *= drawn_factor(match)
    engine.tackle_odds *= drawn_factor(match)
    engine.kick_spread *= drawn_factor(match)
    engine.sticky_noise = min(engine.sticky_noise + match.engine_spread * uniform(match), 1.0)
    for i in range(match.num_players):
        player = match.players[i]
        player.reaction_time, player.start_lag = engine.reaction_time, engine.start_lag
        if player.role == GK:
            player.top_speed *= faster


@kernel
def drawn_factor(match):
    """Sample a factor around 1."""
    return 1.0 + match.engine_spread * (2.0 * uniform(match) - 1.0)
