"""The built-in AI: one decision per player and step, for everybody without a command.

Read next: `keeper`, `attack`, `defence`.
"""

from __future__ import annotations

from envs.football.constants import GK, NOBODY
from envs.football.control import chase, run_to
from envs.football.keeper import think_keeper
from scenic_lite.jit import kernel


@kernel
def think(match, i):
    """Decide for player i."""
    player = match.players[i]
    if player.down > 0.0:
        return
    if player.role == GK:
        think_keeper(match, i)
    elif match.chaser[player.team] == i and match.carrier != i and match.carrier == NOBODY:
        chase(match, i, player.top_speed)
    else:
        run_to(player, player.start_x, player.start_y, 5.0)
