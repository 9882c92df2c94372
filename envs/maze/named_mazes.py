"""The benchmark's test mazes under their published names, as DCD plays them.

| | layout | start, goal | steps | seen |
|---|---|---|---|---|
| rooms, labyrinths, mazes | one each (`drawings`) | fixed | 2 n^2 | through walls |
| corridors | one each (`drawings`) | goal in one of 10 or 16 dead ends | 2 n^2 | through walls |
| perfect mazes | new (`generators`) | two random corners | 2 n^2 | through walls |
| FourRooms | new (`generators`) | random | 100 | up to walls |
| SimpleCrossing | new (`generators`) | fixed | 4 n^2 | up to walls |

n is the side of the grid with its border, so 2 n^2 is 450 for 15 x 15. The agent faces a uniform direction, right in
SimpleCrossing. All of this is in DCD's `envs/multigrid/{maze,mst_maze,crossing,fourrooms}.py`. minimax plays the same
layouts, with fixed directions in some. JaxUED allows 250 steps. In both minimax and JaxUED, agents see through the
walls of all mazes.

Sources: PAIRED is Dennis et al. 2020, PLR⊥ Jiang et al. 2021, ACCEL Parker-Holder et al. 2022, MiniGrid
Chevalier-Boisvert et al. 2023. Read next: `drawings`, `generators`; `task`, which evaluates students on them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from regista.envs.maze import drawings
from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.envs.maze.generators import (
    CROSSING_SIDE,
    FOUR_ROOMS_SIDE,
    four_rooms,
    perfect_maze,
    simple_crossing,
)
from regista.envs.maze.grid import DIRECTIONS
from regista.envs.maze.levels import ARROWS, Maze, maze_from

DrawMaze = Callable[[np.random.Generator], Maze]
MEDIUM, LARGE = 19, 49  # inner sides of DCD's 21 x 21 and 51 x 51


class NamedMaze(NamedTuple):
    """One of the benchmark's test mazes.

    Attributes:
        draw: the function that samples the maze of an episode.
        side: its inner side S.
        max_steps: its time limit.
        about: its description and source.
        see_through: whether agents see through walls; they never do if they do not in training.
    """

    draw: DrawMaze
    side: int
    max_steps: int
    about: str
    see_through: bool = True

    def make(self, num_envs: int, config: MazeConfig = MazeConfig()) -> DrawnMazes:  # noqa: B008 (frozen)
        """Make N environments of this maze that can be rendered, with the observations of `config`."""
        own = replace(config, side=self.side, max_steps=self.max_steps)
        return DrawnMazes(num_envs, self.draw, own, self.see_through, "rgb_array")


class DrawnMazes(Mazes):
    """Mazes whose random levels are sampled by `draw`, a function of a random generator, instead of random walls.

    With `see_through=False`, walls hide cells. Hidden cells look empty in features, and unseen in images.
    """

    def __init__(
        self,
        num_envs: int,
        draw: DrawMaze,
        config: MazeConfig,
        see_through: bool = True,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(num_envs, config, render_mode)
        self.draw_maze = draw
        self._settings = self._settings._replace(see_through=bool(config.see_through and see_through))

    def _draw(self, count: int) -> np.ndarray:
        return np.stack([self.theta_of(self.draw_maze(self._stream)) for _ in range(count)])


def sample_drawing(drawing: str, rng: np.random.Generator) -> Maze:
    """Sample one of the mazes of a drawing: the goal at one of the cells `G`, the agent facing a uniform direction."""
    goals = [place for place, mark in enumerate(drawing) if mark == "G"]
    text = list(drawing.replace("G", ".").replace("S", ARROWS[rng.integers(DIRECTIONS)]))
    text[goals[rng.integers(len(goals))]] = "G"
    return maze_from("".join(text))


def time_limit(side: int) -> int:
    """Return DCD's time limit in steps for S x S cells inside a border: 2 n^2, n = S + 2."""
    return 2 * (side + 2) ** 2


def _drawn(drawing: str, about: str) -> NamedMaze:
    side = len(drawing.split())
    return NamedMaze(partial(sample_drawing, drawing), side, time_limit(side), about)


def _perfect(side: int, about: str) -> NamedMaze:
    return NamedMaze(partial(perfect_maze, side), side, time_limit(side), about)


TEST_MAZES = {
    "SixteenRooms": _drawn(drawings.SIXTEEN_ROOMS, "PAIRED: 4 x 4 rooms; start and goal in opposite ones"),
    "SixteenRoomsFewerDoors": _drawn(drawings.SIXTEEN_ROOMS_FEWER_DOORS, "PAIRED: 4 x 4 rooms with fewer doors"),
    "Labyrinth": _drawn(drawings.LABYRINTH, "PAIRED: three rings of walls around the goal"),
    "Labyrinth2": _drawn(drawings.LABYRINTH_2, "PLR⊥: three rings of walls, entered from another corner"),
    "Maze": _drawn(drawings.MAZE, "PAIRED: corridors one cell wide"),
    "Maze2": _drawn(drawings.MAZE_2, "PLR⊥: another maze of corridors"),
    "Maze3": _drawn(drawings.MAZE_3, "ACCEL: another maze of corridors"),
    "SmallCorridor": _drawn(
        drawings.SMALL_CORRIDOR, "PLR⊥: a wall with ten dead ends along both sides; the goal is in a random one"
    ),
    "LargeCorridor": _drawn(
        drawings.LARGE_CORRIDOR, "PLR⊥: 21 x 21 with its border, 16 dead ends; the goal is in a random one"
    ),
    "FourRooms": NamedMaze(
        four_rooms, FOUR_ROOMS_SIDE, 100, "MiniGrid FourRooms, 19 x 19 with its border", see_through=False
    ),
    "SimpleCrossing": NamedMaze(
        simple_crossing,
        CROSSING_SIDE,
        4 * (CROSSING_SIDE + 2) ** 2,
        "MiniGrid SimpleCrossingS11N5, 11 x 11 with its border: five walls to pass",
        see_through=False,
    ),
    "PerfectMazeMedium": _perfect(MEDIUM, "ACCEL: perfect mazes, 21 x 21 with their border"),
}
LARGE_MAZES = {"PerfectMazeLarge": _perfect(LARGE, "ACCEL: perfect mazes, 51 x 51 with their border")}
