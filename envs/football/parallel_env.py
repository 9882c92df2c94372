"""One football match as a PettingZoo `ParallelEnv`: agents by name, of both teams if both have agents.

It is for trainers of other libraries and for self-play, one match at a time. Vectorized trainers use
`FootballVectorEnv`, whose N matches give arrays `[N, A, ...]` with agents in the same order. Only this module needs
PettingZoo.
Read next: `gym_env`, which does the work.
"""

from __future__ import annotations

import operator
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete, Space, Tuple
from gymnasium.utils import EzPickle
from pettingzoo import ParallelEnv

from regista.envs.football.constants import LEFT, NUM_ACTIONS
from regista.envs.football.gym_env import ENDINGS, FootballEnv
from scenic_lite import Program
from ued.core.upomdp import of_one_agent

TEAMS = ("left", "right")
REASONS = {words: number for number, words in ENDINGS.items()}


class FootballParallelEnv(ParallelEnv, EzPickle):
    """One match of several agents. Each `reset` samples a new level, or uses θ `[D]` in [-1, 1] from
    `options={"theta": θ}`.

    Args:
        program: a compiled program, the path of one, or its text.
        control: the players of the left team that agents move: "all", "allNonGK", "closest1" to "closest3", "active", a
            number, or "none".
        right_control: the same for the right team, for self-play. Its agents see the pitch rotated, so that they also
            attack +x, and their rewards have the opposite sign.
        settings: the other arguments of `FootballEnv`: representation, rewards, render_mode, dialect, engine ...

    Agents are "agent_0", "agent_1", ... in the order of the vector environment's agent axis, left ones first. An
    observation belongs to the player that the agent's next action moves. All agents' episodes end in the same step.
    `infos` are the same for all agents: `theta` `[D]`, the θ of the level; `replaced`, whether a random valid level has
    replaced an invalid one; `ended`, the reason why the episode ended in this step, `constants.RUNNING` to `REJECTED`;
    and for a program with `record` statements `records`, as in `FootballEnv`.

    Attributes:
        teams: "left" or "right" for each agent.
        state_space: the space of `state`; None if observations are "raw".
    """

    metadata = {**FootballEnv.metadata, "name": "regista_football_v0", "is_parallelizable": True}  # noqa: RUF012

    def __init__(
        self, program: Program | str | Path, control: str = "all", right_control: str = "none", **settings: Any
    ) -> None:
        EzPickle.__init__(self, program, control, right_control, **settings)
        self.match = FootballEnv(program, control=control, right_control=right_control, **settings)
        self.render_mode, self.theta_space = self.match.render_mode, self.match.theta_space
        batch = self.match.batch
        count, left = batch.num_agents, batch.lineup.num_agents[LEFT]
        self.possible_agents = [f"agent_{number}" for number in range(count)]
        self.agents: list[str] = []  # empty until `reset`
        self.teams = {agent: TEAMS[number >= left] for number, agent in enumerate(self.possible_agents)}
        seen = self.match.observation_space
        spaces = [*seen.spaces] if isinstance(seen, Tuple) else [of_one_agent(seen, count) for _ in range(count)]
        self.observation_spaces: dict[str, Space] = dict(zip(self.possible_agents, spaces, strict=True))
        self.action_spaces: dict[str, Space] = {agent: Discrete(NUM_ACTIONS) for agent in self.possible_agents}
        self.state_space = joined_space(spaces[0], count)
        self._seen: list[Any] = []
        self._replaced = False

    def observation_space(self, agent: str) -> Space:
        """Return the observation space of an agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space:
        """Return the action space of an agent: Google Research Football's 19 actions."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict, dict]:
        """Start a match. Other options than `theta` are ignored, as PettingZoo's API test requires.

        Raises:
            ued.core.upomdp.ThetaError: an invalid θ.
        """
        given = {"theta": options["theta"]} if options and "theta" in options else None
        observation, info = self.match.reset(seed=seed, options=given)
        self._replaced = info["replaced"]
        self.agents = list(self.possible_agents)
        return self._apart(observation), self._infos({"ended": ""})

    def step(self, actions: dict[str, int]) -> tuple[dict, dict, dict, dict, dict]:
        """Step the match by 0.1 s, with an action for each agent.

        Raises:
            RuntimeError: before `reset` or after the end.
            ValueError: unless there is one action for each agent.
        """
        if not self.agents:
            raise RuntimeError("no match is running; call reset() before step()")
        if actions.keys() != set(self.agents):
            raise ValueError(f"step() needs an action for each of {', '.join(self.agents)}, got {', '.join(actions)}")
        chosen = [operator.index(actions[agent]) for agent in self.agents]  # rejects floats instead of truncating them
        observation, reward, terminated, truncated, info = self.match.step(chosen if len(chosen) > 1 else chosen[0])
        agents, rewards = self.agents, info.pop("agent_rewards", [reward])
        if terminated or truncated:
            self.agents = []
        return (
            self._apart(observation),
            {agent: float(reward) for agent, reward in zip(agents, rewards, strict=True)},
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            self._infos(info),
        )

    def state(self) -> np.ndarray:
        """Return all agents' observations in one array, for centralized critics: vectors concatenated, images stacked.

        Raises:
            NotImplementedError: for "raw" observations.
        """
        if self.state_space is None:
            raise NotImplementedError("representation 'raw' has no state() array; each dict has the full state")
        return np.concatenate(self._seen, axis=-1)

    def render(self) -> np.ndarray | None:
        """Return the match as a picture, uint8 `[height, width, 3]`; None without a render mode."""
        return self.match.render()

    def close(self) -> None:
        """Free the engine's resources."""
        self.match.close()

    def _infos(self, info: dict[str, Any]) -> dict[str, dict[str, Any]]:
        """Return the same info for each agent."""
        theta = self.match.batch.levels["theta"][0]
        shared = {**info, "theta": theta.copy(), "replaced": self._replaced, "ended": REASONS[info["ended"]]}
        return {agent: dict(shared) for agent in self.possible_agents}

    def _apart(self, observation: Any) -> dict[str, Any]:
        self._seen = [observation] if len(self.possible_agents) == 1 else list(observation)
        return dict(zip(self.possible_agents, self._seen, strict=True))


def joined_space(space: Space, count: int) -> Box | None:
    """Return the space of the concatenated observations of `count` agents; None if observations are not arrays."""
    if not isinstance(space, Box):
        return None
    return Box(
        np.concatenate([space.low] * count, -1), np.concatenate([space.high] * count, -1), dtype=space.dtype.type
    )
