"""The `smm` observation: Google Research Football's super mini map. It has planes of 72 × 96 pixels for our team, the
other team, the ball and the agent's player; 255 marks a position. `smm_stacked` has the planes of the last four steps,
oldest first.

With `pixels = "sparse"`, an observation is the coordinates of the marks instead, see `ued.core.sparse_image`.

Each match stores only the positions of the last four steps, which every observation draws. This takes a few hundred
bytes instead of 110,592, and drawing writes only a few pixels into zeroed planes.
Read next: `observation.observer`.
"""

from __future__ import annotations

import math

import numpy as np

from regista.envs.football.constants import LEFT, MAX_PLAYERS, NOBODY
from regista.envs.football.observation.units import UNIT_X, UNIT_Y
from regista.kernels.jit import kernel

HEIGHT, WIDTH = 72, 96  # pixels
FRAMES = 4  # number of stored frames
CHANNELS = 4  # planes of a frame: our team, the other team, the ball, the agent's player
MARKS = MAX_PLAYERS + 2  # maximum marks in a frame: all players, the ball, the agent's player
HALF_HEIGHT = 1.0 / 2.25  # in GRF's units, from the middle to the upper and to the lower edge


def empty_history(count: int, players: int, agents: int) -> tuple[np.ndarray, np.ndarray]:
    """Allocate the stored positions of `count` matches; the frame after t steps is in slot t modulo FRAMES.

    Positions `[N, FRAMES, P + 1, 2]` are x and y in GRF's units, the ball last; `[N, FRAMES, A]` are the agents'
    players.
    """
    return np.zeros((count, FRAMES, players + 1, 2)), np.zeros((count, FRAMES, agents), np.int64)


@kernel
def remember(match, places, agents):
    """Store all positions after this step; at the start of an episode they fill all frames."""
    if match.step == 0:
        for slot in range(FRAMES):
            _note(match, places[slot], agents[slot])
    else:
        slot = match.step % FRAMES
        _note(match, places[slot], agents[slot])


@kernel
def _note(match, places, agents):
    for i in range(match.num_players):
        player = match.players[i]
        places[i, 0] = math.nan if player.has_left else player.x / UNIT_X
        places[i, 1] = player.y / UNIT_Y
    places[match.num_players, 0] = match.ball.x / UNIT_X
    places[match.num_players, 1] = match.ball.y / UNIT_Y
    for agent in range(len(agents)):
        agents[agent] = match.agents[agent]


@kernel
def write_planes(match, agent, places, agents, planes):
    """Draw the last frames, as an agent sees them, into zeroed `planes` `[72, 96, C]` uint8; C is 4 or 16."""
    _draw(match, agent, places, agents, planes.shape[2] // CHANNELS, planes)


@kernel
def write_pixels(match, agent, places, agents, pixels):
    """Write the coordinates of the marks in the planes into `pixels` `[K, 3]` uint8; K is MARKS times the frames.

    Each mark occurs once, in the order of the planes in memory; unused rows are (HEIGHT, 0, 0).
    """
    for k in range(len(pixels)):
        pixels[k, 0], pixels[k, 1], pixels[k, 2] = HEIGHT, 0, 0
    _draw(match, agent, places, agents, len(pixels) // MARKS, pixels)


@kernel
def _draw(match, agent, places, agents, frames, seen):
    """Mark the positions of the last frames in planes or in a list of pixels."""
    us = 0 if agent < match.num_agents[LEFT] else 1
    side = 1.0 if us == LEFT else -1.0  # the right team sees the pitch rotated by 180°
    for frame in range(frames):
        slot = (match.step + 1 + frame - frames) % FRAMES
        channel = CHANNELS * frame
        for i in range(match.num_players):
            theirs = 0 if match.players[i].team == us else 1
            _mark(seen, channel + theirs, side * places[slot, i, 0], side * places[slot, i, 1])
        ball, me = match.num_players, agents[slot, agent]
        _mark(seen, channel + 2, side * places[slot, ball, 0], side * places[slot, ball, 1])
        if me != NOBODY:
            _mark(seen, channel + 3, side * places[slot, me, 0], side * places[slot, me, 1])


@kernel
def _mark(seen, channel, x, y):
    """Mark the pixel at (x, y); a point beyond the edge is drawn on the edge."""
    if math.isnan(x):
        return  # sent off
    column = int((x + 1.0) / 2.0 * WIDTH)
    row = int((y + HALF_HEIGHT) / (2.0 * HALF_HEIGHT) * HEIGHT)
    row, column = min(max(row, 0), HEIGHT - 1), min(max(column, 0), WIDTH - 1)
    if seen.ndim == 3:
        seen[row, column, channel] = 255
    else:
        _insert(seen, row, column, channel)


@kernel
def _insert(pixels, row, column, channel):
    """Insert a pixel into ascending `pixels` `[K, 3]`, unless they contain it."""
    for k in range(len(pixels)):
        other = int(pixels[k, 0]), int(pixels[k, 1]), int(pixels[k, 2])
        if other == (row, column, channel):
            return
        if other > (row, column, channel):
            pixels[k, 0], pixels[k, 1], pixels[k, 2] = row, column, channel
            row, column, channel = other  # the rest moves down
            if row == HEIGHT:
                return  # an unused row
