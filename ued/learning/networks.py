"""The networks: torsos that read observations, and heads that turn what they read into policies and values.

A policy here is a small object made anew from each forward pass: `sample`, `mode`, `log_prob`, `entropy`, `kl`.
All weights are initialised from an explicit generator. Read next: `learning.student`, which puts the parts together.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete, Space
from torch import Tensor, nn

LOG_2_PI = math.log(2 * math.pi)


class Policy(Protocol):
    """A distribution over actions for each row of a batch.

    `sample` and `mode` return actions `[B]` or `[B, K]`; `log_prob` of such, `entropy` in nats and the divergence
    `kl` from this to another distribution are `[B]`.
    """

    def sample(self, generator: torch.Generator) -> Tensor: ...
    def mode(self) -> Tensor: ...
    def log_prob(self, action: Tensor) -> Tensor: ...
    def entropy(self) -> Tensor: ...
    def kl(self, other: Any) -> Tensor: ...


class Categorical:
    """One of A actions, from logits `[B, A]`. Actions are int64 `[B]`, counted from 0."""

    def __init__(self, logits: Tensor) -> None:
        self.log_probs = torch.log_softmax(logits, -1)  # [B, A]

    def sample(self, generator: torch.Generator) -> Tensor:
        exponential = torch.empty_like(self.log_probs).exponential_(generator=generator)
        return (self.log_probs - exponential.log()).argmax(-1)  # Gumbel-max: -log of an exponential is Gumbel

    def mode(self) -> Tensor:
        return self.log_probs.argmax(-1)

    def log_prob(self, action: Tensor) -> Tensor:
        return self.log_probs.gather(-1, action[..., None])[..., 0]

    def entropy(self) -> Tensor:
        return -(self.log_probs.exp() * self.log_probs).sum(-1)

    def kl(self, other: Categorical) -> Tensor:
        return (self.log_probs.exp() * (self.log_probs - other.log_probs)).sum(-1)


class Gaussian:
    """K independent normal numbers: mean `[B, K]`, log_std `[K]` or `[B, K]`. Actions are float32 `[B, K]`."""

    def __init__(self, mean: Tensor, log_std: Tensor) -> None:
        self.mean, self.log_std = mean, log_std.expand_as(mean)

    def sample(self, generator: torch.Generator) -> Tensor:
        noise = torch.empty_like(self.mean).normal_(generator=generator)
        return self.mean + self.log_std.exp() * noise

    def mode(self) -> Tensor:
        return self.mean

    def log_prob(self, action: Tensor) -> Tensor:
        standard = (action - self.mean) / self.log_std.exp()
        return -(0.5 * standard**2 + self.log_std + 0.5 * LOG_2_PI).sum(-1)

    def entropy(self) -> Tensor:
        return (self.log_std + 0.5 * (1 + LOG_2_PI)).sum(-1)

    def kl(self, other: Gaussian) -> Tensor:
        spread = (2 * (self.log_std - other.log_std)).exp() + ((self.mean - other.mean) / other.log_std.exp()) ** 2
        return (other.log_std - self.log_std + 0.5 * (spread - 1)).sum(-1)


def linear(inputs: int, outputs: int, gain: float, generator: torch.Generator) -> nn.Linear:
    """Return a linear layer with orthogonal weights scaled by `gain` and zero bias."""
    layer = nn.utils.skip_init(nn.Linear, inputs, outputs)  # the usual initialisation draws from torch's global stream
    nn.init.orthogonal_(layer.weight, gain, generator=generator)
    nn.init.zeros_(layer.bias)
    return layer


def mlp(inputs: int, hidden_size: int, hidden_layers: int, generator: torch.Generator) -> nn.Sequential:
    """Return a torso of `hidden_layers` tanh layers: `[B, inputs]` -> `[B, hidden_size]`."""
    layers: list[nn.Module] = []
    for _ in range(hidden_layers):
        layers += [linear(inputs, hidden_size, math.sqrt(2), generator), nn.Tanh()]
        inputs = hidden_size
    return nn.Sequential(*layers)


CONVOLUTIONS = ((32, 8, 4), (64, 4, 2), (32, 3, 1))  # output channels, kernel, stride (thesis, Fig. 4.10)


class ChannelsFirst(nn.Module):
    """Images `[B, height, width, channels]`, as environments give them, to `[B, channels, height, width]`."""

    def forward(self, image: Tensor) -> Tensor:
        return image.permute(0, 3, 1, 2)


def cnn(shape: tuple[int, ...], hidden_size: int, generator: torch.Generator) -> nn.Sequential:
    """Return the convolutional torso of the thesis (Fig. 4.10): `[B, *shape]` in [0, 1] -> `[B, hidden_size]`.

    `shape` is height, width, channels; planes of 72 × 96 come down to 32 of 5 × 8. Raises `ValueError` for images that
    are smaller than what the convolutions need.
    """
    height, width, channels = shape
    layers: list[nn.Module] = [ChannelsFirst()]
    for outputs, kernel, stride in CONVOLUTIONS:
        layer = nn.utils.skip_init(nn.Conv2d, channels, outputs, kernel, stride)
        nn.init.orthogonal_(layer.weight, math.sqrt(2), generator=generator)
        nn.init.zeros_(layer.bias)
        layers += [layer, nn.ReLU()]
        channels, height, width = outputs, (height - kernel) // stride + 1, (width - kernel) // stride + 1
        if height < 1 or width < 1:
            raise ValueError(f"images of {shape[0]} x {shape[1]} are too small for convolutions; give 36 x 36 at least")
    features = channels * height * width
    return nn.Sequential(*layers, nn.Flatten(), linear(features, hidden_size, math.sqrt(2), generator), nn.ReLU())


def is_image(space: Space) -> bool:
    """Return whether observations are images: uint8 `[height, width, channels]`."""
    return isinstance(space, Box) and len(space.shape) == 3 and space.dtype == np.uint8


def torso(space: Space, hidden_size: int, hidden_layers: int, generator: torch.Generator) -> nn.Sequential:
    """Return the torso that fits the observations: an MLP for a flat vector of features, convolutions for an image.

    Raises `ValueError` for observations that are neither.
    """
    if is_image(space):
        assert space.shape is not None
        return cnn(space.shape, hidden_size, generator)
    if not isinstance(space, Box):
        raise ValueError(
            f"observations must be a Box, got {space}; wrap the environment with gymnasium.wrappers.FlattenObservation"
        )
    if len(space.shape) == 3:
        raise ValueError(f"images must be uint8 [height, width, channels], got {space.dtype} {list(space.shape)}")
    if len(space.shape) != 1:
        raise ValueError(
            f"observations must be flat vectors, got shape {space.shape}; "
            "wrap the environment with gymnasium.wrappers.FlattenObservation"
        )
    return mlp(space.shape[0], hidden_size, hidden_layers, generator)


class PolicyHead(nn.Module):
    """The last layer of a policy: a categorical for `Discrete`, a diagonal Gaussian for `Box`.

    Its small gain (0.01) makes the first policy nearly uniform whatever the observation.
    """

    def __init__(self, space: Space, inputs: int, generator: torch.Generator) -> None:
        super().__init__()
        if isinstance(space, Discrete):
            self.log_std = None
            self.layer = linear(inputs, int(space.n), 0.01, generator)
        elif isinstance(space, Box) and len(space.shape) == 1:
            self.log_std = nn.Parameter(torch.zeros(space.shape[0]))
            self.layer = linear(inputs, space.shape[0], 0.01, generator)
        else:
            raise ValueError(f"actions must be Discrete or a flat Box, got {space}")

    def forward(self, features: Tensor) -> Policy:
        """Return the policy for features `[B, inputs]`."""
        if self.log_std is None:
            return Categorical(self.layer(features))
        return Gaussian(self.layer(features), self.log_std)
