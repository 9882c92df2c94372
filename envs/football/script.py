"""What a program's behaviors and monitors do in a match: they read the world, press players' keys, pay and end it.

Scalar code on one match, like the simulator. Read next: `simulator`, for the rest of a step; `batch`.
"""

from __future__ import annotations

from envs.football.constants import BAD_ACTION, BUILTIN_AI, RUNNING
from envs.football.rules import begin_step
from envs.football.simulator import assign_actions, play
from envs.football.world_table import THE_BALL, seen_by
from scenic_lite.jit import kernel


@kernel
def step_commanded(match, action, cast, commands):
    """Move a match on by a step: the learner takes `action`, objects of the program `commands` [O], negative for none.

    `cast` [O]: the player that each object is, or THE_BALL.
    """
    begin_step(match)
    if match.ended != RUNNING:
        return
    assign_actions(match, action)
    command_players(match, cast, commands)
    play(match)


@kernel
def command_players(match, cast, commands):
    """Give players the commands of their behaviors; whom the learner moves in this step obeys the learner."""
    for o in range(len(cast)):
        i = cast[o]
        if i == THE_BALL or i == match.controlled or commands[o] < 0.0:
            continue
        if not 0.0 <= commands[o] <= BUILTIN_AI or commands[o] != int(commands[o]):
            match.fault = BAD_ACTION
            continue
        match.players[i].action = seen_by(match.players[i].team, int(commands[o]))
