"""Drawings of football: the lines of the pitch and the positions of players, in meters with +y up.

`FootballPainter` describes a level to a recorder or a plot; `draw_pitch` and `draw_scene` draw with Matplotlib, which
is imported when they are called. Read next: `scenic.lineup`, which gives the positions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from regista.envs.football.constants import (
    BOX_DEPTH,
    BOX_HALF_WIDTH,
    GK,
    GOAL_HALF_WIDTH,
    HALF_LENGTH,
    HALF_WIDTH,
    LEFT,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from regista.envs.football.scenic.lineup import Lineup

Color = tuple[int, int, int]

LEFT_COLOR: Color = (66, 165, 245)
RIGHT_COLOR: Color = (239, 83, 80)
LEFT_KEEPER_COLOR: Color = (128, 203, 196)
RIGHT_KEEPER_COLOR: Color = (255, 202, 40)
BALL_COLOR: Color = (255, 255, 255)
GRASS: Color = (24, 58, 36)
CHALK: Color = (214, 226, 214)

# Markers: name, color, radius in meters, larger than life. The classes of `FootballPainter` are indices into it.
MARKERS = (
    ("left team", LEFT_COLOR, 1.1),
    ("left keeper", LEFT_KEEPER_COLOR, 1.1),
    ("right team", RIGHT_COLOR, 1.1),
    ("right keeper", RIGHT_KEEPER_COLOR, 1.1),
    ("ball", BALL_COLOR, 0.7),
)
LEFT_PLAYER, LEFT_KEEPER, RIGHT_PLAYER, RIGHT_KEEPER, BALL = range(5)

# Markings for pictures only
CIRCLE_RADIUS = 9.15  # m
GOAL_AREA_DEPTH = 5.5  # m
GOAL_AREA_HALF_WIDTH = 9.16  # m
PENALTY_SPOT = 11.0  # m, from the goal line
GOAL_DEPTH = 2.2  # m
MARGIN = 3.0  # m of grass around the pitch


class HasMatches(Protocol):
    """An environment of football matches."""

    @property
    def matches(self) -> np.ndarray:
        """The current matches, MATCH `[N]`."""


class FootballPainter:
    """Describes how to draw the levels of one football program: a `ued.recorder.layout.ScenePainter`.

    Attributes:
        classes: `[K]` the class of each point, an index into `MARKERS`; the P players in the order of the match, then
            the ball, so K = P + 1.
        focus: the point that represents a level: the program's ego.
        bounds: x low, x high, y low, y high in meters: the relevant part of the right half if everybody except the left
            keeper starts there, else the whole pitch.
        reach: the whole pitch in the same format.
    """

    background = GRASS
    line_color = CHALK
    markers: Sequence[tuple[str, Color, float]] = MARKERS
    reach = (-HALF_LENGTH - MARGIN, HALF_LENGTH + MARGIN, -HALF_WIDTH - MARGIN, HALF_WIDTH + MARGIN)

    def __init__(self, lineup: Lineup) -> None:
        self._lineup = lineup
        teams, roles = np.asarray(lineup.roster.teams), np.asarray(lineup.roster.roles)
        classes = np.where(teams == LEFT, LEFT_PLAYER, RIGHT_PLAYER) + (roles == GK)
        self.classes = np.append(classes, BALL)
        ego = np.flatnonzero(lineup.players == 0)
        self.focus = int(ego[0]) if len(ego) else len(classes)
        dim = lineup.program.dim
        corners = np.vstack([np.zeros((1, dim)), np.eye(dim), -np.eye(dim)])
        field = self.positions(corners)[:, self.classes != LEFT_KEEPER]
        if (field[..., 0] >= 0).all():
            reach = min(max(np.abs(field[..., 1]).max(), BOX_HALF_WIDTH) + 2 * MARGIN, HALF_WIDTH + MARGIN)
            self.bounds = (-MARGIN, HALF_LENGTH + MARGIN, -reach, reach)
        else:
            self.bounds = self.reach

    def lines(self) -> list[np.ndarray]:
        """Return the markings of the pitch."""
        return pitch_lines()

    def positions(self, theta: np.ndarray) -> np.ndarray:
        """Return the positions in the scenes of θ `[L, D]`: `[L, K, 2]` m."""
        return self.places(self._lineup.starts(theta, np.zeros(len(theta), np.uint64)))

    def places(self, matches: np.ndarray) -> np.ndarray:
        """Return the positions in matches MATCH `[N]`: `[N, K, 2]` m."""
        players = matches["players"][:, : len(self.classes) - 1]
        people = np.stack([players["x"], players["y"]], -1)  # [N, P, 2]
        ball = np.stack([matches["ball"]["x"], matches["ball"]["y"]], -1)  # [N, 2]
        return np.concatenate([people, ball[:, None]], 1)

    def frame(self, env: HasMatches) -> np.ndarray:
        """Return the positions in the first match of `env`: `[K, 2]` m."""
        return self.places(env.matches[:1])[0]

    def draw(self, axes: Axes, theta: np.ndarray, dots: float = 60.0) -> None:
        """Draw the scenes of θ `[L, D]` on one pitch."""
        draw_pitch(axes, self.bounds)
        matches = self._lineup.starts(theta, np.zeros(len(theta), np.uint64))
        players = matches["players"][:, : len(self.classes) - 1]
        headings = np.stack([players["facing_x"], players["facing_y"]], -1)  # [L, P, 2]
        for places, facing in zip(self.places(matches), headings, strict=True):
            draw_headings(axes, places, facing, self.classes)
            draw_scene(axes, places, self.classes, dots)


def pitch_lines() -> list[np.ndarray]:
    """Return the markings of a whole pitch as strips `[n, 2]` in meters."""
    x, y = HALF_LENGTH, HALF_WIDTH
    strips = [
        np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]]),
        np.array([[0, -y], [0, y]]),
        _arc(0.0, CIRCLE_RADIUS, 0.0, math.tau),
    ]
    reach = math.acos((BOX_DEPTH - PENALTY_SPOT) / CIRCLE_RADIUS)  # half angle of the arc outside the box
    for side in (-1, 1):
        for depth, half in (
            (BOX_DEPTH, BOX_HALF_WIDTH),
            (GOAL_AREA_DEPTH, GOAL_AREA_HALF_WIDTH),
            (-GOAL_DEPTH, GOAL_HALF_WIDTH),
        ):
            inner = side * (x - depth)
            strips.append(np.array([[side * x, -half], [inner, -half], [inner, half], [side * x, half]]))
        middle = math.pi if side > 0 else 0.0
        strips.append(_arc(side * (x - PENALTY_SPOT), CIRCLE_RADIUS, middle - reach, middle + reach))
    return strips


def _arc(x: float, radius: float, start: float, end: float) -> np.ndarray:
    angle = np.linspace(start, end, 64)
    return np.stack([x + radius * np.cos(angle), radius * np.sin(angle)], 1)


# ---------------------------------------------------------------- Matplotlib

NOSE = 3.2  # m, length of the line from the center of a player that shows its heading
PAPER_GRASS = "#f3f6f2"
PAPER_CHALK = "#b9c6bb"
PAPER_COLORS = ("#1f77d0", "#3aa79b", "#d9413d", "#e5a50a", "#222222")  # of MARKERS, for a light background


def draw_pitch(axes: Axes, bounds: tuple[float, float, float, float]) -> None:
    """Draw the part of the pitch within `bounds` (x low, x high, y low, y high in meters), without axes."""
    axes.set_facecolor(PAPER_GRASS)
    for strip in pitch_lines():
        axes.plot(strip[:, 0], strip[:, 1], color=PAPER_CHALK, linewidth=1.0, zorder=1, solid_capstyle="round")
    axes.set_xlim(bounds[0], bounds[1])
    axes.set_ylim(bounds[2], bounds[3])
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_headings(axes: Axes, places: np.ndarray, facing: np.ndarray, classes: np.ndarray) -> None:
    """Draw the unit vectors `facing` `[P, 2]` of players at `places` `[K, 2]`; `classes` `[K]` index MARKERS."""
    for place, ahead, kind in zip(places, facing, classes, strict=False):
        x, y = np.stack([place, place + NOSE * ahead], 1)
        axes.plot(x, y, color=PAPER_COLORS[kind], linewidth=1.6, zorder=2, solid_capstyle="round")


def draw_scene(axes: Axes, places: np.ndarray, classes: np.ndarray, dots: float = 60.0) -> None:
    """Draw players and ball at `places` `[K, 2]`; `classes` `[K]` index MARKERS, `dots` is the size in points²."""
    colors = [PAPER_COLORS[kind] for kind in classes]
    sizes = np.where(classes == BALL, 0.3 * dots, dots)
    axes.scatter(places[:, 0], places[:, 1], s=sizes, c=colors, edgecolors="white", linewidths=0.7, zorder=3)
