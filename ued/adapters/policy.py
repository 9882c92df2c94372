"""A trained student for deployment: `policy = load_policy("runs/x")`, `action = policy.act(observation)`.

Read next: `learning.student`, the student.
"""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Space, Tuple, flatten

from ued.config import PPOConfig
from ued.core import checkpoint, own_code
from ued.core.checkpoint import CheckpointError
from ued.core.own_code import OwnCodeError
from ued.core.parts import Parts
from ued.core.seeding import torch_generator
from ued.core.sparse_image import dense_space
from ued.core.upomdp import UPOMDP
from ued.learning.student import Player, Student

KINDS: dict[str, Any] = {"Box": Box, "Discrete": Discrete, "MultiDiscrete": MultiDiscrete, "MultiBinary": MultiBinary}
KINDS |= {"Parts": Parts, "Dict": Dict, "Tuple": Tuple}


class LoadedPolicy:
    """A policy: `act` for one observation or for a batch.

    A student with memory (`--memory gru`) keeps its state between calls: call `begin` at the start of each episode.

    Args:
        student: the trained student.
        shape: shape of one observation of the student: `(size,)` or the shape of an image; for a team `(A, ...)`.
        observation_space: space of one environment; observations that are not arrays are flattened to `(size,)`;
            None: observations have the student's shape.
        seed: seed for sampling actions.
    """

    def __init__(self, student: Student, shape: tuple[int, ...], observation_space: Space | None, seed: int) -> None:
        self.student, self.shape, self.observation_space = student, shape, observation_space
        self.player = Player(student, torch_generator(seed))

    def act(self, observation: Any, greedy: bool = False) -> Any:
        """Return an action for an observation, or actions `[N, ...]` for observations `[N, *shape]`.

        For a team, return an action for each agent, `[A, ...]`. Actions are sampled from the policy, or the most likely
        ones if `greedy`.

        Raises:
            ValueError: an observation of another shape.
        """
        seen = np.asarray(self._flat(observation))
        single = seen.shape == self.shape
        if not single and seen.shape[1:] != self.shape:
            raise ValueError(f"an observation must have shape {self.shape}, or [N, *{self.shape}], got {seen.shape}")
        self.player.greedy = greedy
        actions = self.player(seen[None] if single else seen)
        return actions[0] if single else actions

    def _flat(self, observation: Any) -> Any:
        """Return an observation, or a batch of them, as arrays of the student's shape."""
        space = self.observation_space
        if space is None:
            return observation
        if isinstance(space, Parts):
            if isinstance(observation, np.ndarray):
                return observation
            return space.flatten_batch(observation) if space.is_batch(observation) else space.flatten(observation)
        if space.shape is None:  # a Dict or Tuple
            return observation if isinstance(observation, np.ndarray) else flatten(space, observation)
        array = np.asarray(observation)
        if space.shape == self.shape or array.ndim not in (len(space.shape), len(space.shape) + 1):
            return observation
        if len(self.shape) == 3:  # gray images have one channel
            return array[..., None]
        if array.ndim == len(space.shape):
            return flatten(space, array)
        return np.stack([np.asarray(flatten(space, row)) for row in array])

    def begin(self, where: np.ndarray | None = None) -> None:
        """Reset the memory at the start of an episode; for a batch, in the environments `where`, bool `[N]`."""
        self.player.begin(where)


def load_policy(
    path: str | Path, observation_space: Space | None = None, seed: int = 0, trusted: bool = False
) -> LoadedPolicy:
    """Return the first student of a run folder or a checkpoint as a policy for one or many environments.

    Pass the `observation_space` of your environment if it is a `Dict` or similar without images, since training
    flattened it. Checkpoints contain spaces with images.

    Raises:
        CheckpointError: a checkpoint without a student or without saved spaces.
        OwnCodeError: a user-defined network (`PPOConfig.network`), which is code that the checkpoint names, unless
            `trusted`.
    """
    path = Path(path)
    file = path / "checkpoint.pt" if path.is_dir() else path
    state = checkpoint.load(file)
    try:
        spaces, saved = state["spaces"], state["method"]["learners"][0]["ppo"]["student"]
        ppo = state["config"]["ppo"] | _moved_network(path)
    except (KeyError, IndexError, TypeError) as error:
        raise CheckpointError(f"{file} holds no student with its spaces; resume its training for one update") from error
    _check_network(str(ppo.get("network")), trusted)
    try:
        seen, done = (space_from(spaces[name]) for name in ("observation", "action"))
        config = PPOConfig(**{item.name: ppo[item.name] for item in fields(PPOConfig) if item.name in ppo})
        agents = int(spaces["agents"])
        student = Student(seen, done, config, torch_generator(0), None, agents)
        student.load_state_dict(saved)
    except OwnCodeError as error:
        raise CheckpointError(f"{file}: {error}") from error
    except Exception as error:  # any error that damaged values can cause
        own = f", or {ppo['network']} has changed since training" if own_code.is_name(str(ppo.get("network"))) else ""
        raise CheckpointError(f"{file} is damaged: its student or its spaces are invalid{own}") from error
    student.requires_grad_(False)
    shape = seen.shape or ()
    observation_space = seen if isinstance(seen, Parts) else observation_space
    return LoadedPolicy(student, shape if agents == 1 else (agents, *shape), observation_space, seed)


def _moved_network(path: Path) -> dict[str, str]:
    """Return the network that the settings of a run folder name, which users change if its file was moved."""
    try:
        return {"network": str(json.loads((path / "config.json").read_text())["ppo"]["network"])}
    except (OSError, ValueError, KeyError, TypeError):
        return {}  # a checkpoint, or settings of another program


def _check_network(name: str, trusted: bool) -> None:
    """Raise an error for a user-defined network that a checkpoint names, unless it is trusted."""
    if own_code.is_name(name) and trusted:
        own_code.permit(name)
    elif own_code.is_name(name):
        own_code.note_read(name)
        own_code.check(name)


def spaces_of(upomdp: UPOMDP) -> dict[str, Any]:
    """Return the observation and action spaces in the form of checkpoints: a policy sees images, not coordinates."""
    seen, done = dense_space(upomdp.agent_observation_space), upomdp.agent_action_space
    return {"observation": space_data(seen), "action": space_data(done), "agents": upomdp.num_agents}


def space_data(space: Space) -> dict[str, Any]:
    """Return a space as plain data. Raises `ValueError` for a space that students do not support."""
    if isinstance(space, Parts):
        return {"kind": "Parts", "space": space_data(space.space), "network": space.network}
    if isinstance(space, Dict):
        return {"kind": "Dict", "spaces": [[key, space_data(part)] for key, part in space.items()]}
    if isinstance(space, Tuple):
        return {"kind": "Tuple", "spaces": [space_data(part) for part in space]}
    if isinstance(space, Box):
        return {"kind": "Box", "low": space.low, "high": space.high, "dtype": str(space.dtype)}
    if isinstance(space, Discrete):
        return {"kind": "Discrete", "n": int(space.n), "start": int(space.start)}
    if isinstance(space, MultiDiscrete):
        return {"kind": "MultiDiscrete", "nvec": space.nvec, "start": space.start}
    if isinstance(space, MultiBinary):
        return {"kind": "MultiBinary", "n": list(space.shape)}
    raise ValueError(f"students do not support the space {space}")


def space_from(data: dict[str, Any]) -> Space:
    """Return the space of data returned by `space_data`."""
    about = dict(data)
    kind = KINDS[about.pop("kind")]
    if kind is Parts:
        return Parts(space_from(about["space"]), about["network"])  # type: ignore[arg-type]
    if kind is Dict:
        return Dict([(key, space_from(part)) for key, part in about["spaces"]])
    if kind is Tuple:
        return Tuple([space_from(part) for part in about["spaces"]])
    if kind is Box:
        about["dtype"] = np.dtype(about["dtype"]).type
    return kind(**about)
