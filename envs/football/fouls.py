"""Fouls: what a tackle reports, and what the referee makes of it: advantage, free kick, penalty, cards.

The rules are Google Research Football's. `contacts` decides whether a tackle is a foul and how severe, and calls
`report_foul`; `rules` calls the rest at the end of a step. Read next: `whistle`.
"""

from __future__ import annotations

from envs.football.constants import NOBODY
from scenic_lite.jit import kernel

SEVERE, YELLOW_FROM, RED_FROM = 1.0, 1.4, 2.0  # severities above which it is a foul, a yellow and a red card


@kernel
def report_foul(match, player, victim, severity, slid):
    """Tell the referee that `player` fouled `victim`; play goes on until the step ends, or longer for an advantage.

    `severity` grows to about 2: a slide that never met the ball counts 1, coming from behind up to 1 more; at most 1
    is no foul. A trip (not `slid`) is never a card and gets an advantage. The first foul of a step counts.
    """
    if match.foul_player != NOBODY or match.game_mode != 0 or match.players[player].off:
        return
    if slid and severity <= SEVERE:
        return
    match.foul_player, match.foul_victim = player, victim
    match.foul_severity = severity if slid else 0.0
    match.foul_x, match.foul_y = match.players[victim].x, match.players[victim].y
    match.foul_age, match.advantage = 0.0, not slid
