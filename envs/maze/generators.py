"""Test mazes with a new layout in every episode: MiniGrid's FourRooms and SimpleCrossing, and perfect mazes.

Sizes are inner side lengths; MiniGrid and DCD also count the border of walls, two more cells. Read next: `named_mazes`.
"""

from __future__ import annotations

import numpy as np

from regista.envs.maze.grid import DIRECTIONS
from regista.envs.maze.levels import Maze

FOUR_ROOMS_SIDE, CROSSING_SIDE, CROSSINGS = 17, 9, 5


def four_rooms(rng: np.random.Generator) -> Maze:
    """Sample four rooms in a square; each of the four walls between adjacent rooms has a gap.

    Gaps, goal, agent and its direction are uniform (MiniGrid's documentation: "both the agent and the goal square are
    randomly placed in any of the four rooms").
    """
    side, middle = FOUR_ROOMS_SIDE, FOUR_ROOMS_SIDE // 2
    walls = np.zeros((side, side), bool)
    walls[middle], walls[:, middle] = True, True
    low, high = rng.integers(middle, size=2), rng.integers(middle + 1, side, size=2)
    walls[middle, [low[0], high[0]]] = walls[[low[1], high[1]], middle] = False
    return with_ends(walls, rng)


def simple_crossing(rng: np.random.Generator) -> Maze:
    """Sample MiniGrid's SimpleCrossingS11N5: a room with five walls from side to side.

    The walls stand in odd rows and columns. The agent starts at the top left, facing right, and the goal is at the
    bottom right. A path from room to room, down or right in random order, leads from the agent to the goal. Each wall
    has one gap, in a uniform cell next to the room from which the path crosses the wall.
    """
    side = CROSSING_SIDE
    lines = rng.permutation([(axis, place) for axis in (0, 1) for place in range(1, side - 1, 2)])[:CROSSINGS]
    edges = [[-1, *sorted(lines[lines[:, 0] == axis, 1].tolist()), side] for axis in (0, 1)]  # of rooms: rows, columns
    walls = np.zeros((side, side), bool)
    walls[edges[0][1:-1]], walls[:, edges[1][1:-1]] = True, True
    room = [0, 0]
    for axis in rng.permutation(lines[:, 0]).tolist():
        other = 1 - axis
        gap = [0, 0]
        gap[axis] = edges[axis][room[axis] + 1]
        gap[other] = int(rng.integers(edges[other][room[other]] + 1, edges[other][room[other] + 1]))
        walls[tuple(gap)] = False
        room[axis] += 1
    return Maze(walls, (0, 0), (side - 1, side - 1), 0)


def perfect_maze(side: int, rng: np.random.Generator) -> Maze:
    """Sample a maze of S x S cells, S odd, in which exactly one path connects any two cells.

    The cells in even rows and columns are joined along a random spanning tree by Kruskal's algorithm. Agent and goal
    are in two random corners (DCD `envs/multigrid/mst_maze.py`; minimax places them in any two cells).
    """
    walls, nodes = np.ones((side, side), bool), np.arange((side + 1) // 2)
    tree = np.arange(nodes.size**2).reshape(nodes.size, nodes.size)  # the number of the tree that contains each node
    walls[::2, ::2] = False
    right = [(row, column, 0, 1) for row in nodes for column in nodes[:-1]]
    down = [(row, column, 1, 0) for row in nodes[:-1] for column in nodes]
    for row, column, below, beside in rng.permutation(right + down).tolist():
        one, other = tree[row, column], tree[row + below, column + beside]
        if one != other:
            tree[tree == other] = one
            walls[2 * row + below, 2 * column + beside] = False
    corners = [(0, 0), (0, side - 1), (side - 1, 0), (side - 1, side - 1)]
    start, goal = rng.choice(len(corners), 2, replace=False)
    return Maze(walls, corners[start], corners[goal], int(rng.integers(DIRECTIONS)))


def with_ends(walls: np.ndarray, rng: np.random.Generator) -> Maze:
    """Return the maze with these walls, with agent and goal in different, uniformly random empty cells."""
    start, goal = (divmod(int(cell), len(walls)) for cell in rng.choice(np.flatnonzero(~walls), 2, replace=False))
    return Maze(walls, start, goal, int(rng.integers(DIRECTIONS)))
