"""Shortest paths: the number of steps, turns included, from each cell and direction to the goal.

Read next: `shortest_path`, a policy that follows them.
"""

from __future__ import annotations

import numpy as np

from regista.envs.maze.grid import DIRECTIONS, FORWARD, GOAL, LEFT, RIGHT, WALL, Layouts
from regista.envs.maze.view import stride
from regista.kernels.jit import kernel

UNREACHABLE = -1


@kernel
def steps_to_goal(grid, width, steps, queue):
    """Write the number of steps to the goal from each entry of a grid `[W * W]`, for each direction.

    `steps` `[W * W, 4]` int64 is UNREACHABLE without a path. A breadth-first search runs backwards from the goal;
    `queue` `[4 W * W]` int64 is its working memory.
    """
    steps[:] = UNREACHABLE
    first, last = 0, 0
    for at in range(len(grid)):
        if grid[at] == GOAL:
            for direction in range(DIRECTIONS):
                steps[at, direction] = 0
                queue[last] = DIRECTIONS * at + direction
                last += 1
    while first < last:
        at, direction = queue[first] // DIRECTIONS, queue[first] % DIRECTIONS
        first += 1
        for action in (LEFT, RIGHT, FORWARD):
            before, faced = at, direction
            if action == FORWARD:
                before = at - stride(direction, width)
            else:
                faced = (direction + (1 if action == LEFT else DIRECTIONS - 1)) % DIRECTIONS
            if grid[before] != WALL and steps[before, faced] == UNREACHABLE:
                steps[before, faced] = steps[at, direction] + 1
                queue[last] = DIRECTIONS * before + faced
                last += 1


@kernel
def choose_shortest(agents, steps, width, actions):
    """Write an action `[N]` for each environment that shortens the path to the goal; without a path, a left turn."""
    for e in range(len(actions)):
        at, direction, best = agents.at[e], agents.direction[e], LEFT
        left, right = (direction + DIRECTIONS - 1) % DIRECTIONS, (direction + 1) % DIRECTIONS
        least = steps[e, at, left]
        if steps[e, at, right] < least:
            best, least = RIGHT, steps[e, at, right]
        ahead = steps[e, at + stride(direction, width), direction]
        if ahead != UNREACHABLE and ahead < least:
            best = FORWARD
        actions[e] = best


def path_lengths(layouts: Layouts, width: int) -> list[int]:
    """Return the number of steps from start to goal of each maze; UNREACHABLE without a path."""
    entries = layouts.grid.shape[1]
    steps, queue = np.empty((entries, DIRECTIONS), np.int64), np.empty(DIRECTIONS * entries, np.int64)
    lengths = []
    for grid, start, direction in zip(layouts.grid, layouts.start, layouts.direction, strict=True):
        steps_to_goal(grid, width, steps, queue)
        lengths.append(int(steps[start, direction]))
    return lengths
