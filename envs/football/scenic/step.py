"""What a program's behaviors and monitors do in a match: they read the world, press players' keys, pay and end it.

Scalar code on one match, like the simulator. One step is: behaviors act, the match is played, monitors watch (spec
section 11.1, its last paragraph). Read next: `simulator`, for the middle; `batch`.
"""

from __future__ import annotations

from envs.football.constants import (
    BUILTIN_AI,
    NO_FAULT,
    NOBODY,
    NUM_COMMANDS,
    PROGRAM_FAULT,
    REJECTED,
    RUNNING,
    TERMINATED,
)
from envs.football.control.agents import assign_actions, seen_by
from envs.football.rules.referee import begin_step
from envs.football.scenic.world_table import THE_BALL, write_world
from envs.football.simulator import play
from scenic_lite.dynamics.machine import bytecode
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND
from scenic_lite.dynamics.machine.vm import end, over, run_behaviors, run_watchers
from scenic_lite.kernels.jit import kernel

_FAULT, _REJECTED, _TERMINATED = bytecode.FAULT, bytecode.REJECTED, bytecode.TERMINATED


@kernel
def step_scripted(match, actions, code, cast, registers, commands):
    """Move a match on by a step with its program: `registers` [R] is what that remembers, `commands` [O] its wishes.

    An episode that a behavior ends, ends at once; a fault leaves the match as it was before the step.
    """
    begin_step(match)
    if match.ended != RUNNING:
        return
    write_world(match, cast, registers, code.world_base)
    run_behaviors(code, registers, commands, match)
    heed(match, registers)
    if match.ended != RUNNING or match.fault != NO_FAULT:
        return
    step_commanded(match, actions, cast, commands)
    write_world(match, cast, registers, code.world_base)
    match.program_reward = run_watchers(code, registers, match)
    if match.ended != RUNNING and not over(registers):
        end(code, registers, commands, match)  # which may leave a requirement unsatisfied
    heed(match, registers)


@kernel
def heed(match, registers):
    """Let the program end the episode: a broken requirement before all else, `terminate` unless it is over anyway."""
    if registers[_FAULT] != 0.0:
        match.fault = PROGRAM_FAULT
    elif registers[_REJECTED] != 0.0:
        match.ended, match.terminated, match.truncated = REJECTED, False, True
    elif registers[_TERMINATED] != 0.0 and not match.terminated:
        match.ended, match.terminated, match.truncated = TERMINATED, True, False


@kernel
def step_commanded(match, actions, cast, commands):
    """Move a match on by a step: the agents take `actions` [A], objects of the program `commands` [O].

    A command is an action, several of them (`world.packed`) or NO_COMMAND; `cast` [O] says which player each object
    is, or THE_BALL.
    """
    begin_step(match)
    if match.ended != RUNNING:
        return
    assign_actions(match, actions)
    command_players(match, cast, commands)
    play(match)


@kernel
def command_players(match, cast, commands):
    """Give players the commands of their behaviors; whom an agent moves in this step obeys the agent."""
    for o in range(len(cast)):
        i = cast[o]
        if i == THE_BALL or commands[o] == NO_COMMAND:
            continue
        if match.players[i].agent != NOBODY:
            continue
        match.players[i].action = as_seen(match.players[i].team, int(commands[o]))


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
