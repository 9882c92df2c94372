"""The batch loop: N matches, each stepped, rewarded and observed. An ended match stays at its end until it is reset.

This is the only loop over matches, and the only parallel one; all functions that it calls are scalar code on one match.
A match never reads another one, so the result is the same for any number of threads. Read next: `simulator`, for one
step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from regista.envs.football.constants import IDLE, NO_ACTION, NO_FAULT, NOBODY
from regista.envs.football.control.actions import main_action
from regista.envs.football.control.agents import in_team_frame, num_agents
from regista.envs.football.control.episode import has_succeeded
from regista.envs.football.control.reward import agent_reward, team_reward
from regista.envs.football.observation.observe import observe, remember_minimap
from regista.envs.football.physics.motion import take_stance
from regista.envs.football.physics.variation import vary_engine
from regista.envs.football.scenic.scripted_step import (
    commands_in_team_frame,
    run_program_behaviors,
    run_program_monitors,
)
from regista.envs.football.scenic.world_table import THE_BALL, Cast
from regista.envs.football.simulator import choose_actions, play
from regista.envs.football.state import MATCH
from regista.kernels.jit import kernel
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND

# MATCH with fields as attributes: one object for all batches, or Numba compares two types field by field in every step
RECORD = np.dtype((np.record, MATCH))


class Batch(NamedTuple):
    """N matches with all of their state, and the initial state of each."""

    matches: np.ndarray  # MATCH [N]
    starts: np.ndarray  # MATCH [N]
    registers: np.ndarray  # [N, R] float64, of the program's behaviors and monitors
    start_registers: np.ndarray  # [N, R] float64, their initial values
    commands: np.ndarray  # [N, O] float64, commands of the program's objects for this step
    minimap_places: np.ndarray  # [N, 4, P + 1, 2] float64, positions of the last 4 steps, for `smm_stacked`
    minimap_agents: np.ndarray  # [N, 4, A] int64, the agents' players in these steps
    idle: np.ndarray  # [N] bool, matches that are not stepped any more


class Pool(NamedTuple):
    """Initial states on the levels that new episodes may use."""

    matches: np.ndarray  # MATCH [B]
    registers: np.ndarray  # [B, R] float64


class Outcome(NamedTuple):
    """The result of a step, one row per match; written by `step_batch`, read by the environment."""

    rewards: np.ndarray  # [N] float64, see `reward.team_reward`
    agent_rewards: np.ndarray  # [N, A] float64
    terminated: np.ndarray  # [N] bool
    truncated: np.ndarray  # [N] bool
    success: np.ndarray  # [N] bool, see `episode.has_succeeded`
    ended: np.ndarray  # [N] int64, `constants.RUNNING` .. `REJECTED`
    faults: np.ndarray  # [N] int64
    agent_actions: np.ndarray  # [N, A] int64, the action of each agent's player: one of the 19 actions, or NO_ACTION


class BatchSettings(NamedTuple):
    """Settings that all matches share."""

    checkpoints: bool  # whether checkpoints are rewarded
    defending: bool  # an episode succeeds if no goal is conceded
    rewarding: bool  # the program defines rewards, so a return above 0 is a success
    observation: int  # the agents' representation: `observation.FEATURES` to `RAW`
    scripted: bool  # the program has behaviors or monitors; without them these stages are skipped
    object_to_player: np.ndarray  # [O] int64, the player of each object of the program, or THE_BALL
    objects_read: np.ndarray  # [O] int64, which fields of each object the program reads: see `Cast`


def empty_batch(count: int, registers: int, objects: int, minimap_history: tuple[np.ndarray, np.ndarray]) -> Batch:
    """Allocate `count` matches, as records whose fields are attributes, also in uncompiled code."""
    matches, starts = (np.zeros(count, RECORD).view(np.recarray) for _ in range(2))
    memory, start_memory = (np.zeros((count, registers)) for _ in range(2))
    commands = np.zeros((count, objects))
    return Batch(matches, starts, memory, start_memory, commands, *minimap_history, np.zeros(count, np.bool_))


def empty_outcome(count: int, agents: int) -> Outcome:
    """Allocate the results of `count` matches with `agents` agents each."""
    return Outcome(
        np.zeros(count),
        np.zeros((count, agents)),
        np.zeros(count, bool),
        np.zeros(count, bool),
        np.zeros(count, bool),
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
        np.full((count, agents), NO_ACTION),
    )


@kernel(parallel=True)
def step_batch(batch, actions, outcome, seen, settings, code):
    """Step N matches of a program with actions `[N, A]`; write the agents' observations into the View `seen`."""
    for index in prange(len(batch.matches)):
        # A single call, because Numba's parallel pass reorders the statements of a loop body and overlooks that they
        # share the record.
        _step_row(batch, actions, outcome, seen, settings, code, np.int64(index))  # prange counts unsigned


@kernel(inline=True)
def _step_row(batch, actions, outcome, seen, settings, code, index):
    """Step, reward and observe one match."""
    if begin_row(batch, actions, settings, code, index):
        play(batch.matches[index])
        run_monitors(batch, settings, code, index)
    finish_row(batch, outcome, seen, settings, index)


@kernel(inline=True)
def begin_row(batch, actions, settings, code, index):
    """Give every player of a match an action; return whether the match is stepped."""
    if batch.idle[index]:
        return False
    match = batch.matches[index]
    if settings.scripted:
        registers, commands = batch.registers[index], batch.commands[index]
        return choose_actions(match, actions[index], code, cast_of(settings), registers, commands)
    return choose_actions(match, actions[index], None, None, None, None)


@kernel(inline=True)
def cast_of(settings):
    """Return the players of the program's objects, and which of their fields the program reads."""
    return Cast(settings.object_to_player, settings.objects_read)


@kernel
def ask_program(matches, registers, commands, cast, code, actions):
    """Write the actions that the program's behaviors would choose for the agents' players into `actions` [N, A].

    This runs the behaviors: matches, registers and commands must be copies.
    """
    for index in range(len(matches)):
        match = matches[index]
        actions[index] = IDLE
        if not run_program_behaviors(match, code, cast, registers[index], commands[index]):
            continue
        for o in range(len(cast.players)):
            command = commands[index, o]
            if cast.players[o] == THE_BALL or command == NO_COMMAND:
                continue
            player = match.players[cast.players[o]]
            if player.agent != NOBODY:
                action = main_action(player, commands_in_team_frame(player.team, int(command)))
                actions[index, player.agent] = in_team_frame(player.team, action)


@kernel(inline=True)
def run_monitors(batch, settings, code, index):
    """Run the program's monitors on the state after the step."""
    if settings.scripted:
        registers, commands = batch.registers[index], batch.commands[index]
        run_program_monitors(batch.matches[index], code, cast_of(settings), registers, commands)


@kernel(inline=True)
def finish_row(batch, outcome, seen, settings, index):
    """Reward and observe a match; an idle match gets no reward and NO_ACTION."""
    if batch.idle[index]:
        outcome.terminated[index] = outcome.truncated[index] = False
        outcome.faults[index] = NO_FAULT
        outcome.agent_actions[index] = NO_ACTION
        return
    match = batch.matches[index]
    outcome.rewards[index] = team_reward(match, settings.checkpoints)
    for agent in range(num_agents(match)):
        outcome.agent_rewards[index, agent] = agent_reward(match, agent, settings.checkpoints)
        action = match.last_actions[agent]
        outcome.agent_actions[index, agent] = max(action, NO_ACTION)  # GRF does not report its AI's decisions
    outcome.terminated[index] = match.terminated
    outcome.truncated[index] = match.truncated
    outcome.success[index] = has_succeeded(match, settings.defending)
    outcome.ended[index] = match.ended
    outcome.faults[index] = match.fault
    remember_minimap(batch, index, settings.observation)
    observe(batch, index, seen, settings.observation)


@kernel
def begin(batch, where, luck, settings):
    """Reset the matches `where` (indices `[k]`) to their initial states, with random streams `luck` uint64 `[k]`."""
    for at in range(len(where)):
        begin_match(batch, where[at], luck[at], settings)


@kernel
def begin_match(batch, index, luck, settings):
    """Reset one match to its initial state, with the random stream `luck`."""
    batch.matches[index] = batch.starts[index]
    if not batch.matches[index].deterministic:  # otherwise every episode uses the stream of its initial state
        batch.matches[index].random = luck
    for register in range(batch.registers.shape[1]):  # by element, since assigning a row would first make a copy
        batch.registers[index, register] = batch.start_registers[index, register]
    # Drawn in each episode: the variation of the engine, and the players' stances at the first whistle.
    vary_engine(batch.matches[index])
    take_stance(batch.matches[index])
    remember_minimap(batch, index, settings.observation)


@kernel
def observe_batch(batch, seen, settings):
    """Write the observations of all matches into the View `seen`."""
    for index in range(len(batch.matches)):
        observe(batch, index, seen, settings.observation)
