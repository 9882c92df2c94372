"""Observations of Gymnasium's environments in the forms that students support: vectors and images.

Read next: `core.parts`, vectors with images in them.
"""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Tuple

from ued.core.parts import Parts, has_images


def as_array(env: gymnasium.Env) -> gymnasium.Env:
    """Return an environment whose observations are vectors or images; other observations are flattened.

    Vectors of a `Dict` or `Tuple` with images have the space `core.parts.Parts`. Gray images get an axis of one
    channel. Raises `ValueError` for observations without a fixed size.
    """
    space = env.observation_space
    if isinstance(space, Box) and len(space.shape) in (1, 3):
        return env
    if isinstance(space, Box) and len(space.shape) == 2 and space.dtype == np.uint8:
        return gymnasium.wrappers.ReshapeObservation(env, (*space.shape, 1))
    parts = {f"observations[{name!r}]": part for name, part in space.items()} if isinstance(space, Dict) else {}
    for name, part in (parts or {"observations": space}).items():
        if not has_fixed_size(part):
            kept = [key for key, other in space.items() if has_fixed_size(other)] if isinstance(space, Dict) else []
            without = f", such as in gymnasium.wrappers.FilterObservation(env, {kept})" if kept else ""
            raise ValueError(
                f"{name} must have a fixed size, got {part}; wrap the environment so that they have{without}"
            )
    if has_images(space):
        try:
            return _PartsObservation(env)
        except ValueError as error:
            warnings.warn(f"images are flattened, so no convolutions read them: {error}", stacklevel=2)
    return gymnasium.wrappers.FlattenObservation(env)


def in_form(env: gymnasium.Env, observation: Any) -> Any:
    """Return an observation in the form of `as_array(env)`, converting it unless it already has this form."""
    if isinstance(env, gymnasium.ObservationWrapper) and np.shape(observation) != env.observation_space.shape:
        return env.observation(observation)
    return observation


class _PartsObservation(gymnasium.ObservationWrapper):
    """Flatten a `Dict` or `Tuple` with images into vectors of the space `Parts`."""

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        space = env.observation_space
        assert isinstance(space, Dict | Tuple)
        self.observation_space = self._parts = Parts(space)

    def observation(self, observation: Any) -> np.ndarray:
        return self._parts.flatten(observation)


def has_fixed_size(space: gymnasium.Space) -> bool:
    """Return whether values of a space can be written as a vector; False if the space does not define this."""
    try:
        return space.is_np_flattenable
    except NotImplementedError:
        return False
