"""A picture of a simulation from above, for recordings: objects as rectangles, the agent in red, a grid of 10 m.

Read next: `episode`, whose `Role` may draw its own picture.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scenic.core.simulators import Simulation

HEIGHT, WIDTH = 160, 320  # pixels
REACH = 40.0  # meters to the left and to the right
GROUND, GRID, AGENT, OTHER = (235, 235, 230), (210, 210, 205), (200, 60, 50), (60, 90, 160)


def top_view(simulation: Simulation, agent: Any) -> np.ndarray:
    """Return a picture with the agent in its center: uint8 `[HEIGHT, WIDTH, 3]`."""
    x, y = np.meshgrid(np.linspace(-REACH, REACH, WIDTH), np.linspace(REACH, -REACH, WIDTH)[:HEIGHT] - REACH / 2)
    pixel = 2 * REACH / WIDTH
    picture = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
    picture[((x + agent.position.x) % 10 < pixel) | ((y + agent.position.y) % 10 < pixel)] = GRID
    for thing in simulation.objects:
        right, up = x + agent.position.x - thing.position.x, y + agent.position.y - thing.position.y
        ahead = -np.sin(thing.heading) * right + np.cos(thing.heading) * up
        aside = np.cos(thing.heading) * right + np.sin(thing.heading) * up
        inside = (abs(ahead) <= max(thing.length, pixel) / 2) & (abs(aside) <= max(thing.width, pixel) / 2)
        picture[inside] = AGENT if thing is agent else OTHER
    return picture
