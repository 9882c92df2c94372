"""The built-in AI: one decision per player and step, for everybody without a command.

Read next: `keeper`, `attack`, `defence`.
"""

from __future__ import annotations

from envs.football.attack import play_ball, support
from envs.football.constants import GK, NOBODY, NORMAL
from envs.football.control import chase
from envs.football.defence import defend, hunt
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
    elif match.carrier == i:
        play_ball(match, i)
    elif match.carrier == NOBODY and match.chaser[player.team] == i and match.game_mode == NORMAL:
        chase(match, i, player.top_speed)
    elif ours(match, player.team):
        support(match, i)
    elif match.chaser[player.team] == i and match.carrier != NOBODY:
        hunt(match, i)
    else:
        defend(match, i)


@kernel
def ours(match, team):
    """Tell whether `team` has the ball, or had it last."""
    return match.last_touch != NOBODY and match.players[match.last_touch].team == team
