"""Binary images with few nonzero pixels, stored as the coordinates of these pixels.

A UPOMDP whose observation space is a `SparseImage` returns coordinates instead of images, and rollouts store them:
GRF's stacked planes take 288 bytes instead of 110,592. Convolutions compute from the coordinates, see
`learning.sparse_convolutions`; code that needs the images calls `as_dense`.
Read next: `core.parts`, observations of several parts.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space

from ued.core.parts import channels_first

BYTE = 255  # largest coordinate that is stored in one byte


class SparseImage(Box):
    """The space of binary images `[height, width, channels]`, each as the coordinates of its pixels that are not 0.

    An observation is `[most, 3]`: row, column and channel of each pixel, once, in the order of the image in memory.
    Unused rows are (height, 0, 0), a pixel below the image. The value of a pixel is the upper bound of `image`.

    Args:
        image: the space of the images, a Box with the bounds 0 and a finite number.
        most: maximum number of pixels.
        agents: number of agents; several agents are the first axis.

    Raises ValueError for another space, and for images that convolutions read as channels first.
    """

    def __init__(self, image: Box, most: int, agents: int = 1) -> None:
        low, high = image.low, image.high
        if len(image.shape) != 3 or low.any() or not np.isfinite(high).all() or (high != high.flat[0]).any():
            raise ValueError(f"a SparseImage needs a Box of three axes from 0 to one finite number, got {image}")
        if channels_first(image.shape):
            raise ValueError(f"a SparseImage needs images [height, width, channels], got {list(image.shape)}")
        self.image, self.most, self.agents = image, most, agents
        height, width, channels = image.shape
        last = np.array([height, width - 1, channels - 1])
        kind = np.uint8 if last.max() <= BYTE else np.int32
        shape = (most, 3) if agents == 1 else (agents, most, 3)
        super().__init__(np.zeros(shape, kind), np.broadcast_to(last, shape).astype(kind), dtype=kind)

    def of_one_agent(self) -> SparseImage:
        """Return the space of one of several agents."""
        return SparseImage(self.image, self.most)

    def dense(self, pixels: np.ndarray) -> np.ndarray:
        """Return the images `[..., height, width, channels]` of coordinates `[..., most, 3]`."""
        height, width, channels = self.image.shape
        rows = np.asarray(pixels).reshape(-1, pixels.shape[-2], 3).astype(np.int64)
        images = np.zeros((len(rows), height + 1, width, channels), self.image.dtype)
        images[np.arange(len(rows))[:, None], rows[..., 0], rows[..., 1], rows[..., 2]] = self.image.high.flat[0]
        return images[:, :height].reshape(*pixels.shape[:-2], *self.image.shape)

    def sparse(self, images: np.ndarray) -> np.ndarray:
        """Return the coordinates `[..., most, 3]` of images `[..., height, width, channels]`.

        Raises ValueError for pixels of other values than the two bounds, and for more than `most` of them.
        """
        flat = np.asarray(images).reshape(-1, *self.image.shape)
        image, *where = np.nonzero(flat)
        if (flat[flat != 0] != self.image.high.flat[0]).any():
            raise ValueError(f"the pixels of a SparseImage must be 0 or {self.image.high.flat[0]}, got other values")
        counts = np.bincount(image, minlength=len(flat))
        if counts.size and counts.max() > self.most:
            raise ValueError(f"this SparseImage has at most {self.most} pixels that are not 0, got {counts.max()}")
        pixels = np.zeros((len(flat), self.most, 3), self.dtype)
        pixels[..., 0] = self.image.shape[0]
        pixels[image, np.arange(len(image)) - (np.cumsum(counts) - counts)[image]] = np.stack(where, 1)
        return pixels.reshape(*np.shape(images)[:-3], self.most, 3)

    def __repr__(self) -> str:
        return f"SparseImage({self.image}, {self.most})"


def dense_space(space: Space) -> Space:
    """Return the space of the images of a `SparseImage`, `[A, ...]` for A agents; other spaces unchanged."""
    if not isinstance(space, SparseImage) or space.agents == 1:
        return space.image if isinstance(space, SparseImage) else space
    low, high = (np.broadcast_to(bound, (space.agents, *bound.shape)) for bound in (space.image.low, space.image.high))
    return Box(low, high, dtype=space.image.dtype.type)


def as_dense(space: Space, observations: Any) -> Any:
    """Return observations of a `SparseImage` as images; observations of other spaces unchanged."""
    return space.dense(observations) if isinstance(space, SparseImage) else observations
