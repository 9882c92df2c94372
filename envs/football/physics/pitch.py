"""A team's direction of play: the goals that it attacks and defends, and its penalty box.

Read next: `physics.ball`.
"""

from __future__ import annotations

from regista.envs.football.constants import BOX_DEPTH, BOX_HALF_WIDTH, HALF_LENGTH, LEFT
from regista.kernels.jit import kernel


@kernel
def forward(team):
    """Return +1 for the team that attacks +x, -1 for the other."""
    return 1.0 if team == LEFT else -1.0


@kernel
def own_goal_x(team):
    """Return x of the goal line that a team defends."""
    return -HALF_LENGTH if team == LEFT else HALF_LENGTH


@kernel
def attacked_goal_x(team):
    """Return x of the goal line that a team attacks."""
    return HALF_LENGTH if team == LEFT else -HALF_LENGTH


@kernel
def in_box_of(team, x, y):
    """Return whether (x, y) is in the penalty box of `team`."""
    return abs(own_goal_x(team) - x) < BOX_DEPTH and abs(y) < BOX_HALF_WIDTH
