"""The networks: torsos that encode observations, and heads for policies and values.

A policy is a small object created by each forward pass: `sample`, `mode`, `log_prob`, `entropy`, `kl`.
All weights are initialized from an explicit generator. Read next: `learning.student`, which combines the parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
import torch
from gymnasium.spaces import Box, Discrete, MultiBinary, MultiDiscrete, Space
from torch import Tensor, nn

from ued.config import PPOConfig
from ued.core.own_code import is_name
from ued.core.parts import LEAST, Part, Parts, channels_first, image_shape
from ued.core.sparse_image import SparseImage
from ued.learning.sparse_convolutions import Grid, convolve, images_of

LOG_2_PI = math.log(2 * math.pi)
IMPOSSIBLE = -1e9  # logit of invalid choices: finite, since 0 times infinity is nan


Streams = torch.Generator | Sequence[torch.Generator]  # several: one for each of as many equal parts of a batch


class Policy(Protocol):
    """A distribution over actions for each row of a batch.

    `sample` and `mode` return actions `[B]` or `[B, K]`; `log_prob`, `entropy` in nats and the divergence `kl` from
    this to another distribution are `[B]`. For a team, all of them have an agent axis: `[B, A]`.
    """

    def sample(self, generator: Streams) -> Tensor: ...
    def mode(self) -> Tensor: ...
    def log_prob(self, action: Tensor) -> Tensor: ...
    def entropy(self) -> Tensor: ...
    def kl(self, other: Any) -> Tensor: ...


def _drawn(draw: Callable[..., Tensor], shape: Sequence[int], streams: Streams) -> Tensor:
    """Return random numbers of this shape, each part of the batch from its own stream."""
    if isinstance(streams, torch.Generator):
        return draw(*shape, generator=streams)
    size = shape[0] // len(streams)
    return torch.cat([draw(size, *shape[1:], generator=stream) for stream in streams])


class Categorical:
    """One of A actions, from logits `[B, A]`. Actions are int64 `[B]`, counted from 0."""

    def __init__(self, logits: Tensor) -> None:
        self.logits = logits

    @cached_property  # PPO's closed form starts from logits
    def log_probs(self) -> Tensor:
        """The logarithms of the probabilities, `[B, A]`."""
        return torch.log_softmax(self.logits, -1)

    def sample(self, generator: Streams) -> Tensor:
        """Sample by the inverse of the cumulative distribution: one number in [0, 1) per choice."""
        uniform = _drawn(torch.rand, self.log_probs.shape[:-1], generator)
        cumulative = self.log_probs.exp().cumsum(-1)  # [B, A]
        return (cumulative[..., :-1] < uniform[..., None] * cumulative[..., -1:]).sum(-1)

    def mode(self) -> Tensor:
        return self.log_probs.argmax(-1)

    def log_prob(self, action: Tensor) -> Tensor:
        return self.log_probs.gather(-1, action[..., None])[..., 0]

    def entropy(self) -> Tensor:
        return -(self.log_probs.exp() * self.log_probs).sum(-1)

    def kl(self, other: Categorical) -> Tensor:
        return (self.log_probs.exp() * (self.log_probs - other.log_probs)).sum(-1)


class MultiCategorical(Categorical):
    """K independent choices, each with its own number of values, from logits `[B, sum of these numbers]`.

    Actions are int64 `[B, K]`, counted from 0.
    """

    def __init__(self, logits: Tensor, sizes: np.ndarray) -> None:
        widest, index = int(sizes.max()), np.arange(int(sizes.max()))
        if (sizes == widest).all():
            super().__init__(logits.unflatten(-1, (len(sizes), widest)))
            return
        inside = torch.as_tensor(index < sizes[:, None])  # [K, widest]
        padded = logits.new_full((*logits.shape[:-1], *inside.shape), IMPOSSIBLE)
        padded[..., inside] = logits
        super().__init__(padded)

    def log_prob(self, action: Tensor) -> Tensor:
        return super().log_prob(action).sum(-1)

    def entropy(self) -> Tensor:
        return super().entropy().sum(-1)

    def kl(self, other: Categorical) -> Tensor:
        return super().kl(other).sum(-1)


class Gaussian:
    """K independent normal variables: mean `[B, K]`, log_std `[K]` or `[B, K]`. Actions are float32 `[B, K]`."""

    def __init__(self, mean: Tensor, log_std: Tensor) -> None:
        self.mean, self.log_std = mean, log_std.expand_as(mean)

    def sample(self, generator: Streams) -> Tensor:
        return self.mean + self.log_std.exp() * _drawn(torch.randn, self.mean.shape, generator)

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


class Team(NamedTuple):
    """The agents of a network: their number, and whether they share one policy or each have their own.

    Inputs and outputs are `[B, ...]` for one agent and `[B, A, ...]` for several. If each agent has its own policy, all
    weights have a leading policy axis, so that one forward pass computes all of them.
    """

    agents: int = 1
    policies: int = 1


ONE_AGENT = Team()


class Linears(nn.Linear):
    """A linear layer for each of A policies: `[B, A, inputs]` -> `[B, A, outputs]`."""

    def __init__(self, inputs: int, outputs: int, policies: int, device: Any = None) -> None:
        super().__init__(inputs, policies * outputs, device=device)
        self.policies = policies

    def forward(self, features: Tensor) -> Tensor:
        weight = self.weight.view(self.policies, -1, self.in_features).mT  # [A, inputs, outputs]
        bias = self.bias.view(self.policies, 1, -1)
        return torch.baddbmm(bias, features.transpose(0, 1), weight).transpose(0, 1)


def linear(inputs: int, outputs: int, gain: float, generator: torch.Generator, policies: int = 1) -> nn.Linear:
    """Return a linear layer, or one for each policy, with orthogonal weights scaled by `gain` and zero bias."""
    if policies == 1:
        layer = nn.Linear(inputs, outputs, device="meta")
    else:
        layer = Linears(inputs, outputs, policies, device="meta")
    initialize(layer, gain, generator, policies)
    return layer


def initialize(layer: nn.Linear | nn.Conv2d, gain: float, generator: torch.Generator, policies: int) -> None:
    """Give each policy's share of a layer orthogonal weights scaled by `gain`, and zero bias.

    The layer is made on torch's device "meta", since the default initialization uses the global generator.
    `nn.utils.skip_init` does the same, and imports sympy, which takes a second.
    """
    assert layer.bias is not None
    layer.weight, layer.bias = (nn.Parameter(torch.empty(part.shape)) for part in (layer.weight, layer.bias))
    for own in layer.weight.data.chunk(policies):
        nn.init.orthogonal_(own, gain, generator=generator)
    nn.init.zeros_(layer.bias)


def mlp(
    inputs: int, hidden_size: int, hidden_layers: int, generator: torch.Generator, policies: int = 1
) -> nn.Sequential:
    """Return a torso of `hidden_layers` tanh layers: `[B, inputs]` -> `[B, hidden_size]`."""
    layers: list[nn.Module] = []
    for _ in range(hidden_layers):
        layers += [linear(inputs, hidden_size, math.sqrt(2), generator, policies), nn.Tanh()]
        inputs = hidden_size
    return nn.Sequential(*layers)


CONVOLUTIONS = ((32, 8, 4), (64, 4, 2), (32, 3, 1))  # output channels, kernel, stride (thesis, Fig. 4.10)
SMALL_CONVOLUTIONS = ((16, 3, 1), (32, 3, 1))  # for images smaller than LARGE
PART_CONVOLUTIONS = SMALL_CONVOLUTIONS[:1]  # for small images that are a part of an observation (PAIRED, DCD)
LARGE = 36  # minimum height and width for CONVOLUTIONS


class ChannelsFirst(nn.Module):
    """Convert images `[B, height, width, channels]`, the usual layout, to `[B, channels, height, width]`.

    Images of a team, `[B, A, ...]`, become additional rows if agents share a policy, otherwise additional channels.
    """

    def __init__(self, team: Team) -> None:
        super().__init__()
        self.team = team

    def forward(self, image: Tensor) -> Tensor:
        image = image.movedim(-1, -3)
        if self.team.agents == 1:
            return image
        return image.flatten(0, 1) if self.team.policies == 1 else image.flatten(1, 2)


class Torso(nn.Sequential):
    """The layers before the memory, `[B, ...]` or `[B, A, ...]` -> `[B, size]` or `[B, A, size]`."""

    def __init__(self, layers: Sequence[nn.Module], size: int) -> None:
        super().__init__(*layers)
        self.size = size


def convolutions(
    shape: tuple[int, ...], small: Sequence[tuple[int, int, int]], generator: torch.Generator, team: Team
) -> Torso:
    """Return convolutions for images of a shape with three axes; `small` is used for images smaller than `LARGE`.

    Raises `ValueError` for a team with channels-first images.
    """
    agents, policies = team
    first = channels_first(shape)
    channels, height, width = shape if first else (shape[2], *shape[:2])
    if first and agents > 1:
        raise ValueError(f"images of several agents must be [height, width, channels], got {list(shape)}")
    layers: list[nn.Module] = [] if first else [ChannelsFirst(team)]
    for outputs, kernel, stride in CONVOLUTIONS if min(height, width) >= LARGE else small:
        sizes = policies * channels, policies * outputs, kernel, stride
        layer = nn.Conv2d(*sizes, groups=policies, device="meta")
        initialize(layer, math.sqrt(2), generator, policies)
        layers += [layer, nn.ReLU()]
        channels, height, width = outputs, (height - kernel) // stride + 1, (width - kernel) // stride + 1
    features = channels * height * width
    layers.append(nn.Flatten())
    if agents > 1:  # separate their rows or channels again
        layers.append(nn.Unflatten(0, (-1, agents)) if policies == 1 else nn.Unflatten(1, (agents, features)))
    return Torso(layers, features)


def cnn(space: Box, hidden_size: int, generator: torch.Generator, team: Team = ONE_AGENT) -> Torso:
    """Return the convolutional torso of the thesis (Fig. 4.10): images in [0, 1] -> `[B, hidden_size]`.

    Planes of 72 × 96 are reduced to 32 planes of 5 × 8; small images use small convolutions. Raises `ValueError` for a
    team with channels-first images.
    """
    read = convolutions(space.shape, SMALL_CONVOLUTIONS, generator, team)
    return Torso(
        [*read, linear(read.size, hidden_size, math.sqrt(2), generator, team.policies), nn.ReLU()], hidden_size
    )


class SparseTorso(Torso):
    """The torso of `cnn` for images of a `SparseImage`: the same layers, the first two computed from coordinates.

    It takes coordinates `[B, K, 3]` or images `[B, height, width, channels]`. On a GPU, coordinates become images.
    """

    def __init__(self, space: SparseImage, hidden_size: int, generator: torch.Generator) -> None:
        layers = cnn(space.image, hidden_size, generator)
        super().__init__([*layers], layers.size)
        self.shape = space.image.shape

    def forward(self, seen: Tensor) -> Tensor:
        if seen.ndim == len(self.shape) + 1:
            return super().forward(seen)
        if seen.device.type != "cpu":
            return super().forward(images_of(seen, self.shape))
        _, first, _, second, _, *others = self  # channels first, two convolutions, their ReLUs
        assert isinstance(first, nn.Conv2d) and isinstance(second, nn.Conv2d)
        features = convolve(seen, Grid(*self.shape[:2]), first, second)
        for layer in others:
            features = layer(features)
        return features


class PartReader(nn.Module):
    """Convolutions for the images in vectors of several parts: `[B, F]` or `[B, A, F]` -> `[B, size]`, `[B, A, size]`.

    Small images have 16 filters of 3 × 3, as in PAIRED (Dennis et al. 2020, appendix D) and in DCD; large images have
    `CONVOLUTIONS`. Their outputs come first, in the order of the images; all other entries follow unchanged.
    DCD adds a linear layer of 5 units for the direction, which is redundant before another linear layer.
    """

    others: Tensor

    def __init__(self, space: Parts, generator: torch.Generator, team: Team) -> None:
        super().__init__()
        self.images = space.images
        shapes = [part.image for part in self.images if part.image is not None]
        read = [convolutions(shape, PART_CONVOLUTIONS, generator, team) for shape in shapes]
        self.read = nn.ModuleList(read)
        self.register_buffer("others", torch.as_tensor(space.others), persistent=False)
        self.size = sum(one.size for one in read) + len(space.others)

    def forward(self, observation: Tensor) -> Tensor:
        read = [layers(image_of(observation, part)) for layers, part in zip(self.read, self.images, strict=True)]
        return torch.cat([*read, observation[..., self.others]], -1)


def image_of(observation: Tensor, part: Part) -> Tensor:
    """Return the image that is a part of vectors `[..., F]`: `[..., height, width, channels]`, or channels first."""
    assert part.image is not None
    return observation[..., part.first : part.last].unflatten(-1, part.image)


def is_image(space: Space) -> bool:
    """Return whether observations are images: three axes, high and wide enough; see `core.parts.image_shape`."""
    return len(space.shape or ()) == 3 and image_shape(space) is not None


def seen_as(space: Space, network: str, agents: int = 1) -> Space:
    """Return the space of a network's inputs: vectors of `Parts` have parts only for convolutions and user networks.

    A `SparseImage` provides coordinates only for the convolutions of one agent; other networks receive its images.
    Raises `ValueError` for `network` "cnn" if there is no image.
    """
    if isinstance(space, SparseImage):
        seen = seen_as(space.image, network)
        return space if agents == 1 and is_image(seen) and network in ("auto", "cnn") else seen
    images = space.images if isinstance(space, Parts) else is_image(space)
    if network == "cnn" and not images:
        raise ValueError(f"network = cnn needs images of at least {LEAST} x {LEAST}, got {space}")
    if (
        isinstance(space, Parts)
        and not is_name(network)
        and not (images and "cnn" in (network, space.network) and network != "mlp")
    ):
        return Box(space.low, space.high, dtype=space.dtype.type)
    return space


def torso(space: Space, config: PPOConfig, generator: torch.Generator, team: Team = ONE_AGENT) -> Torso:
    """Return the torso for an agent's observations: an MLP for a flat feature vector, convolutions for images.

    `space` is the result of `seen_as`. Raises `ValueError` for other observations.
    """
    sizes = config.hidden_size, config.hidden_layers, generator
    if isinstance(space, SparseImage):
        return SparseTorso(space, config.hidden_size, generator)
    if isinstance(space, Parts):
        reader = PartReader(space, generator, team)
        hidden = mlp(reader.size, *sizes, team.policies)
        return Torso([reader, *hidden], config.hidden_size if len(hidden) else reader.size)
    if is_image(space) and config.network != "mlp":
        assert isinstance(space, Box)
        return cnn(space, config.hidden_size, generator, team)
    if not isinstance(space, Box):
        raise ValueError(
            f"observations must be a Box, got {space}; wrap the environment with gymnasium.wrappers.FlattenObservation"
        )
    if len(space.shape) not in (1, 3):
        raise ValueError(
            f"observations must be flat vectors, got shape {space.shape}; "
            "wrap the environment with gymnasium.wrappers.FlattenObservation"
        )
    size = math.prod(space.shape)
    flat = [nn.Flatten(-3)] if len(space.shape) == 3 else []  # an image without convolutions
    hidden = mlp(size, *sizes, team.policies)
    return Torso([*flat, *hidden], config.hidden_size if len(hidden) else size)


def choices_of(space: Space) -> np.ndarray:
    """Return the number of values of each entry of an action: int `[K]`; empty for continuous actions."""
    if isinstance(space, Discrete):
        return np.array([space.n])
    if isinstance(space, MultiDiscrete):
        return space.nvec.ravel()
    return np.full(math.prod(space.shape), 2) if isinstance(space, MultiBinary) else np.zeros(0, np.int64)


class PolicyHead(nn.Module):
    """The last layer of a policy.

    It is a categorical for `Discrete`, a categorical for each entry of `MultiDiscrete` and `MultiBinary`, and a
    diagonal Gaussian for `Box`. Its small gain (0.01) makes the initial policy nearly uniform for every observation.
    """

    def __init__(self, space: Space, inputs: int, generator: torch.Generator, policies: int = 1) -> None:
        super().__init__()
        self.choices, self.single = choices_of(space), isinstance(space, Discrete)
        if len(self.choices):
            self.log_std = None
            self.layer = linear(inputs, int(self.choices.sum()), 0.01, generator, policies)
        elif isinstance(space, Box):
            size = math.prod(space.shape)
            self.log_std = nn.Parameter(torch.zeros(policies, size) if policies > 1 else torch.zeros(size))
            self.layer = linear(inputs, size, 0.01, generator, policies)
        else:
            raise ValueError(f"actions must be Discrete, MultiDiscrete, MultiBinary or a Box, got {space}")

    def forward(self, features: Tensor) -> Policy:
        """Return the policy for features `[B, inputs]`, or `[B, A, inputs]`."""
        if self.log_std is not None:
            return Gaussian(self.layer(features), self.log_std)
        logits = self.layer(features)
        return Categorical(logits) if self.single else MultiCategorical(logits, self.choices)
