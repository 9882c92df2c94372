"""Football as a UPOMDP: N matches that a Scenic program describes, each on its own level, stepped as one batch.

Read next: `scenic.lineup`, how a program becomes a match; `batch`, how matches are stepped.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete, MultiDiscrete

from regista.envs.football.batch import (
    RECORD,
    BatchSettings,
    Pool,
    ask_program,
    empty_batch,
    empty_outcome,
    observe_batch,
)
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import BY_PROGRAM, NO_FAULT, NUM_ACTIONS
from regista.envs.football.engine import Engine, Simulator
from regista.envs.football.limits import Limits, StateError
from regista.envs.football.observation.observe import FEATURES, SIMPLE115
from regista.envs.football.observation.observer import Observer
from regista.envs.football.scenic.compiled_behaviors import CompiledBehaviors
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.initial_states import INVALID, InitialStates
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.scenic.world_table import Cast
from regista.envs.football.state import WHO
from regista.kernels.calls import compiles
from regista.kernels.rng import stream
from scenic_lite import Program, load
from ued.core.begun import check_begun
from ued.core.compiled import CompiledRollout
from ued.core.level_space import as_void_view
from ued.core.upomdp import UPOMDP, check_count


class FootballVectorEnv(UPOMDP):
    """N football matches with A agents; by default one agent moves the left player closest to the ball.

    The program's behaviors move their players, except those that an agent moves; the built-in AI moves the rest. With
    one agent, actions are `[N]` and observations have no agent axis; with several, actions are `[N, A]`.

    Args:
        program: a compiled program, the path of one, or its text.
        num_envs: N.
        config: observations, rewards, and the players that agents move (see `control_modes`).

    Actions are Google Research Football's 19; `observation` lists the observations. A match is terminated by a goal, a
    possession change, the ball out of play, or the program's `terminate`. It is truncated at `game_duration`, or if it
    violates a requirement of the program. Infos:

    - `info["ended"]` `[N]`: the reason of the end, `constants.RUNNING` to `REJECTED`.
    - `info["success"]` `[N]`: the agents' team has scored more goals than the other, or with `param defending = True`
      has conceded none. NaN if the program defines rewards; a return above 0 is then a success.
    - `info["agent_rewards"]` `[N, A]`: each agent's reward, including the `scenic_reward` of monitors; `rewards` `[N]`
      is the mean over the left team's agents.
    - `info["agent_actions"]` `[N, A]`: the agents' actions, -1 if none of the 19 describes the step
      (`with_scripted_policy`).
    - `info["records"]`: the values recorded in the step, by name: `[N]`, vectors `[N, 2]`, NaN where none was recorded
      (None for values that are not numbers).

    A UserWarning names each line that is probably a mistake (`Program.warnings`), or that fails in every match that
    reaches it.

    Raises:
        scenic_lite.ScenicError: a broken program. `step` raises it if the program fails at run time: that match begins
            its next episode, and the others have completed the step.
        lineup.NotAMatchError: a program that does not describe a match.
    """

    seed_is_luck = True  # θ fixes the scene; all draws during a match, also by the program, depend on the seed

    def __init__(
        self,
        program: Program | str | Path,
        num_envs: int = 1,
        *,
        config: FootballConfig = FootballConfig(),  # noqa: B008 (frozen)
    ) -> None:
        self.program = program if isinstance(program, Program) else load(program, FOOTBALL, config.dialect)
        self.config = config
        self.lineup = Lineup(self.program, str(config.control), str(config.right_control), config.engine_spread)
        self.behaviors = CompiledBehaviors(self.program)
        for warning in dict.fromkeys((*map(str, self.program.warnings), *self.behaviors.compiled.warnings)):
            warnings.warn(warning, stacklevel=2)
        self._set_up(num_envs)

    def _set_up(self, num_envs: int) -> None:
        """Create spaces and arrays for `num_envs` matches of the program."""
        config, num_envs, self.theta_map = self.config, check_count(num_envs), self.program
        self.num_players = self.lineup.num_players
        self.num_agents = sum(self.lineup.num_agents)
        self._observer = Observer(config.representation, self.lineup, config.pixels == "sparse")
        self._engine = make_engine(config, self.lineup, self.behaviors, num_envs)
        several = MultiDiscrete([NUM_ACTIONS] * self.num_agents)
        actions = Discrete(NUM_ACTIONS) if self.num_agents == 1 else several
        super().__init__(num_envs, self._observer.space, actions, self.program.draws)
        self._settings = BatchSettings(
            checkpoints=config.rewards == "scoring,checkpoints",
            defending=self.defending,
            rewarding=self.behaviors.sets_reward and not self.defending,
            observation=self._observer.kind,
            scripted=self.behaviors.is_live,
            object_to_player=self.lineup.object_to_player,
            objects_read=self.behaviors.objects_read,
        )
        self._initial_states = InitialStates(self.lineup, self.behaviors)
        self._outcome = empty_outcome(num_envs, self.num_agents)
        history = self._observer.minimap_history(num_envs)
        self._batch = empty_batch(num_envs, self.behaviors.num_registers, len(self.program.objects), history)
        match, registers = self.lineup.limits, self.behaviors.limits
        self._limits = {"matches": match, "starts": match, "registers": registers, "start_registers": registers}
        seen = self._batch.minimap_agents[:1].size
        self._limits["minimap_agents"] = Limits.of_array(seen, dict.fromkeys(range(seen), WHO), self.lineup.counts)
        self._begun = np.zeros(num_envs, bool)
        self.scripted = False  # whether the program plays the agents' players: see `with_scripted_policy`

    @property
    def matches(self) -> np.ndarray:
        """The current matches, MATCH `[N]`, as a copy."""
        return self._batch.matches.copy()

    @property
    def individual_rewards(self) -> bool:  # type: ignore[override]
        """Whether both teams have agents, which are then opponents that learn by self-play."""
        return all(self.lineup.num_agents)

    @property
    def first_side(self) -> int:  # type: ignore[override]
        """The number of agents of the left team."""
        return int(self.lineup.num_agents[0])

    @property
    def max_episode_steps(self) -> int | None:  # type: ignore[override]
        """The program's `game_duration`, or its maximum if it depends on θ; None if the maximum is unknown."""
        return self.lineup.longest_game

    @property
    def defending(self) -> bool:
        """Whether success means that no goal is conceded."""
        return bool(self.lineup.config.defending)

    @property
    def observation_scale(self) -> np.ndarray | None:
        return self._observer.unit

    def _playable(self, levels: np.ndarray) -> np.ndarray:
        return self._initial_states.rows(levels) != INVALID

    def prefetch(self, levels: np.ndarray) -> None:
        self._initial_states.prefetch(levels)

    def sample_theta(self, count: int) -> np.ndarray:
        """Sample valid θ `[count, D]` uniformly.

        Raises:
            ScenicError: no valid θ was found; the message contains the rejection report.
        """
        return self.program.sample_theta(count, self.np_random)

    def _start(self, levels: np.ndarray, where: np.ndarray) -> Any:
        batch, rows = self._batch, self._initial_states.rows(levels)
        as_void_view(batch.starts)[where] = as_void_view(self._initial_states.matches)[rows]
        batch.start_registers[where] = self._initial_states.registers[rows]
        self._begin(where)
        return self.observe()

    def play_again(self, where: np.ndarray | None = None) -> Any:
        chosen = np.flatnonzero(self._mask(where))  # their initial states are in the batch
        check_begun(self._begun[chosen], "starting another episode")
        self.episodes[chosen] += 1
        self._begin(chosen)
        return self.observe()

    def _begin(self, where: np.ndarray) -> None:
        """Begin episodes in the environments `where` `[k]`, whose initial states are in the batch."""
        luck = np.array([stream(seed) for seed in self.luck_seeds(where).tolist()], np.uint64)
        self._engine.begin(self._batch, where, luck, self._settings)
        self._begun[where] = True

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        check_begun(self._begun | self.idle, "step()")
        self._batch.idle[:] = self.idle
        out, seen = self._outcome, self._observer.allocate(self.num_envs)
        chosen = np.full_like(out.agent_actions, BY_PROGRAM) if self.scripted else self._checked(actions)
        self._engine.step(self._batch, chosen, out, seen, self._settings)
        if out.faults.any():
            self._report_faults()
        info: dict[str, Any] = {"ended": out.ended.copy(), "success": out.success.astype(float)}
        if self._settings.rewarding:
            info["success"][:] = np.nan
        info["agent_rewards"], info["agent_actions"] = out.agent_rewards.copy(), out.agent_actions.copy()
        if self.behaviors.has_records:
            info["records"] = self.behaviors.recorded(self._batch.registers)
        observations = self._observer.read(seen, self._batch.matches)
        return observations, out.rewards.copy(), out.terminated.copy(), out.truncated.copy(), info

    @property
    def plays_rollouts(self) -> bool:
        vectors = self._observer.kind in (FEATURES, SIMPLE115)
        return vectors and isinstance(self._engine, Simulator) and not self.scripted and compiles()

    def _prepare(self, levels: np.ndarray) -> np.ndarray:
        return self._initial_states.rows(levels)

    def _play(self, rollout: CompiledRollout) -> None:
        assert isinstance(self._engine, Simulator)
        matches = self._initial_states.matches.view(RECORD).view(np.recarray)
        pool, view = Pool(matches, self._initial_states.registers), self._observer.view_of(rollout.envs.observation)
        self._batch.idle[:] = False
        self._engine.play(rollout, self._batch, pool, self._outcome, view, self._settings)

    def report_failure(self) -> None:
        self._report_faults()

    def observe(self) -> Any:
        """Return the current observations in new arrays."""
        seen = self._observer.allocate(self.num_envs)
        observe_batch(self._batch, seen, self._settings)
        return self._observer.read(seen, self._batch.matches)

    def program_actions(self) -> np.ndarray:
        """Return the actions that the program's behaviors would choose for the agents' players next: `[N]` or `[N, A]`.

        The environment does not change. The action is 0 for a player that has no behavior or is left to the built-in
        AI.
        """
        actions = np.zeros((self.num_envs, self.num_agents), np.int64)
        if self.behaviors.is_live:
            copies = [np.copy(array) for array in (self._batch.registers, self._batch.commands)]
            matches = self._batch.matches.copy()
            cast = Cast(self.lineup.object_to_player, self.behaviors.objects_read)
            ask_program(matches, *copies, cast, self.behaviors.code, actions)
        return actions.reshape(self.action_space.shape)

    def _checked(self, actions: Any) -> np.ndarray:
        """Return the actions as int64 `[N, A]`. Raises ValueError for a wrong shape or type, or an unknown action."""
        array, shape = np.asarray(actions), self.action_space.shape
        assert shape is not None
        if array.shape != shape or array.dtype.kind not in "iu":
            size = " x ".join(map(str, shape))
            raise ValueError(f"actions must be {size} whole numbers, got shape {array.shape} of {array.dtype}")
        if array.min() < 0 or array.max() >= NUM_ACTIONS:
            wrong = array[(array < 0) | (array >= NUM_ACTIONS)][0]
            raise ValueError(f"action {wrong} does not exist; actions are 0 to {NUM_ACTIONS - 1}")
        # Kernels would be compiled again for arrays with another memory layout or without write access.
        return np.require(array.reshape(self.num_envs, self.num_agents), np.int64, ("C", "W"))

    def _report_faults(self) -> None:
        """Begin the next episode of the matches that have failed, and raise the error of the first failed match."""
        faulted = self._outcome.faults != NO_FAULT
        index, batch = int(np.flatnonzero(faulted)[0]), self._batch
        match, level = batch.matches[index], self.levels[index]
        where = f"match {index} of {self.num_envs}, step {match['step']}; its level: {level}"
        error = self.behaviors.error(match, batch.registers[index], where)
        self.play_again(faulted)
        raise error

    def get_state(self) -> dict[str, Any]:
        """Return the full state, as arrays and plain values; `set_state` resumes from it bit for bit."""
        batch = self._batch
        return {
            "matches": np.asarray(batch.matches).copy(),
            "starts": np.asarray(batch.starts).copy(),
            "registers": batch.registers.copy(),
            "start_registers": batch.start_registers.copy(),
            "minimap_places": batch.minimap_places.copy(),
            "minimap_agents": batch.minimap_agents.copy(),
            **self.level_state(),
            **self._engine.get_state(),
        }

    def set_state(self, state: dict[str, Any]) -> Any:
        """Restore what `get_state` returned; return the observations of that state.

        Raises:
            StateError: a state that does not fit (another number of matches, program or representation, or invalid
                values: see `state`); the environment is then unchanged.
        """
        batch = self._batch
        pairs = {
            "matches": batch.matches,
            "starts": batch.starts,
            "registers": batch.registers,
            "start_registers": batch.start_registers,
            "minimap_places": batch.minimap_places,
            "minimap_agents": batch.minimap_agents,
        }
        check_state(state, pairs)
        for name, limits in self._limits.items():
            limits.check(state[name], name)
        self._engine.check_state(state, self.num_envs)
        self.set_level_state(state)
        for name, array in pairs.items():
            bytes_of(array)[:] = bytes_of(state[name])  # as bytes, since a copy field by field takes ten times as long
        self._engine.set_state(state, batch)
        self._begun[:] = np.asarray(batch.matches)["num_players"] > 0
        return self.observe()

    def with_scripted_policy(self) -> FootballVectorEnv:
        """Return a copy in which the program's behaviors, or the built-in AI, play the agents' players.

        The copy begins new episodes of the same levels and ignores actions. Agents keep their players and observations;
        `info["agent_actions"]` holds one action per agent and step: the main action of the program's command, or the
        action nearest to the built-in AI's decision.
        """
        twin = self.copy()
        twin.scripted = True
        twin.reset_to_levels(self.levels, None, self.visits)
        return twin

    def resized(self, num_envs: int) -> FootballVectorEnv:
        """Return an environment with `num_envs` matches of the same program and settings, not yet reset.

        It shares the line-up and the compiled behaviors, which take longest to create.
        """
        twin = FootballVectorEnv.__new__(FootballVectorEnv)
        twin.program, twin.config = self.program, self.config
        twin.lineup, twin.behaviors = self.lineup, self.behaviors
        twin._set_up(num_envs)
        return twin

    def copy(self) -> FootballVectorEnv:
        """Return an independent environment in the same state."""
        twin = self.resized(self.num_envs)
        twin.scripted = self.scripted
        twin.set_state(self.get_state())
        return twin

    def close_extras(self, **kwargs: Any) -> None:
        """Free the engine's resources."""
        self._engine.close()


def make_engine(config: FootballConfig, lineup: Lineup, behaviors: CompiledBehaviors, num_envs: int) -> Engine:
    """Make the engine for `num_envs` matches. Raises `envs.grf.workers.GrfError` if GRF is not installed."""
    if config.engine == "grf":
        from regista.envs.grf.engine import GrfEngine

        return GrfEngine(lineup, behaviors, config, num_envs)
    return Simulator(behaviors.code)


def bytes_of(array: np.ndarray) -> np.ndarray:
    """Return the content of an array as bytes: a view if it is contiguous."""
    return np.ascontiguousarray(np.asarray(array)).reshape(-1).view(np.uint8)


def check_state(state: dict[str, Any], expected: dict[str, np.ndarray]) -> None:
    """Raise `StateError` unless the arrays of a state have the expected shapes and fields."""
    for name, array in expected.items():
        value = state.get(name) if isinstance(state, dict) else None
        kind = array.dtype.fields or array.dtype  # a record array and a plain array have the same fields
        if isinstance(value, np.ndarray):
            if value.shape == array.shape and (value.dtype.fields or value.dtype) == kind:
                continue
            what = f"shape {list(value.shape)}" if value.shape != array.shape else "other fields"
        else:
            what = "none" if value is None else f"a {type(value).__name__}"
        raise StateError(
            f"this state does not fit these matches: {name!r} must have shape {list(array.shape)}, got {what}; "
            "program, number of matches, control and representation must be those of the environment that gave it"
        )


def make_vec(program: str, num_envs: int = 1, **settings: Any) -> FootballVectorEnv:
    """Make the native batch for `gymnasium.make_vec`: a new random level in every episode.

    `settings` are the fields of `FootballConfig`.
    """
    env = FootballVectorEnv(program, num_envs, config=FootballConfig(**settings))
    env.level_sampler = env.sample_levels
    return env
