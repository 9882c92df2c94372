"""The program's part of a step: its behaviors read the world and command players, its monitors pay and end the match.

Scalar code on one match, like the simulator, which calls these stages: behaviors act, the match is played, monitors
watch, so that a monitor sees what the step has brought. Each returns at once where a match has no program: `script` is
None, and Numba leaves the rest out. Read next: `scenic.world_table`, what programs see; `simulator`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
from envs.football.control.agents import seen_by
from envs.football.scenic.world_table import THE_BALL, write_world
from scenic_lite.dynamics.machine import bytecode
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND, Code
from scenic_lite.dynamics.machine.vm import end, over, run_behaviors, run_watchers
from scenic_lite.kernels.jit import kernel

_FAULT, _REJECTED, _TERMINATED = bytecode.FAULT, bytecode.REJECTED, bytecode.TERMINATED


class Script(NamedTuple):
    """A program in one match: what runs, and what it remembers there."""

    code: Code  # of its behaviors and monitors, the same for all matches
    object_to_player: np.ndarray  # [O] int64, the player that each object of the program is, or THE_BALL
    registers: np.ndarray  # [R] float64, what behaviors and monitors remember
    commands: np.ndarray  # [O] float64, what the objects are to do in this step: see `command_players`


@kernel
def run_program_behaviors(match, script):
    """Let the behaviors write what their objects are to do; return whether the match goes on.

    An episode that a behavior ends, ends at once; a fault leaves the match as it was before the step.
    """
    if script is None:
        return True
    write_world(match, script.object_to_player, script.registers, script.code.world_base)
    run_behaviors(script.code, script.registers, script.commands, match)
    apply_program_verdict(match, script.registers)
    return match.ended == RUNNING and match.fault == NO_FAULT


@kernel
def run_program_monitors(match, script):
    """Let the monitors see what the step has brought, pay for it, and end the match."""
    if script is None:
        return
    write_world(match, script.object_to_player, script.registers, script.code.world_base)
    match.program_reward = run_watchers(script.code, script.registers, match)
    if match.ended != RUNNING and not over(script.registers):
        end(script.code, script.registers, script.commands, match)  # which may leave a requirement unsatisfied
    apply_program_verdict(match, script.registers)


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
def command_players(match, script):
    """Give players the commands of their behaviors; whom an agent moves in this step obeys the agent.

    A command is an action, several of them (`core.world.packed`) or NO_COMMAND.
    """
    if script is None:
        return
    for o in range(len(script.object_to_player)):
        i = script.object_to_player[o]
        if i == THE_BALL or script.commands[o] == NO_COMMAND:
            continue
        if match.players[i].agent != NOBODY:
            continue
        match.players[i].action = as_seen(match.players[i].team, int(script.commands[o]))


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
