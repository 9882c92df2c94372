"""An engine that is not always the same: what is uncertain of the measured one differs from episode to episode.

What a policy learns must not hang on a keeper's last tenth of a second, for no two engines agree on that. A program
sets factors by parameters (`param keeper_speed = Range(0.85, 1.15)`: then they are columns of θ, which a teacher may
choose), and `engine_spread` draws all of them anew for each episode around what the program says.
Read next: `state`, the table of the factors.
"""

from __future__ import annotations

from regista.envs.football.constants import GK
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


@kernel
def vary_engine(match):
    """Draw the factors of an episode about to begin, each by at most `engine_spread` of it; the noise above what it is.

    Nothing is drawn without a spread.
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
    """Draw a factor around 1."""
    return 1.0 + match.engine_spread * (2.0 * uniform(match) - 1.0)
