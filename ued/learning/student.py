"""A student: policy, values, normalization of observations, and conversion of actions.

It controls all agents of an environment: one, or a team of A, whose observations, actions and values have an axis of
agents. A team has a policy for each agent, or a shared policy that observes the index of the agent. Its critic observes
one agent, or all agents (MAPPO, Yu et al. 2022).

Its memory within an episode is empty or a GRU. The caller stores the state of the memory, a row of `memory_width`
numbers for each environment, and sets it to 0 where an episode starts; see `learning.memory`.

Observations are normalized by running statistics, which are part of the student and its checkpoint. So a student can
learn from any Gymnasium environment, regardless of the units of observations.
Images, which may be parts of an observation (see `core.parts`), are scaled to [0, 1]; see `learning.pixels`.
Read next: `learning.rollout`.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete, MultiDiscrete, Space
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.core.own_code import is_name
from ued.core.parts import Parts, repeated
from ued.core.sparse_image import SparseImage
from ued.learning.memory import Past, make_memory
from ued.learning.networks import Policy, PolicyHead, Streams, Team, linear, mlp, seen_as, torso
from ued.learning.own_network import own_torso
from ued.learning.pixels import PartScales, Pixels, SparsePixels

CLIP = 10.0  # limit of normalized observations, in standard deviations


class Normaliser(nn.Module):
    """Shift and scale observations by their running mean and standard deviation (Chan et al. 1979, parallel form).

    Standard deviations are at least `floor` `[size]`, in the units of the features. Otherwise a feature that is nearly
    constant in training would become very large when it varies a little more, as in another engine or on another level.
    Each policy has its own statistics.
    """

    mean: Tensor
    variance: Tensor
    count: Tensor
    floor: Tensor

    def __init__(self, floor: Tensor, policies: int = 1) -> None:
        super().__init__()
        shape = (len(floor),) if policies == 1 else (policies, len(floor))
        self.register_buffer("floor", floor.float())
        self.register_buffer("mean", torch.zeros(shape))
        self.register_buffer("variance", torch.ones(shape))
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))

    def forward(self, observation: Tensor) -> Tensor:
        """Return observations in standard deviations from the mean, at most CLIP: `[B, size]` or `[B, A, size]`."""
        # in place, since memory allocation is slow
        return (observation - self.mean).div_(self.deviation()).clamp_(-CLIP, CLIP)

    def deviation(self) -> Tensor:
        """Return the divisors of features, `[size]`, or `[policies, size]`."""
        return torch.maximum((self.variance + 1e-8).sqrt(), self.floor)

    def track(self, observation: Tensor) -> None:
        """Update the statistics with a batch of observations `[B, size]` or `[B, A, size]`."""
        observation = observation.flatten(0, -1 - self.mean.ndim)  # one policy: the rows of all agents
        rows = len(observation)
        observation = observation.float()
        middle = observation.mean(0)
        rest = observation - middle
        error = rest.mean(0)  # rounding error; 64 bits would take three times as long
        variance = (rest.square_().mean(0) - error.square()).double()
        mean = middle.double() + error
        total = self.count + rows
        delta = mean - self.mean.double()
        self.variance.copy_(
            (self.variance.double() * self.count + variance * rows + delta**2 * self.count * rows / total) / total
        )
        self.mean.add_((delta * rows / total).float())
        self.count.copy_(total)


def normaliser_of(
    space: Box, std_floor: float, unit: np.ndarray | None, policies: int
) -> Normaliser | Pixels | PartScales:
    """Return the normalizer of vectors, of images, or of vectors with images in them.

    `unit` `[size]` is the unit of each entry, None if unknown; `std_floor` is the smallest divisor in these units.
    """
    if len(space.shape) == 3:
        return Pixels(space)
    floor = std_floor * torch.as_tensor(np.zeros(space.shape) if unit is None else unit)
    if isinstance(space, Parts):
        return PartScales(space, Normaliser(floor[space.others], policies))
    return Normaliser(floor, policies)


class Student(nn.Module):
    """An actor and a critic on top of one or two torsos.

    Args:
        observation_space, action_space: spaces of one agent: a flat Box, images, `Parts` or a `SparseImage`, and an
            action space that `networks.PolicyHead` supports.
        config: size of the torsos, and whether actor and critic share one, as in the thesis (Fig. 4.10).
        generator: random stream of the initial weights.
        unit: unit of each entry of an observation `[size]`; see `UPOMDP.observation_scale`.
        agents: number of agents; both spaces are those of one agent.

    Attributes:
        policies: number of policies: 1, or one per agent.
        network: name of its first layers; see `PPOConfig.network`.
        memory_width: size of the memory of an environment; 0: the student is feed-forward.
    """

    def __init__(
        self,
        observation_space: Space,
        action_space: Space,
        config: PPOConfig,
        generator: torch.Generator,
        unit: np.ndarray | None = None,
        agents: int = 1,
    ) -> None:
        super().__init__()
        self.network = config.network
        self.agents, self.policies = agents, 1 if config.team == "shared" else agents
        self.numbered, self.central = agents > self.policies, agents > 1 and config.critic == "central"
        self.shared = config.shared_torso and not self.central
        team = players = Team(agents, self.policies)
        given, observation_space = observation_space, seen_as(observation_space, config.network, agents)
        seen = widened(observation_space, 1, agents) if self.numbered else observation_space
        make = own_torso if is_name(config.network) else torso
        self.actor_torso = make(seen, config, generator, team)
        if self.central:
            seen, team = widened(observation_space, agents, 0), Team()
        self.critic_torso = self.actor_torso if self.shared else make(seen, config, generator, team)
        assert isinstance(observation_space, Box)  # `torso` rejects other spaces
        self.normaliser: Normaliser | Pixels | PartScales
        if isinstance(given, SparseImage):
            self.normaliser = SparsePixels(given, isinstance(observation_space, SparseImage), agents)
        else:
            self.normaliser = normaliser_of(observation_space, config.obs_std_floor, unit, self.policies)
        remembers, size = (config.memory, config.hidden_size, generator), config.hidden_size
        inputs = [one.size if config.memory == "none" else size for one in (self.actor_torso, self.critic_torso)]
        heads = config.head_size, int(config.head_size > 0), generator
        self.actor_hidden = mlp(inputs[0], *heads, self.policies)
        self.critic_hidden = mlp(inputs[1], *heads, team.policies)
        self.actor = PolicyHead(action_space, config.head_size or inputs[0], generator, self.policies)
        self.critic = linear(config.head_size or inputs[1], 1, 1.0, generator, team.policies)
        self.action_space = action_space
        self.actor_memory = make_memory(*remembers, players, self.actor_torso.size)
        own = self.critic_torso.size
        self.critic_memory = self.actor_memory if self.shared else make_memory(*remembers, team, own)
        self.memory_width = self.actor_memory.width + (0 if self.shared else self.critic_memory.width)

    def load_state_dict(self, state_dict: Mapping[str, Any], strict: bool = True, assign: bool = False) -> Any:
        """Load weights.

        Raises:
            ValueError: weights that are not finite.
            RuntimeError: weights of another network.
        """
        for name, weights in state_dict.items():
            if not (isinstance(weights, Tensor) and weights.isfinite().all()):
                raise ValueError(f"the student's {name} is not finite")
        return super().load_state_dict(state_dict, strict, assign)

    def forward(self, observation: Tensor, past: Past | None = None) -> tuple[Policy, Tensor]:
        """Return the policy and the value `[B]` for observations `[B, size]`; for a team `[B, A]` for `[B, A, size]`.

        `past` describes their sequences; without it each observation is the first of an episode.
        """
        policy, value, _ = self._infer(self.normaliser(observation), past)
        return policy, value

    def see(self, observation: Tensor) -> Tensor | None:
        """Return normalized observations for `policy_and_value`, floats `[B, size]`.

        None for images and bytes, which would then take several times the memory.
        """
        ahead = isinstance(self.normaliser, Normaliser) and observation.is_floating_point()
        return self.normaliser(observation) if ahead else None

    def policy_and_value(self, seen: Tensor, past: Past | None = None) -> tuple[Policy, Tensor]:
        """Return the policy and the value of `forward`, for normalized observations."""
        policy, value, _ = self._infer(seen, past)
        return policy, value

    def empty_memory(self, num_envs: int) -> Tensor:
        """Return the memory of N environments at the start of episodes: `[N, memory_width]`."""
        return torch.zeros(num_envs, self.memory_width)

    def _infer(self, seen: Tensor, past: Past | None) -> tuple[Policy, Tensor, Tensor]:
        """Return the policy, the value, and the new memory, for normalized observations."""
        past = past or Past(self.empty_memory(len(seen)).to(self.device))
        features, memory = self._actor_features(seen, past)
        policy = self.actor(self.actor_hidden(features))
        if self.shared:
            return policy, self.critic(self.critic_hidden(features)).squeeze(-1), memory
        value, critic_memory = self._value(seen, past)
        return policy, value, torch.cat([memory, critic_memory], -1)

    def _actor_features(self, seen: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        memory = past.memory[:, : self.actor_memory.width]
        return self.actor_memory(self.actor_torso(self._numbered(seen)), memory, past)

    def _critic_features(self, seen: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        memory = past.memory[:, self.memory_width - self.critic_memory.width :]
        # a central critic observes all agents: vectors concatenated, images stacked
        seen = seen.movedim(1, -2).flatten(-2) if self.central else self._numbered(seen)
        return self.critic_memory(self.critic_torso(seen), memory, past)

    def _value(self, seen: Tensor, past: Past) -> tuple[Tensor, Tensor]:
        features, memory = self._critic_features(seen, past)
        value = self.critic(self.critic_hidden(features))  # [B, 1], for a team [B, A, 1] unless the critic is central
        return value.expand(-1, self.agents) if self.central else value.squeeze(-1), memory

    @torch.no_grad()
    def remember(self, seen: Tensor, past: Past) -> Tensor:
        """Return the memory after each step of `past.mask`, `[rows, memory_width]`, for normalized observations."""
        features = [self._actor_features(seen, past)[0]]  # after a memory, features are its states
        if not self.shared:
            features.append(self._critic_features(seen, past)[0])
        return torch.cat([states.flatten(1) for states in features], -1)

    def _numbered(self, observation: Tensor) -> Tensor:
        """Append the index of the agent for a shared policy: a one-hot to `[B, A, size]`, planes to images."""
        if not self.numbered:
            return observation
        shape = (self.agents, *[1] * (observation.ndim - 3), self.agents)
        number = (
            torch.eye(self.agents, device=observation.device).view(shape).expand(*observation.shape[:-1], self.agents)
        )
        return torch.cat([observation, number], -1)

    @cached_property  # constant, and slow to compute
    def parameters_apart(self) -> tuple[list[nn.Parameter], list[nn.Parameter]]:
        """Return the parameters that are stacked by policy along the first axis, and the others."""
        parts: list[nn.Module] = [self.actor_torso, self.actor_memory, self.actor_hidden, self.actor]
        critic = [self.critic_torso, self.critic_memory, self.critic_hidden, self.critic]
        parts += [] if self.central else critic
        own = {weight for part in parts for weight in part.parameters()} if self.policies > 1 else set()
        return [p for p in self.parameters() if p in own], [p for p in self.parameters() if p not in own]

    @property
    def device(self) -> torch.device:
        """The device of the weights. Observations to play and sampled actions are on the host on every device."""
        return self.critic.weight.device

    def _fetched(self, policy: Policy) -> Policy:
        """Return a policy on the host, where actions are sampled from the same stream for every device."""
        if self.device.type == "cpu":
            return policy
        fetched = copy.copy(policy)
        vars(fetched).update({name: part.cpu() for name, part in vars(policy).items() if isinstance(part, Tensor)})
        return fetched

    def _sent(self, host: Tensor) -> Tensor:
        """Copy a tensor from the host to the device, without waiting if its memory is pinned."""
        return host.to(self.device, non_blocking=True)

    # The following methods take the memory of each environment, `[B, memory_width]`, which is empty by default.

    @torch.inference_mode()
    def value(self, observation: Tensor, memory: Tensor | None = None) -> Tensor:
        """Return the value `[B]`, for a team `[B, A]`."""
        memory = self.empty_memory(len(observation)) if memory is None else memory
        return self._value(self.normaliser(self._sent(observation)), Past(self._sent(memory)))[0].cpu()

    def act(
        self, observation: Tensor, generator: torch.Generator, memory: Tensor | None = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Sample actions; return them with their log-probabilities and the values: `[B]` each, for a team `[B, A]`.

        `memory` is updated in place.
        """
        return self.draw(*self.infer(observation, memory), generator)

    @torch.inference_mode()
    def infer(self, observation: Tensor, memory: Tensor | None = None) -> tuple[Policy, Tensor]:
        """Do the first half of `act`: return policy and values on the device, which may still be computing them."""
        past = None if memory is None else Past(self._sent(memory))
        policy, value, remembered = self._infer(self.normaliser(self._sent(observation)), past)
        if memory is not None:
            memory.copy_(remembered)
        return policy, value

    @torch.inference_mode()
    def draw(self, policy: Policy, value: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor, Tensor]:
        """Do the second half of `act`."""
        policy = self._fetched(policy)
        action = policy.sample(generator)
        return action, policy.log_prob(action), value.cpu()

    @torch.inference_mode()
    def play(
        self, observation: np.ndarray, generator: Streams, greedy: bool = False, memory: Tensor | None = None
    ) -> np.ndarray:
        """Return the actions for the environments, given their observations.

        Only the actor's part of `memory` is updated in place. With several generators, the batch consists of as many
        parts of the same size, each with its own.
        """
        memory = self.empty_memory(len(observation)) if memory is None else memory
        seen = self.normaliser(self._sent(torch.as_tensor(observation, dtype=torch.float32)))
        features, memory[:, : self.actor_memory.width] = self._actor_features(seen, Past(self._sent(memory)))
        policy = self._fetched(self.actor(self.actor_hidden(features)))
        return self.to_environment(policy.mode() if greedy else policy.sample(generator))

    def to_environment(self, action: Tensor) -> np.ndarray:
        """Turn actions of the policy into actions of the environment.

        A discrete action is shifted to the start of the space. A continuous action is scaled so that -1 and 1 become
        the bounds if these are finite, and clipped to the bounds.
        """
        array, space = action.numpy(), self.action_space
        if isinstance(space, Discrete):
            return array + space.start
        assert space.shape is not None
        array = array.reshape(*array.shape[:-1], *space.shape)
        if not isinstance(space, Box):
            return (array + (space.start if isinstance(space, MultiDiscrete) else 0)).astype(space.dtype)
        low, high = space.low, space.high
        with np.errstate(over="ignore"):  # the width of a box without bounds overflows
            bounded = np.isfinite(high - low)
        bottom, top = np.where(bounded, low, -1.0), np.where(bounded, high, 1.0)
        center, reach = (bottom + top) / 2, (top - bottom) / 2
        scaled = np.clip(center + reach * array, low, high)
        return (np.rint(scaled) if np.issubdtype(space.dtype, np.integer) else scaled).astype(space.dtype)


def widened(space: Space, times: int, more: int) -> Space:
    """Return a space of observations whose last axis is `times` as long plus `more`."""
    if isinstance(space, Parts):
        return repeated(space, times, more)
    if not isinstance(space, Box) or not space.shape:
        return space  # `torso` raises the error
    shape = (*space.shape[:-1], times * space.shape[-1] + more)
    return Box(float(space.low.min()), float(space.high.max()), shape, space.dtype.type)


class Player:
    """A student that plays episodes in a batch of environments, with its memory of each.

    Args:
        student: a `Student`, or any object with its `play` and `empty_memory`.
        generator: random stream of the actions.
        greedy: take the most likely actions.
    """

    def __init__(self, student: Student, generator: torch.Generator, greedy: bool = False) -> None:
        self.student, self.generator, self.greedy = student, generator, greedy
        self.memory = student.empty_memory(0)  # [N, memory_width]

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Return actions for observations `[N, ...]`; a new number of environments resets the memory."""
        if len(self.memory) != len(observation):
            self.memory = self.student.empty_memory(len(observation))
        return self.student.play(observation, self.generator, self.greedy, self.memory)

    def begin(self, where: np.ndarray | None = None) -> None:
        """Reset the memory of the environments `where`, bool `[N]`, in which episodes start; None: all."""
        if where is None:
            self.memory[:] = 0.0
        else:
            self.memory[torch.as_tensor(where)] = 0.0
