"""The program's part of a step: its behaviors read the world and command players, its monitors pay and end the match.

Scalar code on one match, like the simulator, which calls these stages: behaviors act, the match is played, monitors
watch, so that a monitor sees what the step has brought. Each returns at once where a match has no program: `code` is
None, and Numba leaves the rest out. `code` is that of behaviors and monitors, `registers` [R] what they remember,
`commands` [O] what the objects are to do; `cast` says which player each object is.
Read next: `scenic.world_table`, what programs see; `simulator`.
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
from regista.envs.football.control.agents import seen_by
from regista.envs.football.scenic.world_table import THE_BALL, write_world
from regista.kernels.jit import kernel
from scenic_lite.dynamics.machine import bytecode
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND
from scenic_lite.dynamics.machine.vm import end, over, run_behaviors, run_watchers

_FAULT, _REJECTED, _TERMINATED = bytecode.FAULT, bytecode.REJECTED, bytecode.TERMINATED


@kernel
def run_program_behaviors(match, code, cast, registers, commands):
    """Let the behaviors write what their objects are to do; return whether the match goes on.

    An episode that a behavior ends, ends at once; a fault leaves the match as it was before the step.
    """
    if code is None:
        return True
    write_world(match, cast.players, registers, code.world_base, cast.read)
    run_behaviors(code, registers, commands, match)
    apply_program_verdict(match, registers)
    return match.ended == RUNNING and match.fault == NO_FAULT


@kernel
def run_program_monitors(match, code, cast, registers, commands):
    """Let the monitors see what the step has brought, pay for it, and end the match."""
    if code is None:
        return
    write_world(match, cast.players, registers, code.world_base, cast.read)
    match.program_reward = run_watchers(code, registers, match)
    if match.ended != RUNNING and not over(registers):
        end(code, registers, commands, match)  # which may leave a requirement unsatisfied
    apply_program_verdict(match, registers)


@kernel
def apply_program_verdict(match, registers):
    """Let the program end the episode: a broken requirement before all else, `terminate` unless it is over anyway."""
    if registers[_FAULT] != 0.0:
        match.fault = PROGRAM_FAULT
    elif registers[_REJECTED] != 0.0:
        match.ended, match.terminated, match.truncated = REJECTED, False, True
    elif registers[_TERMINATED] != 0.0 and not match.terminated:
        match.ended, match.terminated, match.truncated = TERMINATED, True, False


@kernel
def command_players(match, object_to_player, commands):
    """Give players the commands of their behaviors; whom an agent moves in this step obeys the agent, unless that
    leaves him to the program. Where the match is `agents_only`, a team with agents obeys in nobody else.

    A command is an action, several of them (`core.world.packed`) or NO_COMMAND.
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
        player.action = as_seen(player.team, int(commands[o]))


@kernel
def as_seen(team, actions):
    """Turn every direction among some actions for a right player; the built-in AI's action counts alone."""
    turned, digit = 0, 1
    while actions > 0:
        action = actions % NUM_COMMANDS
        if action == BUILTIN_AI:
            return BUILTIN_AI
        turned += digit * seen_by(team, action)
        digit *= NUM_COMMANDS
        actions //= NUM_COMMANDS
    return turned
