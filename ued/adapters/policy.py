"""A trained student to be used elsewhere: `policy = load_policy("runs/x")`, `action = policy.act(observation)`.

Read next: `learning.student`, what plays.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete, MultiBinary, MultiDiscrete, Space, flatten

from ued.config import PPOConfig
from ued.core import checkpoint
from ued.core.checkpoint import CheckpointError
from ued.core.seeding import torch_generator
from ued.core.upomdp import UPOMDP
from ued.learning.student import Player, Student

KINDS = {"Box": Box, "Discrete": Discrete, "MultiDiscrete": MultiDiscrete, "MultiBinary": MultiBinary}


class LoadedPolicy:
    """A student that plays: `act` for one observation or for a batch.

    One with a memory (`--memory gru`) goes on from what it remembers: tell it by `begin` of each episode that begins.

    Args:
        student: what plays.
        shape: of one observation as the student reads it: `(size,)` or that of an image; of a team `(A, ...)`.
        observation_space: of one environment, whose observations are flattened to `(size,)` where they are no arrays;
            None: they are what the student reads.
        seed: of the actions drawn.
    """

    def __init__(self, student: Student, shape: tuple[int, ...], observation_space: Space | None, seed: int) -> None:
        self.student, self.shape, self.observation_space = student, shape, observation_space
        self.player = Player(student, torch_generator(seed))

    def act(self, observation: Any, greedy: bool = False) -> Any:
        """Return an action for an observation, or actions `[N, ...]` for observations `[N, *shape]`.

        Of a team it is an action for each agent, `[A, ...]`. It is drawn from the policy, or its most likely one if
        `greedy`. Raises `ValueError` for another shape.
        """
        if self.observation_space is not None and not isinstance(observation, np.ndarray):
            observation = flatten(self.observation_space, observation)
        seen = np.asarray(observation)
        single = seen.shape == self.shape
        if not single and seen.shape[1:] != self.shape:
            raise ValueError(f"an observation must have shape {self.shape}, or [N, *{self.shape}], got {seen.shape}")
        self.player.greedy = greedy
        actions = self.player(seen[None] if single else seen)
        return actions[0] if single else actions

    def begin(self, where: np.ndarray | None = None) -> None:
        """Forget what was: an episode begins; of a batch in the environments `where`, bool `[N]`."""
        self.player.begin(where)


def load_policy(path: str | Path, observation_space: Space | None = None, seed: int = 0) -> LoadedPolicy:
    """Return the first student of a run folder or a checkpoint, ready to play in one environment or in many.

    Give the `observation_space` of your environment if it is a `Dict` or the like: training flattened it. Raises
    `CheckpointError` where there is no student, or one of before spaces were kept.
    """
    path = Path(path)
    file = path / "checkpoint.pt" if path.is_dir() else path
    state = checkpoint.load(file)
    try:
        spaces, saved = state["spaces"], state["method"]["learners"][0]["ppo"]["student"]
        ppo = state["config"]["ppo"]
    except (KeyError, IndexError, TypeError) as error:
        raise CheckpointError(f"{file} holds no student with its spaces; train it on for an update") from error
    try:
        seen, done = (space_from(spaces[name]) for name in ("observation", "action"))
        config = PPOConfig(**{item.name: ppo[item.name] for item in fields(PPOConfig) if item.name in ppo})
        agents = int(spaces["agents"])
        student = Student(seen, done, config, torch_generator(0), None, agents)
        student.load_state_dict(saved)
    except Exception as error:  # whatever values that no training wrote make of it
        raise CheckpointError(f"{file} is damaged: its student or its spaces are none") from error
    student.requires_grad_(False)
    shape = seen.shape or ()
    return LoadedPolicy(student, shape if agents == 1 else (agents, *shape), observation_space, seed)


def spaces_of(upomdp: UPOMDP) -> dict[str, Any]:
    """Return what a checkpoint keeps of what an agent sees and does."""
    seen, done = upomdp.agent_observation_space, upomdp.agent_action_space
    return {"observation": space_data(seen), "action": space_data(done), "agents": upomdp.num_agents}


def space_data(space: Space) -> dict[str, Any]:
    """Return a space as plain data. Raises `ValueError` for one that no student knows."""
    if isinstance(space, Box):
        return {"kind": "Box", "low": space.low, "high": space.high, "dtype": str(space.dtype)}
    if isinstance(space, Discrete):
        return {"kind": "Discrete", "n": int(space.n), "start": int(space.start)}
    if isinstance(space, MultiDiscrete):
        return {"kind": "MultiDiscrete", "nvec": space.nvec, "start": space.start}
    if isinstance(space, MultiBinary):
        return {"kind": "MultiBinary", "n": list(space.shape)}
    raise ValueError(f"students know nothing of the space {space}")


def space_from(data: dict[str, Any]) -> Space:
    """Return the space that `space_data` gave `data` for."""
    about = dict(data)
    kind = KINDS[about.pop("kind")]
    if kind is Box:
        about["dtype"] = np.dtype(about["dtype"]).type
    return kind(**about)
