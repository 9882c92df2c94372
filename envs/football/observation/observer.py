"""The representations of observations: names, spaces, and the arrays that `observe` writes.

    features       a vector for small networks, sized to the program's players     [F] float32      `features`
    simple115      GRF's vector                                                    [115] float32    `simple115`
    smm            GRF's planes                                                    [72, 96, 4] uint8    `smm`
    smm_stacked    the planes of the last four steps, oldest first                 [72, 96, 16] uint8   `smm`
                   both also as the coordinates of the marks, `SparseImage`        [24 or 96, 3] uint8  `smm`
    raw            GRF's dict                                                                       `raw`

With one agent, observations have no agent axis; with several, they have one, and `raw` is a tuple of dicts.
Read next: `observation.observe`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space, Tuple
from gymnasium.vector.utils import batch_space

from regista.envs.football.config import REPRESENTATIONS
from regista.envs.football.constants import LEFT
from regista.envs.football.observation.features import LIMIT, features_size
from regista.envs.football.observation.observe import FEATURES, RAW, SIMPLE115, SMM, SMM_STACKED, View
from regista.envs.football.observation.raw import raw_observation, raw_space
from regista.envs.football.observation.simple115 import SIZE, simple115_unit
from regista.envs.football.observation.smm import CHANNELS, FRAMES, HEIGHT, MARKS, WIDTH, empty_history
from regista.envs.football.scenic.lineup import Lineup
from ued.core.sparse_image import SparseImage

NO_PIXELS = (0, 0, 0, 3)  # shape of the pixels of observations that have none


class Observer:
    """One representation for the matches of one line-up; with `sparse`, planes are the coordinates of their marks.

    Attributes:
        kind: the number of the representation, for kernels.
        space: the space of one environment's observation.
    """

    def __init__(self, representation: str, lineup: Lineup, sparse: bool = False) -> None:
        self.kind = REPRESENTATIONS.index(representation)
        self._sparse = sparse and self.kind in (SMM, SMM_STACKED)
        self._players, self._agents = lineup.num_players, sum(lineup.num_agents)
        left = int(np.count_nonzero(np.asarray(lineup.roster.teams) == LEFT))
        self._sizes = left, lineup.num_players - left
        self._rights = [agent >= lineup.num_agents[LEFT] for agent in range(self._agents)]
        self._shape: tuple[int, ...] = () if self.kind == RAW else tuple(self._space().shape)
        if self.kind == RAW:
            spaces = [raw_space(*(self._sizes[::-1] if right else self._sizes)) for right in self._rights]
            self.space: Space = spaces[0] if self._agents == 1 else Tuple(spaces)
        else:
            space = self._space()
            if isinstance(space, SparseImage):
                self.space = SparseImage(space.image, space.most, self._agents)
            else:
                self.space = space if self._agents == 1 else batch_space(space, self._agents)

    def _space(self) -> Box:
        """Return the space of one agent's array."""
        if self.kind == FEATURES:
            return Box(-LIMIT, LIMIT, (features_size(self._players),), np.float32)
        if self.kind == SIMPLE115:
            return Box(-np.inf, np.inf, (SIZE,), np.float32)
        frames = FRAMES if self.kind == SMM_STACKED else 1
        planes = Box(0, 255, (HEIGHT, WIDTH, CHANNELS * frames), np.uint8)
        return SparseImage(planes, MARKS * frames) if self._sparse else planes

    @property
    def unit(self) -> np.ndarray | None:
        """The size of a large change of each entry of one agent's vector; see `UPOMDP.observation_scale`."""
        if self.kind not in (FEATURES, SIMPLE115):
            return None
        return simple115_unit() if self.kind == SIMPLE115 else np.ones(features_size(self._players))

    def allocate(self, count: int) -> View:
        """Allocate zeroed arrays for `count` matches; new ones each time, so kernels need not clear them."""
        shape = (count, self._agents)
        if self.kind in (FEATURES, SIMPLE115, RAW):
            return self.view_of(np.zeros((*shape, *(self._shape or (0,))), np.float32))
        pixels = np.zeros((*shape, *self._shape) if self._sparse else NO_PIXELS, np.uint8)
        planes = np.zeros((*shape, *((0, 0, 0) if self._sparse else self._shape)), np.uint8)
        return View(np.zeros((*shape, 0), np.float32), planes, pixels)

    def view_of(self, vectors: np.ndarray) -> View:
        """Return the view of these vectors `[N, A, F]`, without planes."""
        return View(vectors, np.zeros((*vectors.shape[:2], 0, 0, 0), np.uint8), np.zeros(NO_PIXELS, np.uint8))

    def minimap_history(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Allocate the minimap history of `count` matches, see `smm`."""
        return empty_history(count if self.kind in (SMM, SMM_STACKED) else 0, self._players, self._agents)

    def read(self, view: View, matches: np.ndarray) -> Any:
        """Return the observations `[N, ...]`, from the arrays in `view` or, for `raw`, from matches MATCH `[N]`."""
        if self.kind == RAW:
            dicts = [raw_observation(matches, agent, self._sizes, right) for agent, right in enumerate(self._rights)]
            return dicts[0] if self._agents == 1 else tuple(dicts)
        planes = view.pixels if self._sparse else view.planes
        rows = view.vectors if self.kind in (FEATURES, SIMPLE115) else planes
        return rows[:, 0] if self._agents == 1 else rows
