"""The agents' view: 5 x 5 cells ahead, as in MiniGrid (`MiniGridEnv.gen_obs`).

The view is turned so that the agent looks up from the middle of the lowest row. The cell in column i from the left and
row j from the top has number 5 i + j, the order of MiniGrid's `image[i, j]`. The agent's own cell is shown as empty.

Walls hide nothing in DCD's training mazes (`see_through_walls=True` in `AdversarialEnv`), in JaxUED
(`Maze._get_partial_obs` has no occlusion) and in minimax (`see_through_walls=True`, and False is not implemented).
Otherwise cells behind walls are unseen, by MiniGrid's `Grid.process_vis`.

An observation vector is an image followed by the one-hot direction. In "features" the image has one plane of 0 or 1 for
walls and one for the goal. If walls hide cells in training mazes, a third plane marks the visible cells:
`[25 walls, 25 goal(, 25 seen)]`. In "image" it is MiniGrid's object, color and state of each cell, divided by 10 as in
DCD (`VecPreprocessImageWrapper(scale=10)`). Both are images of 5 x 5 cells: "features" has 2 or 3 planes first, "image"
has 3 channels last.
Read next: `dynamics`.
"""

from __future__ import annotations

from regista.envs.maze.grid import BORDER, DIRECTIONS, EMPTY, GOAL, GREEN, GREY, UNSEEN, VIEW, WALL
from regista.kernels.jit import kernel

CELLS = VIEW * VIEW
CHANNELS = 3  # of an image: object, color, state
IMAGE_SCALE = 10.0
MIDDLE = VIEW // 2
_OWN = VIEW * MIDDLE + VIEW - 1  # the number of the agent's cell
_ALL = (1 << CELLS) - 1


def image_shape(see_through: bool, as_image: bool) -> tuple[int, int, int]:
    """Return the shape of the image at the start of an observation vector; the direction follows the image."""
    return (VIEW, VIEW, CHANNELS) if as_image else (2 if see_through else 3, VIEW, VIEW)


@kernel
def stride(direction, width):
    """Return the offset in the grid between a cell and the next one in a direction."""
    if direction == 0:
        return 1
    if direction == 1:
        return width
    return -1 if direction == 2 else -width


@kernel
def entry(at, ahead, aside, i, j):
    """Return the entry of the grid in column i and row j of a view."""
    return at + (BORDER - j) * ahead + (i - MIDDLE) * aside


@kernel
def visible(grid, at, ahead, aside):
    """Return the cells that walls do not hide, one bit each: light passes sideways and ahead from the nearest row."""
    seen = 1 << _OWN
    for row in range(VIEW):
        j = VIEW - 1 - row
        for i in range(VIEW - 1):
            seen = _light(grid, at, ahead, aside, i, j, 1, seen)
        for k in range(VIEW - 1):
            seen = _light(grid, at, ahead, aside, VIEW - 1 - k, j, -1, seen)
    return seen


@kernel
def _light(grid, at, ahead, aside, i, j, side, seen):
    """Return the visible cells after a cell passes light on: to one side, ahead, and ahead on that side."""
    bit = VIEW * i + j
    if (seen >> bit) & 1 == 0 or grid[entry(at, ahead, aside, i, j)] == WALL:
        return seen
    neighbor = bit + side * VIEW
    seen |= 1 << neighbor
    if j > 0:
        seen |= (1 << (neighbor - 1)) | (1 << (bit - 1))
    return seen


@kernel
def thing_at(grid, at, ahead, aside, i, j, seen):
    """Return the content of column i and row j of a view: UNSEEN, EMPTY, WALL or GOAL."""
    bit = VIEW * i + j
    if (seen >> bit) & 1 == 0:
        return UNSEEN
    if bit == _OWN:
        return EMPTY
    return int(grid[entry(at, ahead, aside, i, j)])


@kernel
def look(grid, at, direction, settings):
    """Return the strides ahead and to the right of an agent, and the cells that it sees, one bit each."""
    ahead, aside = stride(direction, settings.width), stride((direction + 1) % DIRECTIONS, settings.width)
    return ahead, aside, _ALL if settings.see_through else visible(grid, at, ahead, aside)


@kernel
def write_image(layouts, agents, settings, e, image):
    """Write MiniGrid's image of environment e, `[75]`: object, color and state of each cell."""
    grid, at = layouts.grid[e], agents.at[e]
    ahead, aside, seen = look(grid, at, agents.direction[e], settings)
    for i in range(VIEW):
        for j in range(VIEW):
            thing, k = thing_at(grid, at, ahead, aside, i, j, seen), CHANNELS * (VIEW * i + j)
            image[k] = thing
            image[k + 1] = GREY if thing == WALL else GREEN if thing == GOAL else 0
            image[k + 2] = 0


@kernel
def write_features(layouts, agents, settings, e, row):
    """Write the features of environment e, `[F]`, without the direction; with 3 planes also the visible cells."""
    grid, at = layouts.grid[e], agents.at[e]
    ahead, aside, seen = look(grid, at, agents.direction[e], settings)
    for i in range(VIEW):
        for j in range(VIEW):
            thing, k = thing_at(grid, at, ahead, aside, i, j, seen), VIEW * i + j
            row[k] = 1.0 if thing == WALL else 0.0
            row[CELLS + k] = 1.0 if thing == GOAL else 0.0
            if len(row) > 2 * CELLS + DIRECTIONS:
                row[2 * CELLS + k] = 0.0 if thing == UNSEEN else 1.0


@kernel
def observe(layouts, agents, settings, e, row):
    """Write the observation vector of environment e, `[F]` float32."""
    if settings.as_image:
        write_image(layouts, agents, settings, e, row)
        for k in range(CHANNELS * CELLS):
            row[k] /= IMAGE_SCALE
    else:
        write_features(layouts, agents, settings, e, row)
    last = len(row) - DIRECTIONS
    for direction in range(DIRECTIONS):
        row[last + direction] = 1.0 if direction == agents.direction[e] else 0.0


@kernel
def observe_all(layouts, agents, settings, vectors):
    """Write the observation vectors `[N, F]` float32."""
    for e in range(len(vectors)):
        observe(layouts, agents, settings, e, vectors[e])


@kernel
def write_images(layouts, agents, settings, images):
    """Write MiniGrid's images, `[N, 75]` uint8."""
    for e in range(len(images)):
        write_image(layouts, agents, settings, e, images[e])
