"""Observations of several parts, such as an image and a direction, as one vector with a description of its parts.

Batches, rollouts and checkpoints hold the vector. A network with convolutions reads the images in it, see
`learning.networks.PartReader`; other networks use it as any vector.
Read next: `adapters.gym`, which flattens the observations of Gymnasium environments into such vectors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Space, Tuple

LEAST = 5  # minimum height and width of an image; smaller ones are flattened
Network = Literal["auto", "mlp", "cnn"]


class Part(NamedTuple):
    """Entries `first` to `last` (exclusive) of a vector: the value under `keys` of a `Dict` or `Tuple`.

    `image` is the shape in which these entries are an image, with an axis of channels, first or last; None: no image.
    """

    keys: tuple[Any, ...]
    space: Space
    first: int
    last: int
    image: tuple[int, ...] | None

    @property
    def name(self) -> str:
        """The part as Python writes it: `observations['image']`."""
        return "observations" + "".join(f"[{key!r}]" for key in self.keys)


class Parts(Box):
    """The space of vectors that concatenate the parts of a `Dict` or a `Tuple`, including nested ones.

    Parts follow the order of the space (Gymnasium sorts the keys of a dict), each as `gymnasium.spaces.flatten` writes
    it: Boxes in C order, `Discrete` and `MultiDiscrete` one-hot. The vector is uint8 if all parts fit into bytes, which
    saves three quarters of the memory of rollouts; otherwise it is float32.

    Args:
        space: a `Dict` or `Tuple` of `Box`, `Discrete`, `MultiDiscrete` and `MultiBinary`.
        network: the network that `PPOConfig.network = "auto"` selects for these observations.

    Attributes:
        parts: all parts in their order.
        images: the parts that convolutions read; see `image_shape`.
        others: the entries that belong to no image, int64 `[k]`.

    Raises ValueError for parts of other spaces.
    """

    def __init__(self, space: Dict | Tuple, network: Literal["mlp", "cnn"] = "cnn") -> None:
        self.space, self.network = space, network
        self.parts = _parts_of(space)
        self.images = tuple(part for part in self.parts if part.image is not None)
        others = [np.arange(part.first, part.last) for part in self.parts if part.image is None]
        self.others = np.concatenate([np.zeros(0, np.int64), *others])
        bounds = [_bounds(part) for part in self.parts]
        low, high = (np.concatenate(side) if side else np.zeros(0) for side in zip(*bounds, strict=True))
        kind = np.uint8 if all(_is_bytes(part.space) for part in self.parts) else np.float32
        super().__init__(low.astype(kind), high.astype(kind), dtype=kind)

    def flatten(self, observation: Any) -> np.ndarray:
        """Return one observation of `space` as a vector `[F]`; raises as `flatten_batch`."""
        return self._rows(observation, single=True)[0]

    def flatten_batch(self, observations: Any) -> np.ndarray:
        """Return observations of N environments, a dict or tuple of arrays `[N, ...]`, as vectors `[N, F]`.

        Raises ValueError for a part that is missing, has another shape, or is not in its space.
        """
        return self._rows(observations, single=False)

    def is_batch(self, observations: Any) -> bool:
        """Return whether these are observations of several environments: arrays have one more axis than their space."""
        part = self.parts[0]
        return np.ndim(_value(part, observations)) > len(part.space.shape or ())

    def _rows(self, observations: Any, single: bool) -> np.ndarray:
        columns = []
        for part in self.parts:
            values = np.asarray(_value(part, observations))
            columns.append(_columns(part, values[None] if single else values))
        lengths = {len(column) for column in columns}
        if len(lengths) > 1:
            raise ValueError(f"all parts must have the same number of environments, got {sorted(lengths)}")
        return np.concatenate(columns, 1, dtype=self.dtype, casting="unsafe")

    def __repr__(self) -> str:
        return f"Parts({self.space})"


def image_shape(space: Space) -> tuple[int, ...] | None:
    """Return the shape of images `[height, width, channels]` or `[channels, height, width]`; None for other spaces.

    Images are at least `LEAST` high and wide. Gray images, two axes of bytes, get an axis of one channel.
    """
    if not isinstance(space, Box):
        return None
    shape = (*space.shape, 1) if len(space.shape) == 2 and space.dtype == np.uint8 else space.shape
    if len(shape) != 3:
        return None
    return shape if min(shape[1:] if channels_first(shape) else shape[:2]) >= LEAST else None


def channels_first(shape: tuple[int, ...]) -> bool:
    """Return whether images are `[channels, height, width]`: the first axis is the shortest, and not the last."""
    return shape[0] < min(shape[1:])


def has_images(space: Space) -> bool:
    """Return whether a space is a `Dict` or `Tuple` with an image among its parts."""
    nested = isinstance(space, Dict | Tuple)
    return nested and any(image_shape(leaf) is not None for _, leaf in _walk(space, ()))


def repeated(space: Parts, times: int, more: int) -> Parts:
    """Return the space of `times` such vectors, concatenated, followed by `more` entries."""
    every: list[Space] = [space.space] * times
    return Parts(Tuple([*every, Discrete(more)] if more else every), space.network)


def _walk(space: Space, keys: tuple[Any, ...]) -> list[tuple[tuple[Any, ...], Space]]:
    """Return the spaces in a nested `Dict` or `Tuple`, with their keys, in their order."""
    if not isinstance(space, Dict | Tuple):
        return [(keys, space)]
    named = space.spaces.items() if isinstance(space, Dict) else enumerate(space.spaces)
    return [leaf for key, part in named for leaf in _walk(part, (*keys, key))]


def _parts_of(space: Space) -> tuple[Part, ...]:
    """Return the parts of a space in their order. Raises ValueError for spaces that `Parts` does not support."""
    if not isinstance(space, Dict | Tuple):
        raise ValueError(f"Parts needs a Dict or a Tuple, got {space}")
    parts, first = [], 0
    for keys, leaf in _walk(space, ()):
        part = Part(keys, leaf, first, first, image_shape(leaf))
        if not isinstance(leaf, Box | Discrete | MultiDiscrete | MultiBinary):
            raise ValueError(f"{part.name} must be a Box, Discrete, MultiDiscrete or MultiBinary, got {leaf}")
        first += _size(leaf)
        parts.append(part._replace(last=first))
    return tuple(parts)


def _size(space: Space) -> int:
    """Return the number of entries of a part."""
    if isinstance(space, Discrete):
        return int(space.n)
    return int(space.nvec.sum()) if isinstance(space, MultiDiscrete) else math.prod(space.shape or ())


def _bounds(part: Part) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds of the entries of a part."""
    if isinstance(part.space, Box):
        return part.space.low.ravel(), part.space.high.ravel()
    return np.zeros(part.last - part.first), np.ones(part.last - part.first)


def _is_bytes(space: Space) -> bool:
    """Return whether all values of a part, one-hot ones too, are integers from 0 to 255."""
    return not isinstance(space, Box) or space.dtype in (np.uint8, np.bool_)


def _value(part: Part, observations: Any) -> Any:
    """Return the value under the keys of a part."""
    for key in part.keys:
        try:
            observations = observations[key]
        except (KeyError, IndexError, TypeError):
            has = list(observations) if isinstance(observations, Mapping) else type(observations).__name__
            raise ValueError(f"{part.name} is missing, got {has}") from None
    return observations


def _columns(part: Part, values: np.ndarray) -> np.ndarray:
    """Return the values `[N, ...]` of a part as entries `[N, size]`."""
    shape = part.space.shape or ()
    if values.shape[1:] != shape or not values.ndim:
        raise ValueError(f"{part.name} has shape {values.shape[1:]}, its space has {shape}")
    if isinstance(part.space, Discrete):
        return _one_hot(part, values[:, None], np.array([part.space.n]), np.array([part.space.start]))
    if isinstance(part.space, MultiDiscrete):
        sizes, starts = part.space.nvec.ravel(), part.space.start.ravel()
        return _one_hot(part, values.reshape(len(values), -1), sizes, starts)
    return values.reshape(len(values), -1)


def _one_hot(part: Part, values: np.ndarray, sizes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return integers `[N, K]`, each counted from its start, as one-hot vectors `[N, sum of sizes]`."""
    counted = values - starts
    if values.dtype.kind not in "iu" or (counted < 0).any() or (counted >= sizes).any():
        raise ValueError(f"{part.name} must be in {part.space}, got {values.squeeze().tolist()!r:.100}")
    hot = np.zeros((len(values), int(sizes.sum())), np.uint8)
    hot[np.arange(len(values))[:, None], counted + np.cumsum(sizes) - sizes] = 1
    return hot
