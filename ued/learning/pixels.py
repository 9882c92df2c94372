"""How a student scales images: by the bounds of their space, or by what it sees where that stays far below them.

Read next: `learning.student`, which reads the scaled images.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import torch
from gymnasium.spaces import Box
from torch import Tensor, nn

from ued.learning.networks import channels_first

DARK = 0.1  # share of the bound: images that stay below it are scaled by what is seen
LEVELS = 255  # a scale is at least this part of the bound, so noise around 0 is not blown up


class Pixels(nn.Module):
    """Scale images to [0, 1].

    The bounds of the space are the scale where the first rollout has a value above `DARK` of them, as camera images do.
    Other environments declare bytes and use a few small numbers: MiniGrid's are 0 to 10 of 255. Their scale is the
    largest value seen so far in each channel; it is part of the student's state. Until the first rollout is tracked,
    each image is scaled by the same rule on its own. Images without bounds stay as they are.

    Attributes:
        scale: divisor of each channel `[C]`: 0 until something is seen, the bound where that is the scale.
    """

    scale: Tensor

    def __init__(self, space: Box) -> None:
        super().__init__()
        low, high = float(space.low.min()), float(space.high.max())
        bounded = math.isfinite(low) and math.isfinite(high) and high > low
        self.low, self.reach = (low, high - low) if bounded else (0.0, 1.0)
        self.channel = -3 if channels_first(space) else -1
        start = 0.0 if bounded else self.reach
        self.register_buffer("scale", torch.full((space.shape[self.channel],), start))
        self._note()

    def _note(self) -> None:
        """Note what `scale` says, so that no forward pass waits for a GPU to tell."""
        self.by_bounds = bool((self.scale >= self.reach).all())
        self.seen = bool((self.scale > 0).any())

    def forward(self, observation: Tensor) -> Tensor:
        """Return images `[B, ...]` or `[B, A, ...]` in [0, 1]."""
        observation = observation.float()
        shifted = observation - self.low if self.low else observation
        if self.by_bounds:
            return shifted / self.reach
        if self.seen:
            shape = [-1] + [1] * (-1 - self.channel)
            return shifted / self.scale.clamp(min=self.reach / LEVELS).view(shape)
        largest = shifted.amax(self._plane(), keepdim=True)  # [B, 1, 1, C]
        dark = largest.amax(self.channel, keepdim=True) <= DARK * self.reach
        return torch.where(dark, shifted / largest.clamp(min=self.reach / LEVELS), shifted / self.reach)

    def _plane(self) -> tuple[int, int]:
        """Return the axes of height and width."""
        return (-2, -1) if self.channel == -3 else (-3, -2)

    def track(self, observation: Tensor) -> None:
        """Take a batch of images into the scale. Warn where the first ones stay far below the bounds."""
        if self.by_bounds:
            return
        largest = observation.amax(self._plane()).flatten(0, -2).amax(0).float() - self.low  # [C]
        top = float(largest.max())
        if not self.seen and top > DARK * self.reach:
            self.scale.fill_(self.reach)
        else:
            if not self.seen and top > 0:
                warnings.warn(
                    f"image observations reach {top + self.low:g} in the first rollout, their space {self.low:g} to "
                    f"{self.low + self.reach:g}: each channel is scaled by the largest value seen, not by the bound",
                    stacklevel=2,
                )
            self.scale.copy_(torch.maximum(self.scale, largest))
        self._note()

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *others: Any) -> None:
        """Take back the scale; a student saved without one was trained on images scaled by the bounds."""
        state_dict.setdefault(f"{prefix}scale", torch.full_like(self.scale, self.reach))
        super()._load_from_state_dict(state_dict, prefix, *others)  # type: ignore[no-untyped-call]
        self._note()
