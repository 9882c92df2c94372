"""Backs and chasers: where built-in players run while a carrier runs on, in drawn scenes without other players.

In some scenes a lone back stands in front of the carrier; in the others one to three players are beside and behind.
Read next: `grf.report`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np

from lab.grf.differential import OURS, play_seeds
from lab.grf.drawn_scenes import program_text
from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance
from lab.grf.scenes import KEEPER, Scene
from regista.envs.football.constants import CF, IDLE, STEP
from regista.experiments.transfer.episodes import Episodes

TITLE = "backs and chasers"
REQUIRED = 1.0
EPISODES = 4  # of each scene, as in GRF
LEAST = 2  # episodes that last long enough; with fewer, the position is unknown
STEPS = {"early": 8, "middle": 16, "late": 25}  # names of the columns, and the steps after which positions are compared
TOLERANCES = {"early": 0.5, "middle": 0.7, "late": 0.9}  # m
LASTS = 40  # steps until the final possession is compared
LOST = 0.075  # tolerance of the share of episodes in which the carrier loses the ball
BEHIND = 0.02  # in GRF's units, from the carrier to the ball
KINDS = {"a lone back": range(100, 300), "chasers": range(100)}  # by the scene's number
FIRST = 3  # index of the first runner: both keepers and the carrier come first


@dataclass(frozen=True)
class Chase:
    """A drawn scene, the carrier's actions `[LASTS]`, and GRF's results.

    `places` has the positions of GRF's R runners by the name of `STEPS`, nan if unknown; `lost` is the share of GRF's
    episodes in which the runners have the ball at the end.
    """

    number: int
    scene: Scene
    keys: np.ndarray
    places: dict[str, np.ndarray]  # [R, 2] m
    lost: float

    def play(self) -> Episodes:
        """Play the scene in our simulator."""
        seeds = EPISODES * self.number + np.arange(EPISODES)
        return play_seeds(program_text(self.scene), self.keys, seeds, OURS)

    def compare(self) -> Found:
        """Play the scene and compare."""
        ours = self.play()
        apart = {
            name: np.linalg.norm(mean_places(ours, step) - self.places[name], axis=1) for name, step in STEPS.items()
        }
        return Found(apart, float(np.mean(ours.endings() == "possession")), self.lost)


@dataclass(frozen=True)
class Found:
    """Mean distance in m of our runners from GRF's, `[R]` by the name of `STEPS`; the shares of lost balls in both."""

    apart: dict[str, np.ndarray]
    lost: float
    lost_there: float


def mean_places(episodes: Episodes, step: int) -> np.ndarray:
    """Return the mean positions of the runners after a step, `[R, 2]` m, over the episodes that last as long."""
    there = episodes.lengths >= step
    runners = episodes.places[:, min(step, episodes.places.shape[1] - 1), FIRST:]
    return runners[there].mean(0) if there.sum() >= LEAST else np.full(runners.shape[1:], np.nan)


def chases() -> Iterator[Chase]:
    """Read the scenes."""
    for number, rows in groupby(read_data("chases"), key=lambda row: int(row["scene"])):
        runners = list(rows)
        x, y = float(runners[0]["ball_x"]), float(runners[0]["ball_y"])
        right = tuple((int(row["role"]), float(row["x"]), float(row["y"])) for row in runners)
        keys = np.full(LASTS, IDLE)
        pressed = [int(key) for key in runners[0]["keys"].split()][: len(keys)]
        keys[: len(pressed)] = pressed
        places = {
            name: np.array([[float(row[f"{name}_{axis}"] or "nan") for axis in "xy"] for row in runners])
            for name in STEPS
        }
        scene = Scene((KEEPER, (CF, x - BEHIND, y)), (KEEPER, *right), (x, y))
        yield Chase(number, scene, keys, places, float(runners[0]["lost"]))


def measure(effort: float = 1.0) -> list[Row]:
    """Compare the positions of runners with GRF's, and the final possession; `effort` below 1 plays fewer scenes."""
    rows = []
    for kind, found in found_by_kind(effort).items():
        for name, step in STEPS.items():
            median = float(np.nanmedian(together(found, name)))
            what = f"{kind}: apart after {step * STEP:.1f} s, median"
            rows.append(by_distance("chases", what, median, 0.0, "m", TOLERANCES[name]))
        ours, grf = (float(np.mean([getattr(one, whose) for one in found])) for whose in ("lost", "lost_there"))
        rows.append(
            by_distance("chases", f"{kind}: has the ball within {LASTS * STEP:.0f} s", ours, grf, "share", LOST)
        )
    return rows


def found_by_kind(effort: float) -> dict[str, list[Found]]:
    """Play every scene, or fewer with less effort; return the results by kind of runners."""
    every = max(round(1.0 / effort), 1)
    chosen = [chase for chase in chases() if chase.number % every == 0]
    return {kind: [chase.compare() for chase in chosen if chase.number in of] for kind, of in KINDS.items()}


def together(found: Iterable[Found], name: str) -> np.ndarray:
    """Return the distances in m of all runners from GRF's at one of `STEPS`."""
    return np.concatenate([one.apart[name] for one in found])


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw the distances of all runners from GRF's, in ascending order."""
    panels = []
    for kind, found in found_by_kind(effort).items():
        for name, step in STEPS.items():
            apart = together(found, name)
            ours = np.sort(apart[np.isfinite(apart)])
            order = np.linspace(0.0, 1.0, len(ours))
            title = f"{kind}, {step * STEP:.1f} s"
            panels.append(Panel(title, (order, np.zeros(len(ours))), (order, ours), "share of them", "m apart"))
    draw_panels(path, TITLE, panels, columns=3)
