"""Scaling of images: by the bounds of their space, or by the observed maximum if it is far below the bounds.

In observations of several parts, each image has its own scale, and the other entries are normalized.

Read next: `learning.student`, which uses the scaled images.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from ued.core.parts import Parts
from ued.core.sparse_image import SparseImage
from ued.learning.networks import image_of
from ued.learning.sparse_convolutions import images_of

DARK = 0.1  # share of the bound; images that stay below are scaled by the observed maximum
LEVELS = 255  # a scale is at least 1 / LEVELS of the bound, to avoid amplifying noise around 0


class Pixels(nn.Module):
    """Scale images to [0, 1].

    The scale is the bound of the space if the first rollout has a value above `DARK` times the bound, as camera images
    do. Other environments declare bytes but use only small numbers, such as 0 to 10 in MiniGrid. Their scale is the
    largest observed value, which is part of the student's state. Before the first rollout, the same rule applies to
    each image separately. Images without bounds are not scaled.

    Attributes:
        scale: divisor `[]`: 0 before the first rollout; the range of the bounds if the bounds are the scale.
    """

    scale: Tensor

    def __init__(self, space: Box) -> None:
        super().__init__()
        low, high = float(space.low.min()), float(space.high.max())
        bounded = math.isfinite(low) and math.isfinite(high) and high > low
        self.low, self.reach = (low, high - low) if bounded else (0.0, 1.0)
        self.register_buffer("scale", torch.tensor(0.0 if bounded else self.reach))
        self.divisor = float(self.scale)  # a copy as a float, to avoid waiting for a GPU

    def forward(self, observation: Tensor) -> Tensor:
        """Return images `[B, ...]` or `[B, A, ...]` in [0, 1]."""
        observation = observation.float()
        shifted = observation - self.low if self.low else observation
        if self.divisor:
            return shifted / self.divisor
        largest = shifted.amax((-3, -2, -1), keepdim=True)  # [B, 1, 1, 1]
        dark = largest <= DARK * self.reach
        return torch.where(dark, shifted / largest.clamp(min=self.reach / LEVELS), shifted / self.reach)

    def track(self, observation: Tensor) -> None:
        """Update the scale with a batch of images. Warn if the first batch stays far below the bounds."""
        if self.divisor >= self.reach:
            return
        largest = float(observation.max()) - self.low
        if not self.divisor and largest > DARK * self.reach:
            largest = self.reach
        elif not self.divisor and largest > 0:
            warnings.warn(
                f"image observations reach {largest + self.low:g} in the first rollout, their space {self.low:g} to "
                f"{self.low + self.reach:g}: they are scaled by the largest observed value, not by the bound",
                stacklevel=2,
            )
        if largest > 0:
            self.divisor = max(self.divisor, largest, self.reach / LEVELS)
            self.scale.fill_(self.divisor)

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *others: Any) -> None:
        """Restore the scale; a student saved without one was trained on images scaled by the bounds."""
        state_dict.setdefault(f"{prefix}scale", torch.full_like(self.scale, self.reach))
        super()._load_from_state_dict(state_dict, prefix, *others)
        self.divisor = float(self.scale)


class SparsePixels(Pixels):
    """Scale images of a `SparseImage` as `Pixels` does: a pixel is 1. Inputs are coordinates or images.

    Args:
        space: space of one agent's observations.
        keep: whether the network reads coordinates `[B, K, 3]`; otherwise they become images.
        agents: number of agents.
    """

    def __init__(self, space: SparseImage, keep: bool, agents: int = 1) -> None:
        super().__init__(space.image)
        self.shape, self.keep, self.value = space.image.shape, keep, float(space.image.high.flat[0])
        self.axes = len(self.shape) + 1 + (agents > 1)  # axes of a batch of images

    def forward(self, observation: Tensor) -> Tensor:
        """Return coordinates unchanged, or images `[B, ...]` or `[B, A, ...]` in [0, 1]."""
        if observation.ndim == self.axes:
            return super().forward(observation)
        return observation if self.keep else images_of(observation, self.shape)

    def track(self, observation: Tensor) -> None:
        """Update the scale with a batch of coordinates or images."""
        if observation.ndim == self.axes:
            super().track(observation)
        elif (observation[..., 0] < self.shape[0]).any():
            super().track(torch.tensor(self.value))


class PartScales(nn.Module):
    """Scale each image in vectors of several parts by a separate `Pixels`, and normalize all other entries.

    Args:
        space: space of the vectors.
        others: normalizer of the entries that belong to no image, `[B, k]` or `[B, A, k]`.
    """

    where: Tensor

    def __init__(self, space: Parts, others: Any) -> None:
        super().__init__()
        self.parts, self.others = space.images, others
        self.images = nn.ModuleList(Pixels(part.space) for part in self.parts if isinstance(part.space, Box))
        self.register_buffer("where", torch.as_tensor(space.others), persistent=False)

    def forward(self, observation: Tensor) -> Tensor:
        """Return vectors `[B, F]` or `[B, A, F]`: images in [0, 1], other entries in standard deviations."""
        scaled = observation.to(torch.float32, copy=True)
        for pixels, part in zip(self.images, self.parts, strict=True):
            scaled[..., part.first : part.last] = pixels(image_of(observation, part)).flatten(-3)
        if len(self.where):
            scaled[..., self.where] = self.others(observation[..., self.where].float())
        return scaled

    def track(self, observation: Tensor) -> None:
        """Update the scales and the statistics with a batch of observations `[B, F]` or `[B, A, F]`."""
        for pixels, part in zip(self.images, self.parts, strict=True):
            assert isinstance(pixels, Pixels)
            pixels.track(image_of(observation, part))
        if len(self.where):
            self.others.track(observation[..., self.where])
