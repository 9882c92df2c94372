"""The ball between two touches: ground passes, high passes and shots, over 2.5 s or until the ball hits a player.

Each path of GRF is repeated from the first step in which the ball was free. It starts with GRF's position, height and
velocity in that step, and with the spin of such a kick; no player touches the ball. The final distance and the speed on
the way are compared, and for flying balls the height. Speed and height are compared by the root mean square of the
difference, as a share of the root mean square speed and of the greatest height. Read next: `grf.passes`, where the
speed with which it leaves the foot is compared.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_share
from regista.envs.football.constants import FRAMES
from regista.envs.football.physics.ball import advance_ball
from regista.envs.football.skills.passes import FLIGHT
from regista.envs.football.skills.shots import CURL
from regista.envs.football.state import MATCH
from regista.kernels.jit import kernel

TITLE = "ball"
REQUIRED = 1.0
TOLERANCE = 0.05
FLIES_ABOVE = 0.5  # m, minimum height of a path for a comparison of heights
STEP = 0.1  # s


def measure(effort: float = 1.0) -> list[Row]:
    """Compare with GRF; the paths are not random, so `effort` has no effect."""
    rows = []
    for name, theirs in their_paths().items():
        ours = our_path(name, theirs)
        rows.append(by_share("ball", f"{name}: distance", ours[-1, 0], theirs[-1, 0], "m", TOLERANCE))
        speed = _rms(theirs[:, 2])
        error = _rms(ours[:, 2] - theirs[:, 2])
        rows.append(Row("ball", f"{name}: speed", error, speed, "m/s rms", error / speed, TOLERANCE))
        highest = float(np.max(theirs[:, 1]))
        if highest > FLIES_ABOVE:
            error = _rms(ours[:, 1] - theirs[:, 1])
            rows.append(Row("ball", f"{name}: height", error, highest, "m rms, max", error / highest, TOLERANCE))
    return rows


def their_paths() -> dict[str, np.ndarray]:
    """Return GRF's paths by name, `[T, 4]`: distance in m, height in m, speed in the plane and upwards in m/s."""
    paths: dict[str, list[list[float]]] = {}
    for row in read_data("ball_paths"):
        paths.setdefault(row["path"], []).append([float(row[name]) for name in ("away", "height", "speed", "rise")])
    return {name: np.array(path) for name, path in paths.items()}


def our_path(name: str, theirs: np.ndarray) -> np.ndarray:
    """Return our path of this name `[T, 4]`, with the same start as GRF's."""
    matches = np.zeros(1, MATCH).view(np.recarray)
    ball = matches["ball"]
    ball["z"], ball["vx"], ball["vz"] = theirs[0, 1:]
    ball["spin_x"] = spin_of(name, float(np.hypot(theirs[0, 2], theirs[0, 3])))
    path = []
    for _ in theirs:
        path.append([ball["x"][0], ball["z"][0], ball["vx"][0], ball["vz"][0]])
        roll_on(matches)
    return np.array(path)


def spin_of(name: str, speed: float) -> float:
    """Return the spin in m/s from a kick of this kind and speed in m/s."""
    if name == "shot":
        return CURL.spin
    return (FLIGHT.high_spin if name.startswith("high") else FLIGHT.ground_spin) * min(speed / FLIGHT.full_spin, 1.0)


@kernel
def roll_on(matches):
    """Advance the ball of the first match by one step, untouched."""
    for _ in range(FRAMES):
        advance_ball(matches[0].ball)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw distance, speed and height of every path over time."""
    panels = []
    for name, theirs in their_paths().items():
        ours = our_path(name, theirs)
        time = STEP * np.arange(len(theirs))
        for column, unit in ((0, "m away"), (2, "m/s"), (1, "m high")):
            panels.append(Panel(name, (time, theirs[:, column]), (time, ours[:, column]), "s", unit))
    draw_panels(path, "the ball untouched", panels)
