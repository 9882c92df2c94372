"""The program's part of a step: behaviors command players, monitors give rewards and end the match.

This is scalar code on one match, called by the simulator's step: behaviors act, the match is played, then monitors run,
so that a monitor sees the result of the step. Without a program `code` is None: each stage returns at once, and Numba
does not compile the rest. `code` holds behaviors and monitors, `registers` [R] their memory, `commands` [O] the
commands of the objects; `cast` maps objects to players.
Read next: `scenic.world_table`, the tables that programs read; `simulator`.
"""

from __future__ import annotations

from regista.envs.football.constants import (
    BUILTIN_AI,
    BY_PROGRAM,
    NO_FAULT,
    NOBODY,
    NUM_COMMANDS,
    PROGRAM_FAULT,
    REJECTED,
    RUNNING,
    TERMINATED,
)
from regista.envs.football.control.agents import in_team_frame
from regista.envs.football.scenic.world_table import THE_BALL, write_world
from regista.kernels.jit import kernel
from scenic_lite.dynamics.machine import bytecode
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND
from scenic_lite.dynamics.machine.vm import end, over, run_behaviors, run_watchers

_FAULT, _REJECTED, _TERMINATED = bytecode.FAULT, bytecode.REJECTED, bytecode.TERMINATED


@kernel
def run_program_behaviors(match, code, cast, registers, commands):
    """Let the behaviors write the commands of their objects; return whether the match goes on.

    If a behavior ends the episode, it ends at once. After a fault, the match is as it was before the step.
    """
    if code is None:
        return True
    write_world(match, cast.players, registers, code.world_base, cast.read)
    run_behaviors(code, registers, commands, match)
    apply_program_verdict(match, registers)
    return match.ended == RUNNING and match.fault == NO_FAULT


@kernel
def run_program_monitors(match, code, cast, registers, commands):
    """Run the monitors on the result of the step: they give rewards and may end the match."""
    if code is None:
        return
    write_world(match, cast.players, registers, code.world_base, cast.read)
    match.program_reward = run_watchers(code, registers, match)
    if match.ended != RUNNING and not over(registers):
        end(code, registers, commands, match)  # may detect a violated requirement
    apply_program_verdict(match, registers)


@kernel
def apply_program_verdict(match, registers):
    """Let the program end the episode: a violated requirement first, then other endings, then `terminate`."""
    if registers[_FAULT] != 0.0:
        match.fault = PROGRAM_FAULT
    elif registers[_REJECTED] != 0.0:
        match.ended, match.terminated, match.truncated = REJECTED, False, True
    elif registers[_TERMINATED] != 0.0 and not match.terminated:
        match.ended, match.terminated, match.truncated = TERMINATED, True, False


@kernel
def command_players(match, object_to_player, commands):
    """Give players the commands of their behaviors. A player that an agent moves in this step ignores them, unless the
    agent leaves the player to the program. In an `agents_only` match, a team with agents ignores commands of all other
    players.

    A command is an action, several actions (`core.world.packed`) or NO_COMMAND.
    """
    for o in range(len(object_to_player)):
        i = object_to_player[o]
        if i == THE_BALL or commands[o] == NO_COMMAND:
            continue
        player = match.players[i]
        if player.agent != NOBODY:
            if match.last_actions[player.agent] != BY_PROGRAM:
                continue
        elif match.agents_only and match.num_agents[player.team] > 0:
            continue
        player.action = commands_in_team_frame(player.team, int(commands[o]))


@kernel
def commands_in_team_frame(team, actions):
    """Rotate all directions among the actions of a right player; the built-in AI's action is always a single action."""
    turned, digit = 0, 1
    while actions > 0:
        action = actions % NUM_COMMANDS
        if action == BUILTIN_AI:
            return BUILTIN_AI
        turned += digit * in_team_frame(team, action)
        digit *= NUM_COMMANDS
        actions //= NUM_COMMANDS
    return turned
