"""A student: the policy that plays, the values it expects, and how it looks at observations and sends actions.

Observations are normalised by running statistics that the student carries (and its checkpoint with it), rather than by
a fixed scaling: the same student then learns from any Gymnasium environment, whatever the units of its observations.
Read next: `learning.rollout`.
"""

from __future__ import annotations

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete, Space
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.learning.networks import Policy, PolicyHead, is_image, linear, torso

CLIP = 10.0  # standard deviations


class Normaliser(nn.Module):
    """Shift and scale observations by their running mean and standard deviation (Chan et al. 1979, parallel form).

    A feature that hardly moved while the student learned must not blow up when it moves a little more, as in another
    engine or on another level: no standard deviation counts as less than `floor` `[size]`, in the feature's own unit.
    """

    mean: Tensor
    variance: Tensor
    count: Tensor
    floor: Tensor

    def __init__(self, floor: Tensor) -> None:
        super().__init__()
        size = len(floor)
        self.register_buffer("floor", floor.float())
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("variance", torch.ones(size))
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))

    def forward(self, observation: Tensor) -> Tensor:
        """Return observations `[B, size]` in standard deviations from the mean, at most CLIP of them."""
        deviation = torch.maximum((self.variance + 1e-8).sqrt(), self.floor)  # [size]
        return ((observation - self.mean) / deviation).clamp(-CLIP, CLIP)

    def track(self, observation: Tensor) -> None:
        """Take a batch of observations `[B, size]` into the statistics."""
        rows = len(observation)
        variance, mean = torch.var_mean(observation.double(), 0, correction=0)
        total = self.count + rows
        delta = mean - self.mean.double()
        self.variance.copy_(
            (self.variance.double() * self.count + variance * rows + delta**2 * self.count * rows / total) / total
        )
        self.mean.add_((delta * rows / total).float())
        self.count.copy_(total)


class Pixels(nn.Module):
    """Scale images uint8 to [0, 1]; there is nothing to learn of their statistics."""

    def forward(self, observation: Tensor) -> Tensor:
        return observation.float() / 255

    def track(self, observation: Tensor) -> None:
        """Do nothing: see the class."""


class Student(nn.Module):
    """An actor and a critic on top of one or two torsos.

    Args:
        observation_space, action_space: of one environment; flat Box or image, and Discrete or flat Box.
        config: how large its torsos are, and whether actor and critic share one, as in the thesis (Fig. 4.10).
        generator: what the weights are drawn from.
        unit: of each entry of an observation `[size]`; see `UPOMDP.observation_unit`.
    """

    def __init__(
        self,
        observation_space: Space,
        action_space: Space,
        config: PPOConfig,
        generator: torch.Generator,
        unit: np.ndarray | None = None,
    ) -> None:
        super().__init__()
        sizes = config.hidden_size, config.hidden_layers
        self.actor_torso = torso(observation_space, *sizes, generator)
        self.critic_torso = self.actor_torso if config.shared_torso else torso(observation_space, *sizes, generator)
        assert observation_space.shape is not None  # `torso` has refused the others
        if is_image(observation_space):
            self.normaliser: Normaliser | Pixels = Pixels()
        else:
            units = np.zeros(observation_space.shape) if unit is None else unit
            self.normaliser = Normaliser(config.obs_std_floor * torch.as_tensor(units))
        self.actor = PolicyHead(action_space, config.hidden_size, generator)
        self.critic = linear(config.hidden_size, 1, 1.0, generator)
        self.action_space = action_space
        self.shared = config.shared_torso

    def forward(self, observation: Tensor) -> tuple[Policy, Tensor]:
        """Return the policy and the value `[B]` for observations `[B, size]`."""
        observation = self.normaliser(observation)
        features = self.actor_torso(observation)
        policy = self.actor(features)
        if not self.shared:
            features = self.critic_torso(observation)
        return policy, self.critic(features)[:, 0]

    @torch.inference_mode()
    def value(self, observation: Tensor) -> Tensor:
        """Return the value `[B]` alone."""
        return self.critic(self.critic_torso(self.normaliser(observation)))[:, 0]

    @torch.inference_mode()
    def act(self, observation: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor, Tensor]:
        """Draw actions; return them with their log-probabilities `[B]` and the values `[B]`."""
        policy, value = self(observation)
        action = policy.sample(generator)
        return action, policy.log_prob(action), value

    @torch.inference_mode()
    def play(self, observation: np.ndarray, generator: torch.Generator, greedy: bool = False) -> np.ndarray:
        """Return the actions to send to the environments, for observations as they come from them."""
        features = self.normaliser(torch.as_tensor(observation, dtype=torch.float32))
        policy = self.actor(self.actor_torso(features))
        return self.to_environment(policy.mode() if greedy else policy.sample(generator))

    def to_environment(self, action: Tensor) -> np.ndarray:
        """Turn actions of the policy into actions of the environment.

        A discrete action is shifted to where the space starts. A continuous one is stretched so that -1 and 1 are the
        bounds where these are finite, and clipped to them.
        """
        array = action.numpy()
        if isinstance(self.action_space, Discrete):
            return array + self.action_space.start
        assert isinstance(self.action_space, Box)
        low, high = self.action_space.low, self.action_space.high
        bounded = np.isfinite(low) & np.isfinite(high)
        bottom, top = np.where(bounded, low, -1.0), np.where(bounded, high, 1.0)
        centre, reach = (bottom + top) / 2, (top - bottom) / 2
        return np.clip(centre + reach * array, low, high).astype(self.action_space.dtype)
