"""Scenes and actions drawn at random and reproducible by name: "0:17" is number 17 of seed 0.

Read next: `grf.differential`, which plays them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lab.grf.scenes import KEEPER, STRETCH, Players, Scene
from lab.grf.stage import METRES_X, METRES_Y
from regista.envs.football.constants import (
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_RIGHT,
    DIRECTION_TOP_RIGHT,
    DRIBBLE,
    HIGH_PASS,
    IDLE,
    LONG_PASS,
    RELEASE_DIRECTION,
    RELEASE_DRIBBLE,
    RELEASE_SPRINT,
    SHORT_PASS,
    SHOT,
    SLIDING,
    SPRINT,
)
from regista.envs.football.scenic.lineup import ROLES

STEPS = 60
SIDES = (3, 6, 11)  # maximum number of players in a team, drawn uniformly
FORWARD = (DIRECTION_TOP_RIGHT, DIRECTION_RIGHT, DIRECTION_BOTTOM_RIGHT)
# Actions, their share, maximum steps of a press, and minimum and maximum steps without an action afterwards
HABITS = (
    ((*range(1, 9), *FORWARD * 3), 0.55, 1, (2, 13)),
    ((SPRINT,), 0.17, 1, (0, 4)),
    ((RELEASE_DIRECTION, RELEASE_SPRINT, SLIDING, DRIBBLE, RELEASE_DRIBBLE), 0.08, 1, (0, 3)),
    ((LONG_PASS, HIGH_PASS, SHORT_PASS, SHORT_PASS), 0.12, 3, (2, 7)),
    ((SHOT,), 0.08, 4, (2, 7)),
)


@dataclass(frozen=True)
class DrawnScene:
    """A scene, and the actions `[T]` of its active player."""

    name: str
    scene: Scene
    keys: np.ndarray

    @property
    def sides(self) -> str:
        return f"{len(self.scene.left)} v {len(self.scene.right)}"

    def seeds(self, engine: int, count: int) -> np.ndarray:
        """Draw seeds for episodes of this scene in one of several engines (from 1); each scene has its own seeds.

        With the same seeds in all scenes, random errors would not average out over scenes.
        """
        rng = np.random.default_rng([*_numbers(self.name), engine])
        return rng.integers(0, 2**63, count, dtype=np.uint64)


def draw_scene(name: str, steps: int = STEPS) -> DrawnScene:
    """Draw the scene of a name. Raises ValueError for an invalid name."""
    rng = np.random.default_rng(_numbers(name))
    x, y = rng.uniform(-0.2, 0.85), rng.uniform(-0.35, 0.35)
    carrier = (_role(rng), x - 0.02, y)
    left = (KEEPER, carrier, *_team(rng, x, (-0.5, 0.4), there=2))
    right = (KEEPER, *((role, -px, -py) for role, px, py in _team(rng, x, (-0.35, 0.5), there=1)))
    return DrawnScene(name, Scene(left, right, (x, y)), _keys(rng, steps))


def _numbers(name: str) -> list[int]:
    seed, colon, number = name.partition(":")
    if not (colon and seed.isdecimal() and number.isdecimal()):
        raise ValueError(f"a drawn scene is called SEED:NUMBER, such as 0:17, not {name!r}")
    return [int(seed), int(number)]


def program_text(scene: Scene, jitter: float = 0.0, **settings: float) -> str:
    """Return a scene as a Scenic program: players at the engine's positions, keepers on their lines.

    With a `jitter` in m, every player stands up to this distance from the given position in x and in y, drawn for every
    level; the ball moves with the nearest left player. Episodes have as many steps as GRF's: one more than the
    `game_duration` of the scenario. They end like those of the academy, unless `settings` of a match say otherwise.
    """
    usual = {"game_duration": scene.duration + 1, "offsides": False} | {
        f"end_episode_on_{what}": True for what in ("score", "out_of_play", "possession_change")
    }
    lines = [f"param {setting} = {value}" for setting, value in (usual | settings).items()]
    places = [_spot(x, y, 1) for _, x, y in scene.left] + [_spot(x, y, -1) for _, x, y in scene.right]
    lines += [f"place{number} = {_spelled(spot, jitter)}" for number, spot in enumerate(places)]
    things = []
    for number, (role, _, _) in enumerate((*scene.left, *scene.right)):
        team = "Left" if number < len(scene.left) else "Right"
        free = "with allowCollisions True, with regionContainedIn everywhere"
        things.append(f"{team}{list(ROLES)[role]} at place{number}, {free}")
    ball = (100 * scene.ball[0], -100 * scene.ball[1])
    things.append(f"Ball at {_ball(ball, places[: len(scene.left)], jitter)}, with allowCollisions True")
    return "\n".join([*lines, "ego = " + things[0], *things[1:], ""])


def _spot(x: float, y: float, side: int) -> tuple[float, float]:
    """Return a player's position in the units of a program; `side` is -1 for the right team."""
    return 100 * side * x * STRETCH[0], 100 * side * -y * STRETCH[1]


def _spelled(spot: tuple[float, float], jitter: float) -> str:
    """Return a position in the syntax of a program, random if there is a jitter."""
    axes = [
        f"Range({middle - off:.12g}, {middle + off:.12g})" if jitter else f"{middle:.12g}"
        for middle, off in zip(spot, (100 * jitter / METRES_X, 100 * jitter / METRES_Y), strict=True)
    ]
    return " @ ".join(axes)


def _ball(ball: tuple[float, float], left: Sequence[tuple[float, float]], jitter: float) -> str:
    """Return the ball's position; with a jitter, its offset from the nearest left player is that of the scene."""
    if not jitter:
        return _spelled(ball, 0.0)
    far = [np.hypot((x - ball[0]) * METRES_X, (y - ball[1]) * METRES_Y) for x, y in left]
    carrier = int(np.argmin(far))
    x, y = left[carrier]
    return f"place{carrier} offset by ({_spelled((ball[0] - x, ball[1] - y), 0.0)})"


def _team(rng: np.random.Generator, x: float, spread: tuple[float, float], there: int) -> Players:
    """Draw the players of a team except for `there` existing ones, in the left team's frame about the ball's x."""
    size = int(rng.integers(2, rng.choice(SIDES) + 1))
    return tuple(
        (_role(rng), float(np.clip(x + rng.uniform(*spread), -0.9, 0.95)), float(rng.uniform(-0.38, 0.38)))
        for _ in range(size - there)
    )


def _role(rng: np.random.Generator) -> int:
    """Draw a role other than keeper."""
    return int(rng.integers(1, 10))


def _keys(rng: np.random.Generator, steps: int) -> np.ndarray:
    keys: list[int] = []
    shares = [share for _, share, _, _ in HABITS]
    while len(keys) < steps:
        pressed, _, longest, (least, most) = HABITS[rng.choice(len(HABITS), p=shares)]
        keys += [int(rng.choice(pressed))] * int(rng.integers(1, longest + 1))
        keys += [IDLE] * int(rng.integers(least, most + 1))
    return np.array(keys[:steps])
