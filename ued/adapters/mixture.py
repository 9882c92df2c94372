"""Several programs in one UPOMDP: a batch holds levels of different games, and the game is a part of the level.

So a curriculum chooses among skills in the same way as among levels (thesis, section 5.1). The first column of θ is a
uniform choice of the program; the others are the columns of that program. Every method works on a mixture without
changes. Read next: `core.upomdp`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space, flatdim

from ued.core import parameters
from ued.core.cells import index_in
from ued.core.level_space import check_theta, level_dtype
from ued.core.parameters import Choice, Column, Range, quantize
from ued.core.parts import Parts, repeated
from ued.core.upomdp import UPOMDP


class Mixture(UPOMDP):
    """N environments of K programs; the level of an environment selects its program.

    Args:
        members: K UPOMDPs of N environments each, with equal numbers of agents, equal action spaces and flat
            observations. The mixture then owns them; their environments are `idle` on levels of other programs.
        names: names of the programs.

    θ has 1 + max D columns: "program", and "1", "2", ... which are the columns of the program in their order (see
    `describe`); a program of fewer columns ignores the rest. Observations are those of the program, padded with zeros
    to the longest, followed by a one-hot of the program, for each agent. If all programs have equal parts
    (`core.parts`), the mixture has these parts too, so that convolutions read their images. If `only` is the index of a
    program, every level plays that program, which tests it with the observations of the mixture.

    Raises:
        ValueError: members that are incompatible.
    """

    def __init__(self, members: Sequence[UPOMDP], names: Sequence[str], only: int | None = None) -> None:
        _check(members, names)
        self.members, self.program_names, self.only = tuple(members), tuple(names), only
        self.program_parameters = tuple(tuple(member.parameters) for member in members)
        first = members[0]
        self.num_agents = first.num_agents
        self.sizes = [flatdim(member.agent_observation_space) for member in members]
        self.width = max(self.sizes)
        widest = max(map(len, self.program_parameters))
        draws = [Column("program", Choice(*names))]
        draws += [Column(str(k + 1), Range(-1.0, 1.0)) for k in range(widest)]
        seen = (self.width + len(members),)
        flat = Box(-np.inf, np.inf, seen if self.num_agents == 1 else (self.num_agents, *seen), np.float32)
        space = _with_parts([member.single_observation_space for member in members]) or flat
        super().__init__(first.num_envs, space, first.single_action_space, draws)
        self._observations = np.zeros((self.num_envs, *space.shape), space.dtype)
        self.seed_is_luck = all(member.seed_is_luck for member in members)

    @property
    def max_episode_steps(self) -> int | None:  # type: ignore[override]
        """The largest limit of the programs; None unless all programs have a limit."""
        limits = [member.max_episode_steps for member in self.members]
        return None if None in limits else max(limit for limit in limits if limit is not None)

    @property
    def observation_scale(self) -> np.ndarray:
        """The smallest scale of each entry over all programs; 0 if a program does not define it."""
        units = np.ones((len(self.members), self.width + len(self.members)))  # [K, F]
        for k, member in enumerate(self.members):
            unit = member.observation_scale
            units[k, : self.sizes[k]] = 0.0 if unit is None else unit
        return units.min(axis=0)

    def program_of(self, theta: Any) -> np.ndarray:
        """Return the index `[n]` of the program that each row of θ `[n, 1 + max D]` chooses."""
        theta = check_theta(theta, self.theta_dim)
        if self.only is not None:
            return np.full(len(theta), self.only, np.int32)
        return index_in(theta[:, 0], len(self.members)).astype(np.int32)

    def valid(self, theta: Any) -> np.ndarray:
        theta = check_theta(theta, self.theta_dim)
        program, valid = self.program_of(theta), np.zeros(len(theta), bool)
        for k, member in enumerate(self.members):
            mine = program == k
            if mine.any():
                valid[mine] = member.valid(theta[mine, 1 : 1 + member.theta_dim])
        return valid

    def describe(self, theta: Any) -> list[dict[str, Any]]:
        theta = check_theta(theta, self.theta_dim)
        return [
            {"program": self.program_names[k]} | self.members[k].describe(row[1 : 1 + self.members[k].theta_dim])[0]
            for row, k in zip(theta, self.program_of(theta), strict=True)
        ]

    def make_levels(self, theta: Any) -> np.ndarray:
        levels = super().make_levels(theta)
        levels["program"] = self.program_of(levels["theta"])
        for k, member in enumerate(self.members):  # columns after the first belong to the member
            mine, own = levels["program"] == k, slice(1, 1 + member.theta_dim)
            levels["theta"][mine, own] = quantize(levels["theta"][mine, own], member.parameters)
            levels["theta"][mine, own.stop :] = 0.0  # ignored: equal levels have equal θ
            if member.seeds is not None:
                levels["seed"][mine] = member.seeds.of(levels["theta"][mine, own])
        return levels

    def edit_theta(self, theta: np.ndarray, num_edits: int, edit_size: float, rng: np.random.Generator) -> np.ndarray:
        edited, program = theta.copy(), self.program_of(theta)
        for k, own in enumerate(self.program_parameters):
            mine, columns = np.flatnonzero(program == k), (self.parameters[0], *own)
            used = slice(len(columns))
            edited[mine, used] = parameters.edit(theta[mine, used], columns, num_edits, edit_size, rng)
            unset = edited[:, len(columns) :]  # columns of another program, which an edit may choose
            unset[mine] = rng.uniform(-1.0, 1.0, (len(mine), unset.shape[1]))
        return edited

    def keep_seeds(self, levels: np.ndarray, seeds: np.ndarray) -> None:
        for k, member in enumerate(self.members):
            if member.seeds is None:
                mine = levels["program"] == k
                levels["seed"][mine] = seeds[mine]

    # ------------------------------------------------------------ the environments

    def _start(self, levels: np.ndarray, where: np.ndarray) -> np.ndarray:
        program = self.program_of(levels["theta"])
        levels["program"] = self.levels["program"][where] = program
        for k, member in enumerate(self.members):
            member.idle[where] = program != k
            mine = where[program == k]
            if len(mine):
                self._start_member(k, levels[program == k], mine)
        return self._observations.copy()

    def _start_member(self, k: int, levels: np.ndarray, where: np.ndarray) -> None:
        mask = np.zeros(self.num_envs, bool)
        mask[where] = True
        numbers = self.visits[where], self.episodes[where]
        observations, _ = self.members[k].reset_to_levels(self._of_member(k, levels), mask, *numbers)
        self._see(k, observations, where, self._observations)

    def _of_member(self, k: int, levels: np.ndarray) -> np.ndarray:
        """Return levels `[n]` of program k as levels of that program's UPOMDP."""
        dim = self.members[k].theta_dim
        own = np.zeros(len(levels), level_dtype(dim))
        own["seed"], own["theta"] = levels["seed"], levels["theta"][:, 1 : 1 + dim]
        return own

    def prefetch(self, levels: np.ndarray) -> None:
        program = self.program_of(levels["theta"])
        for k, member in enumerate(self.members):
            member.prefetch(self._of_member(k, levels[program == k]))

    def _see(self, k: int, observations: np.ndarray, where: np.ndarray, into: np.ndarray) -> None:
        """Write the observations of program k in the environments `where` to their rows."""
        into[where] = 0.0
        into[where, ..., : self.sizes[k]] = observations[where]
        into[where, ..., self.width + k] = 1.0

    def _advance(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        rewards = np.zeros(self.num_envs)
        terminated, truncated = np.zeros(self.num_envs, bool), np.zeros(self.num_envs, bool)
        success = np.full(self.num_envs, np.nan)
        for k, member in enumerate(self.members):
            where = np.flatnonzero(~member.idle)
            if not len(where):
                continue
            observations, reward, over, cut, info = member.advance(actions)
            rewards[where], terminated[where], truncated[where] = reward[where], over[where], cut[where]
            self._see(k, observations, where, self._observations)
            success[where] = np.asarray(info.get("success", success), float)[where]
        return self._observations.copy(), rewards, terminated, truncated, {"success": success}

    # ------------------------------------------------------------ state

    @property
    def supports_state(self) -> bool:
        return all(member.supports_state for member in self.members)

    def get_state(self) -> dict[str, Any]:
        return {
            "members": [member.get_state() for member in self.members],
            "idle": [member.idle.copy() for member in self.members],
            "observations": self._observations.copy(),
            **self.level_state(),
        }

    def set_state(self, state: dict[str, Any]) -> np.ndarray:
        self.set_level_state(state, "members", "idle", "observations")
        for member, saved, idle in zip(self.members, state["members"], state["idle"], strict=True):
            member.set_state(saved)
            member.idle[:] = idle
        self._observations[:] = state["observations"]
        return self._observations.copy()

    def resized(self, num_envs: int) -> Mixture:
        """Return a mixture of the same programs with `num_envs` environments, not yet reset, by members' `resized`."""
        members: list[Any] = list(self.members)
        return Mixture([member.resized(num_envs) for member in members], self.program_names, self.only)

    def copy(self) -> Mixture:
        twin = Mixture([member.copy() for member in self.members], self.program_names, self.only)
        twin.set_state(self.get_state())
        return twin

    def close_extras(self, **kwargs: Any) -> None:
        for member in self.members:
            member.close()


def _with_parts(spaces: Sequence[Space]) -> Parts | None:
    """Return the space of observations followed by a one-hot of the program; None unless all have the same parts."""
    parts = [space for space in spaces if isinstance(space, Parts)]
    if len(parts) < len(spaces) or any(part.parts != parts[0].parts for part in parts):
        return None
    return repeated(parts[0], 1, len(spaces))


def _check(members: Sequence[UPOMDP], names: Sequence[str]) -> None:
    if not members or len(members) != len(names) or len(set(names)) < len(names):
        raise ValueError(f"a mixture needs one name for each member, all different; got {len(members)} and {names}")
    first = members[0]
    for member, name in zip(members, names, strict=True):
        if member.num_envs != first.num_envs:
            raise ValueError(f"{name} has {member.num_envs} environments, {names[0]} {first.num_envs}")
        if member.num_agents != first.num_agents:
            raise ValueError(f"{name} has {member.num_agents} agents, {names[0]} {first.num_agents}")
        if member.single_action_space != first.single_action_space:
            raise ValueError(f"{name} has actions {member.single_action_space}, {names[0]} {first.single_action_space}")
        if member.individual_rewards:
            raise ValueError(f"{name} has opponents; a mixture needs agents with one reward")
        if member.level_family is not None:
            raise ValueError(f"{name} has levels of {type(member.level_family).__name__}; a mixture needs vectors θ")
        if len(member.agent_observation_space.shape or ()) != 1:
            raise ValueError(f"{name} has observations {member.agent_observation_space}; a mixture needs flat ones")
