"""The batch loop: N matches, each stepped, rewarded and observed. One that has ended stays at its end until it begins.

This is the only loop over matches, and the only parallel one; all that it calls is scalar code on one match. A match
never reads another, so the result is the same for any number of threads. Read next: `simulator`, for one step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from regista.envs.football.constants import IDLE, NO_ACTION, NO_FAULT, NOBODY
from regista.envs.football.control.actions import main_action
from regista.envs.football.control.agents import num_agents, seen_by
from regista.envs.football.control.episode import has_succeeded
from regista.envs.football.control.reward import agent_reward, team_reward
from regista.envs.football.observation.observe import observe, remember_minimap
from regista.envs.football.physics.motion import take_stance
from regista.envs.football.physics.variation import vary_engine
from regista.envs.football.scenic.scripted_step import as_seen, run_program_behaviors, run_program_monitors
from regista.envs.football.scenic.world_table import THE_BALL, Cast
from regista.envs.football.simulator import choose_actions, play
from regista.envs.football.state import MATCH
from regista.kernels.jit import kernel
from scenic_lite.dynamics.machine.bytecode import NO_COMMAND

# MATCH with fields as attributes: one object for all batches, or Numba compares two types field by field in every step
RECORD = np.dtype((np.record, MATCH))


class Batch(NamedTuple):
    """N matches with all that they remember, and what each starts from when its episode begins."""

    matches: np.ndarray  # MATCH [N]
    starts: np.ndarray  # MATCH [N]
    registers: np.ndarray  # [N, R] float64, of the program's behaviors and monitors
    start_registers: np.ndarray  # [N, R] float64
    commands: np.ndarray  # [N, O] float64, what the program's objects want in this step
    minimap_places: np.ndarray  # [N, 4, P + 1, 2] float64, of the last steps, for observations that need them: `smm`
    minimap_agents: np.ndarray  # [N, 4, A] int64, the same of the agents' players
    idle: np.ndarray  # [N] bool, matches that nobody plays and that stand still


class Outcome(NamedTuple):
    """What a step brought, one row per match; written by `step_batch`, read by the environment."""

    rewards: np.ndarray  # [N] float64, see `reward.team_reward`
    agent_rewards: np.ndarray  # [N, A] float64
    terminated: np.ndarray  # [N] bool
    truncated: np.ndarray  # [N] bool
    success: np.ndarray  # [N] bool, see `episode.has_succeeded`
    ended: np.ndarray  # [N] int64, `constants.RUNNING` .. `REJECTED`
    faults: np.ndarray  # [N] int64
    agent_actions: np.ndarray  # [N, A] int64, what was done for each agent: one of the 19 actions, or NO_ACTION


class BatchSettings(NamedTuple):
    """What is the same for all matches."""

    checkpoints: bool  # checkpoints count
    defending: bool  # an episode succeeds where no goal is conceded
    observation: int  # what agents see: `observation.FEATURES` to `RAW`
    scripted: bool  # the program has behaviors or monitors; one without costs nothing
    object_to_player: np.ndarray  # [O] int64, the player that each object of the program is, or THE_BALL
    objects_read: np.ndarray  # [O] int64, what of them it reads: see `Cast`


def empty_batch(count: int, registers: int, objects: int, minimap_history: tuple[np.ndarray, np.ndarray]) -> Batch:
    """Make room for `count` matches; records whose fields are attributes even when not compiled."""
    matches, starts = (np.zeros(count, RECORD).view(np.recarray) for _ in range(2))
    memory, start_memory = (np.zeros((count, registers)) for _ in range(2))
    commands = np.zeros((count, objects))
    return Batch(matches, starts, memory, start_memory, commands, *minimap_history, np.zeros(count, np.bool_))


def empty_outcome(count: int, agents: int) -> Outcome:
    """Make room for what `count` matches bring to so many agents each."""
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
    """Step N matches of a program with actions `[N, A]`; what the agents see goes into the View `seen`."""
    for index in prange(len(batch.matches)):
        # One call: Numba's parallel pass reorders the statements of a loop body, and does not see that they share
        # the record.
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
    """Give every player of a match his action; return whether it is to be played."""
    if batch.idle[index]:
        return False
    match = batch.matches[index]
    if settings.scripted:
        registers, commands = batch.registers[index], batch.commands[index]
        return choose_actions(match, actions[index], code, cast_of(settings), registers, commands)
    return choose_actions(match, actions[index], None, None, None, None)


@kernel(inline=True)
def cast_of(settings):
    """Return whom the objects of the program stand for."""
    return Cast(settings.object_to_player, settings.objects_read)


@kernel
def ask_program(matches, registers, commands, cast, code, actions):
    """Write what the program's behaviors would have the agents' players do into `actions` [N, A].

    Behaviors run for it: matches, registers and commands must be copies.
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
                key = main_action(player, as_seen(player.team, int(command)))
                actions[index, player.agent] = seen_by(player.team, key)


@kernel(inline=True)
def run_monitors(batch, settings, code, index):
    """Let the program's monitors see what has been played."""
    if settings.scripted:
        registers, commands = batch.registers[index], batch.commands[index]
        run_program_monitors(batch.matches[index], code, cast_of(settings), registers, commands)


@kernel(inline=True)
def finish_row(batch, outcome, seen, settings, index):
    """Reward and observe a match, whether it was to be played or not."""
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
        outcome.agent_actions[index, agent] = max(action, NO_ACTION)  # the real engine does not tell what its AI wants
    outcome.terminated[index] = match.terminated
    outcome.truncated[index] = match.truncated
    outcome.success[index] = has_succeeded(match, settings.defending)
    outcome.ended[index] = match.ended
    outcome.faults[index] = match.fault
    remember_minimap(batch, index, settings.observation)
    observe(batch, index, seen, settings.observation)


@kernel
def begin(batch, where, luck, settings):
    """Put the matches `where` (indices `[k]`) at their start, with the random streams `luck` uint64 `[k]`."""
    for at in range(len(where)):
        index = where[at]
        batch.matches[index] = batch.starts[index]
        if not batch.matches[index].deterministic:  # else every episode repeats the stream of the start
            batch.matches[index].random = luck[at]
        for register in range(batch.registers.shape[1]):  # one by one: NumPy's way would first make a copy
            batch.registers[index, register] = batch.start_registers[index, register]
        # What differs from episode to episode: the engine, and in what movement the whistle finds everybody.
        vary_engine(batch.matches[index])
        take_stance(batch.matches[index])
        remember_minimap(batch, index, settings.observation)


@kernel
def observe_batch(batch, seen, settings):
    """Write what the agents of all matches see into the View `seen`."""
    for index in range(len(batch.matches)):
        observe(batch, index, seen, settings.observation)
