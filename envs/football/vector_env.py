"""Football as a UPOMDP: N matches that a Scenic program describes, each on its own level, stepped as one batch.

Read next: `casting`, how a program becomes a match; `batch`, how matches are stepped.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space
from gymnasium.vector.utils import batch_space

from envs.football.batch import Rules, empty_batch, empty_outcome, observe_batch, restart, step_batch
from envs.football.casting import Casting
from envs.football.config import FootballConfig
from envs.football.constants import LEFT, NO_FAULT, NUM_ACTIONS
from envs.football.domain import FOOTBALL
from envs.football.observation import LIMIT, features_size
from envs.football.raw import raw_observation, raw_space
from envs.football.staging import Staging
from scenic_lite import Program, load
from ued.upomdp import UPOMDP, check_theta


class FootballVectorEnv(UPOMDP):
    """N football matches in which A agents move players: one the left player closest to the ball, unless said.

    The program's behaviors move theirs, except whom an agent moves in that step; the built-in AI moves the rest. One
    agent has actions `[N]` and observations without an axis for agents, several have actions `[N, A]`.

    Args:
        program: a compiled program, the path of one, or its text.
        num_envs: N.
        config: observation, reward, and whom the agents move (see `control_modes`).

    Actions are Google Research Football's 19. Observations are `features` `[N, (A,) F]` float32 (see `observation`), or
    the `raw` dict of Google Research Football. A match that ends by a goal, a lost ball or out of play is terminated;
    one that reaches `game_duration` is truncated. A `terminate` of the program terminates a match; one that breaks a
    requirement of the program is truncated. `info["ended"]` `[N]` gives the reason, `constants.RUNNING` to `REJECTED`.
    What monitors set `scenic_reward` to is part of the reward. `info["agent_rewards"]` `[N, A]` is each agent's own
    reward; `rewards` `[N]` are their mean over the left team's agents (see `reward`).

    Raises `scenic_lite.ScenicError` for a broken program, `casting.CastingError` for one that is no match; `step`
    raises ScenicError where the program fails at run time: that match is put back to its start, and the others have
    played their step. A UserWarning names each line that would fail so whenever a match came to it.
    """

    def __init__(
        self,
        program: Program | str | Path,
        num_envs: int = 1,
        *,
        config: FootballConfig = FootballConfig(),  # noqa: B008 (frozen)
    ) -> None:
        self.program = program if isinstance(program, Program) else load(program, FOOTBALL, config.dialect)
        self.config = config
        self.casting = Casting(self.program, str(config.control), str(config.right_control))
        self.staging = Staging(self.program)
        for warning in self.staging.compiled.warnings:
            warnings.warn(warning, stacklevel=2)
        self.num_players = self.casting.num_players
        size = features_size(self.num_players)
        space: Space = Box(-LIMIT, LIMIT, (size,), np.float32)
        self._num_left = int((np.asarray(self.casting.lineup.teams) == LEFT).sum())
        self._is_raw = config.observation == "raw"
        if self._is_raw:
            space = raw_space(self._num_left, self.num_players - self._num_left)
        self.num_agents = sum(self.casting.num_agents)
        actions: Space = Discrete(NUM_ACTIONS)
        if self.num_agents > 1:
            space, actions = batch_space(space, self.num_agents), MultiDiscrete([NUM_ACTIONS] * self.num_agents)
        super().__init__(num_envs, space, actions, self.program.draws)
        self._rules = Rules(
            config.rewards == "scoring,checkpoints",
            bool(self.casting.config.deterministic),
            not self._is_raw,
            self.staging.live,
            self.casting.cast,
        )
        self._outcome = empty_outcome(num_envs, self.num_agents, size)
        self._batch = empty_batch(num_envs, self.staging.num_registers, len(self.program.objects))
        self._started = False

    @property
    def matches(self) -> np.ndarray:
        """The matches as they are, MATCH `[N]`; a copy, for looking at."""
        return self._batch.matches.copy()

    def valid(self, theta: Any) -> np.ndarray:
        return self.program.valid(check_theta(theta, self.theta_dim))

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        return [self.program.describe(row) for row in check_theta(theta, self.theta_dim)]

    def sample_theta(self, count: int) -> np.ndarray:
        """Draw valid θ `[count, D]` uniformly. Raises ScenicError with the rejection report if there are none."""
        return self.program.sample(count, self.np_random)[0]

    def _start(self, levels: np.ndarray, where: np.ndarray) -> Any:
        batch = self._batch
        batch.starts[where] = self.casting.starts(levels["theta"], levels["seed"])
        batch.matches[where] = batch.starts[where]
        batch.start_registers[where] = self.staging.registers(levels["theta"])
        batch.registers[where] = batch.start_registers[where]
        observe_batch(batch.matches, where, self._outcome.observations)
        self._started = True
        return self._observations()

    def _step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        if not self._started:
            raise RuntimeError("call reset() before step()")
        out = self._outcome
        step_batch(self._batch, self._checked(actions), out, self._rules, self.staging.code)
        if out.faults.any():
            self._report_faults()
        ended = out.terminated | out.truncated
        final = self._squeezed(out.final_observations.copy())
        if self._is_raw:
            final = self._observations()
            self._restart(ended)
        info = {"final_obs": final, "_final_obs": ended, "ended": out.ended.copy()}
        info["agent_rewards"] = out.agent_rewards.copy()
        return self._observations(), out.rewards.copy(), out.terminated.copy(), out.truncated.copy(), info

    def _observations(self) -> Any:
        """The present observations, a copy: `[N, (A,) F]`, or a dict of arrays for `raw`."""
        if self._is_raw:
            return raw_observation(self._batch.matches[:], self._num_left, self.num_players)
        return self._squeezed(self._outcome.observations.copy())

    def _squeezed(self, rows: np.ndarray) -> np.ndarray:
        """Rows `[N, A, ...]` without the axis of the agents if there is one only."""
        return rows[:, 0] if self.num_agents == 1 else rows

    def _restart(self, ended: np.ndarray) -> None:
        """Do for `raw` what the kernel does otherwise: it must not restart before the last observation is taken."""
        for index in np.flatnonzero(ended):
            restart(self._batch, self._rules, index)

    def _checked(self, actions: Any) -> np.ndarray:
        """Actions as int64 `[N, A]`. Raises ValueError for another shape, another type, or no action."""
        array, wanted = np.asarray(actions), self.action_space.shape
        if array.shape != wanted or array.dtype.kind not in "iu":
            size = " x ".join(map(str, wanted))
            raise ValueError(f"actions must be {size} whole numbers, got shape {array.shape} of {array.dtype}")
        if array.min() < 0 or array.max() >= NUM_ACTIONS:
            wrong = array[(array < 0) | (array >= NUM_ACTIONS)][0]
            raise ValueError(f"action {wrong} does not exist; actions are 0 to {NUM_ACTIONS - 1}")
        return array.astype(np.int64, copy=False).reshape(self.num_envs, self.num_agents)

    def _report_faults(self) -> None:
        """Put the matches that cannot go on back to their start, and raise the error of the first of them."""
        faulted = self._outcome.faults != NO_FAULT
        error = self.staging.error(self._batch, int(np.flatnonzero(faulted)[0]), self.levels)
        self._restart(faulted)
        observe_batch(self._batch.matches, np.flatnonzero(faulted), self._outcome.observations)
        raise error

    def get_state(self) -> dict[str, Any]:
        return {
            "matches": np.asarray(self._batch.matches).copy(),
            "starts": np.asarray(self._batch.starts).copy(),
            "registers": self._batch.registers.copy(),
            "start_registers": self._batch.start_registers.copy(),
            "levels": self.levels.copy(),
            "np_random": self.np_random.bit_generator.state,
        }

    def set_state(self, state: dict[str, Any]) -> Any:
        self._batch.matches[:], self._batch.starts[:] = state["matches"], state["starts"]
        self._batch.registers[:], self._batch.start_registers[:] = state["registers"], state["start_registers"]
        self.levels[:] = state["levels"]
        self.np_random.bit_generator.state = state["np_random"]
        observe_batch(self._batch.matches, np.arange(self.num_envs), self._outcome.observations)
        self._started = True
        return self._observations()

    def copy(self) -> FootballVectorEnv:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # they have been given
            twin = FootballVectorEnv(self.program, self.num_envs, config=self.config)
        twin.set_state(self.get_state())
        return twin


def make_vec(
    program: str,
    num_envs: int = 1,
    observation: str = "features",
    rewards: str = "scoring",
    control: str = "closest1",
    right_control: str = "none",
    dialect: int | None = None,
) -> FootballVectorEnv:
    """Make the native batch for `gymnasium.make_vec`: a new random level every episode, as a stock trainer expects."""
    env = FootballVectorEnv(
        program, num_envs, config=FootballConfig(observation, rewards, control, right_control, dialect)
    )
    env.next_levels = env.sample_levels
    return env
