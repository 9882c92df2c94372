"""The benchmark's test mazes under their published names, with what their sources say and where ours may differ.

Sources: PAIRED is Dennis et al. 2020 (appendix, test environments), PLR⊥ Jiang et al. 2021, ACCEL Parker-Holder et al.
2022, MiniGrid Chevalier-Boisvert et al. 2023 and its documentation. Layouts follow the descriptions and pictures in
these papers and are not copied cell by cell: success rates are comparable with published ones in kind, not to the
percent.

The agent faces a uniform direction in each episode; start and goal of a layout are fixed unless its row says otherwise.
Time limits are DCD's 2 n^2 steps for a grid of n x n with its border ("over 5k steps" for n = 51 in ACCEL), and
MiniGrid's own for FourRooms and SimpleCrossing. JaxUED allows 250 steps in all of its test mazes. Limits, directions
and what varies from episode to episode follow the papers; they were not compared with DCD's code.
Read next: `drawings` and `generators`, the layouts; `task`, which tests students on them.
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
MEDIUM, LARGE = 17, 49  # inner sides of DCD's 19 x 19 and 51 x 51


class NamedMaze(NamedTuple):
    """One of the benchmark's test mazes.

    Attributes:
        draw: samples the maze of an episode.
        side: its inner side S.
        max_steps: its time limit.
        about: what its source describes, and where ours differs.
    """

    draw: DrawMaze
    side: int
    max_steps: int
    about: str

    def make(self, num_envs: int, config: MazeConfig = MazeConfig()) -> DrawnMazes:  # noqa: B008 (frozen)
        """Make N environments of this maze, seen as `config` says, that can be drawn."""
        own = replace(config, side=self.side, max_steps=self.max_steps)
        return DrawnMazes(num_envs, self.draw, own, "rgb_array")


class DrawnMazes(Mazes):
    """Mazes whose random levels are those of `draw`, a function of a random stream, instead of random walls."""

    def __init__(self, num_envs: int, draw: DrawMaze, config: MazeConfig, render_mode: str | None = None) -> None:
        super().__init__(num_envs, config, render_mode)
        self.draw_maze = draw

    def _draw(self, count: int) -> np.ndarray:
        return np.stack([self.theta_of(self.draw_maze(self._stream)) for _ in range(count)])


def sample_drawing(drawing: str, rng: np.random.Generator) -> Maze:
    """Sample one of the mazes of a drawing: its goal at one of the places `G`, its agent facing any direction."""
    goals = [place for place, mark in enumerate(drawing) if mark == "G"]
    text = list(drawing.replace("G", ".").replace("S", ARROWS[rng.integers(DIRECTIONS)]))
    text[goals[rng.integers(len(goals))]] = "G"
    return maze_from("".join(text))


def time_limit(side: int) -> int:
    """Return DCD's limit in steps for S x S cells inside a border: 2 n^2, n = S + 2."""
    return 2 * (side + 2) ** 2


def _drawn(drawing: str, about: str) -> NamedMaze:
    side = len(drawing.split())
    return NamedMaze(partial(sample_drawing, drawing), side, time_limit(side), about)


def _perfect(side: int, about: str) -> NamedMaze:
    return NamedMaze(partial(perfect_maze, side), side, time_limit(side), about)


TEST_MAZES = {
    "SixteenRooms": _drawn(
        drawings.SIXTEEN_ROOMS,
        "PAIRED: 4 x 4 rooms, doors between all neighbors, start and goal in opposite corners. Ours: one door of one "
        "cell in each of the 24 walls between rooms, in places of our own",
    ),
    "SixteenRoomsFewerDoors": _drawn(
        drawings.SIXTEEN_ROOMS_FEWER_DOORS,
        "ACCEL: the sixteen rooms with fewer doors. Ours: 18 of the 24 doors, our choice; every room can be reached",
    ),
    "Labyrinth": _drawn(
        drawings.LABYRINTH,
        "PAIRED: rings of walls around a goal in the center. Ours: three rings with one opening each and a bar across "
        "the ways around, so that the shortest way leads nearly once around",
    ),
    "Labyrinth2": _drawn(
        drawings.LABYRINTH_2,
        "PAIRED: another labyrinth, entered from another corner. Ours: openings on alternate sides, bars at the top "
        "and the bottom",
    ),
    "Maze": _drawn(
        drawings.MAZE,
        "PAIRED: corridors one cell wide with dead ends. Ours: a perfect maze with start and goal in opposite corners",
    ),
    "Maze2": _drawn(drawings.MAZE_2, "PLR⊥: a second such maze. Ours: another perfect maze, with a longer way"),
    "Maze3": _drawn(drawings.MAZE_3, "ACCEL: a third such maze. Ours: a perfect maze with its goal in the center"),
    "SmallCorridor": _drawn(
        drawings.SMALL_CORRIDOR,
        "PLR⊥: a corridor with dead ends on both sides; the goal lies at the end of a random one. Ours: 12 dead ends "
        "of 6 cells, one of 12 goals in each episode",
    ),
    "LargeCorridor": _drawn(
        drawings.LARGE_CORRIDOR,
        "PLR⊥: a larger corridor, 19 x 19 with its border. Ours: 16 dead ends of 8 cells, one of 16 goals in each "
        "episode",
    ),
    "FourRooms": NamedMaze(
        four_rooms,
        FOUR_ROOMS_SIDE,
        100,
        "MiniGrid FourRooms, 19 x 19 with its border, 100 steps: gaps, goal and agent are new in each episode",
    ),
    "SimpleCrossing": NamedMaze(
        simple_crossing,
        CROSSING_SIDE,
        4 * (CROSSING_SIDE + 2) ** 2,
        "MiniGrid SimpleCrossingS11N5, 11 x 11 with its border, 484 steps: five walls and their gaps are new in each "
        "episode, the agent faces right",
    ),
    "PerfectMazeMedium": _perfect(
        MEDIUM,
        "ACCEL: perfect mazes of 19 x 19 with the border. New in each episode: walls by a randomized depth-first "
        "search, start and goal uniform",
    ),
}
LARGE_MAZES = {
    "PerfectMazeLarge": _perfect(LARGE, "ACCEL: perfect mazes of 51 x 51 with the border, otherwise as the medium one")
}
