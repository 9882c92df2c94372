"""Write the observations of one match: dispatch to the kernel of the representation.

Read next: `batch`, which calls this after each step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from regista.envs.football.config import REPRESENTATIONS
from regista.envs.football.control.agents import num_agents
from regista.envs.football.observation.features import write_features
from regista.envs.football.observation.simple115 import write_simple115
from regista.envs.football.observation.smm import remember, write_pixels, write_planes
from regista.kernels.jit import kernel

FEATURES, SIMPLE115, SMM, SMM_STACKED, RAW = range(len(REPRESENTATIONS))


class View(NamedTuple):
    """The arrays into which kernels write the observations of N matches; at most one of them has entries."""

    vectors: np.ndarray  # [N, A, F] float32
    planes: np.ndarray  # [N, A, 72, 96, C] uint8
    pixels: np.ndarray  # [N, A, K, 3] uint8, coordinates of the pixels that are set in the planes, see `SparseImage`


@kernel(inline=True)
def observe(batch, index, view, kind):
    """Write the agents' observations of match number `index`."""
    match = batch.matches[index]
    for agent in range(num_agents(match)):
        if kind == FEATURES:
            write_features(match, agent, view.vectors[index, agent])
        elif kind == SIMPLE115:
            write_simple115(match, agent, view.vectors[index, agent])
        elif kind != RAW:
            places, agents = batch.minimap_places[index], batch.minimap_agents[index]
            if len(view.pixels):
                write_pixels(match, agent, places, agents, view.pixels[index, agent])
            else:
                write_planes(match, agent, places, agents, view.planes[index, agent])


@kernel(inline=True)
def remember_minimap(batch, index, kind):
    """Store the positions that later observations of match number `index` need."""
    if kind in (SMM, SMM_STACKED):
        remember(batch.matches[index], batch.minimap_places[index], batch.minimap_agents[index])
