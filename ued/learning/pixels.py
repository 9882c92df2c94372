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

DARK = 0.1  # share of the bound: images that stay below it are scaled by what is seen
LEVELS = 255  # a scale is at least this part of the bound, so noise around 0 is not blown up


class Pixels(nn.Module):
    """Scale images to [0, 1].

    The bounds of the space are the scale where the first rollout has a value above `DARK` of them, as camera images do.
    Other environments declare bytes and use a few small numbers: MiniGrid's are 0 to 10 of 255. Their scale is the
    largest value seen so far; it is part of the student's state. Until the first rollout is tracked, each image is
    scaled by the same rule on its own. Images without bounds stay as they are.

    Attributes:
        scale: divisor `[]`: 0 until something is seen, the reach of the bounds where that is the scale.
    """

    scale: Tensor

    def __init__(self, space: Box) -> None:
        super().__init__()
        low, high = float(space.low.min()), float(space.high.max())
        bounded = math.isfinite(low) and math.isfinite(high) and high > low
        self.low, self.reach = (low, high - low) if bounded else (0.0, 1.0)
        self.register_buffer("scale", torch.tensor(0.0 if bounded else self.reach))
        self.divisor = float(self.scale)  # the same, known without waiting for a GPU

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
        """Take a batch of images into the scale. Warn where the first ones stay far below the bounds."""
        if self.divisor >= self.reach:
            return
        largest = float(observation.max()) - self.low
        if not self.divisor and largest > DARK * self.reach:
            largest = self.reach
        elif not self.divisor and largest > 0:
            warnings.warn(
                f"image observations reach {largest + self.low:g} in the first rollout, their space {self.low:g} to "
                f"{self.low + self.reach:g}: they are scaled by the largest value seen, not by the bound",
                stacklevel=2,
            )
        if largest > 0:
            self.divisor = max(self.divisor, largest, self.reach / LEVELS)
            self.scale.fill_(self.divisor)

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *others: Any) -> None:
        """Take back the scale; a student saved without one was trained on images scaled by the bounds."""
        state_dict.setdefault(f"{prefix}scale", torch.full_like(self.scale, self.reach))
        super()._load_from_state_dict(state_dict, prefix, *others)
        self.divisor = float(self.scale)
