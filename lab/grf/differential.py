"""A randomized differential test: drawn scenes with equal actions in our simulator and in GRF.

Both engines play each scene with several seeds. The distance between an episode of ours and one of GRF is reported
beside the distance between two episodes of GRF. A simulator that always plays the average outcome can fall below that
distance. The energy distance therefore judges random outcomes: it is 0 only for a simulator with GRF's distribution.
Read next: `grf.drawn_scenes`; `regista.experiments.pictures.side_by_side`, by which one can look at the worst.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lab.grf.drawn_scenes import STEPS, DrawnScene, program_text
from lab.grf.figures import Panel, draw_panels
from lab.grf.rows import Row, by_distance, by_factor
from regista.envs.football.config import FootballConfig
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.football.view.render import FootballPainter
from regista.experiments.run.table import cannot_write
from regista.experiments.transfer.episodes import Episodes, play_keys, seconds, side_by_side
from scenic_lite import load
from ued.core.level_space import level_dtype

TITLE = "drawn scenes: ours to GRF's, and GRF's among themselves"
REQUIRED = 1.0
SCENES, SEEDS = 200, 4  # at effort 1; seeds in either engine
OURS = FootballConfig("simple115", control="active")
LOOKED_AT = (10, 20, 40)  # steps
AGREEMENT = 0.1  # share of pairs of endings
DISTANCE = 0.5  # tolerance: a factor of 1.5
WORST = 10  # number of scenes listed


@dataclass(frozen=True)
class Pair:
    """A drawn scene played in both engines, E episodes each."""

    drawn: DrawnScene
    ours: Episodes
    grf: Episodes

    def agreement(self, limit: bool = False) -> float:
        """Return the share of pairs of episodes with the same ending; `limit`: pairs within GRF, not across engines."""
        first, second = self._sides(limit)
        same = first.endings()[:, None] == second.endings()[None, :]
        return _mean(same.astype(float), _others(same.shape, limit))

    def apart(self, step: int, what: str, limit: bool = False) -> float:
        """Return the mean distance in m of the "ball" or the "players" in pairs of episodes after a step.

        Pairs with an episode that has ended before do not count; the result is nan if no pair is left.
        """
        return _apart(*self._sides(limit), step, what)

    def energy(self, step: int, what: str) -> float:
        """Return the energy distance of both engines' "ball" or "players" after a step, in m.

        It is the mean distance between engines minus half of the distances within each, over pairs of different
        episodes. This is half of 2 E|X - Y| - E|X - X'| - E|Y - Y'| of Székely & Rizzo, Energy statistics, J. Stat.
        Plan. Inference 143 (2013). Its mean over scenes is 0 if both have the same distribution; the value of a single
        scene may be negative.
        """
        within = [_apart(side, side, step, what) for side in (self.ours, self.grf)]
        return self.apart(step, what) - 0.5 * sum(within)

    def badness(self) -> float:
        """Return the largest excess in m of the distance between engines over that within GRF, of ball and players.

        A smaller agreement of endings than within GRF adds up to 10 m.
        """
        excess = [
            self.apart(step, what) - self.apart(step, what, limit=True)
            for step in LOOKED_AT
            for what in ("ball", "players")
        ]
        known = [value for value in excess if np.isfinite(value)]
        return max(known, default=0.0) + 10.0 * max(self.agreement(True) - self.agreement(), 0.0)

    def line(self) -> list[str]:
        """Return a row of the table of the worst scenes."""
        places = []
        for what in ("ball", "players"):
            both, own = (self.apart(20, what, limit) for limit in (False, True))
            places.append(f"{_spelled(both)} ({_spelled(own)})")
        counts = [_counted(episodes.endings()) for episodes in (self.ours, self.grf)]
        return [self.drawn.name, self.drawn.sides, *places, *counts]

    def painter(self) -> FootballPainter:
        """Return the painter of the scene."""
        return FootballPainter(Lineup(load(program_text(self.drawn.scene), FOOTBALL)))

    def _sides(self, limit: bool) -> tuple[Episodes, Episodes]:
        return (self.grf if limit else self.ours), self.grf


def play_scenes(
    scenes: Sequence[DrawnScene],
    other: FootballConfig,
    seeds: int = SEEDS,
    told: Callable[[int], None] = lambda _: None,
) -> Iterator[Pair]:
    """Play drawn scenes in our simulator and in the engine of another configuration.

    Raises `regista.envs.grf.workers.GrfError` if GRF is requested but not installed.
    """
    for number, drawn in enumerate(scenes):
        program = program_text(drawn.scene)
        ours, grf = (_play(program, drawn, config, seeds, engine) for engine, config in ((1, OURS), (2, other)))
        yield Pair(drawn, ours, grf)
        told(number + 1)


def _play(program: str, drawn: DrawnScene, config: FootballConfig, count: int, engine: int) -> Episodes:
    return play_seeds(program, drawn.keys, drawn.seeds(engine, count), config)


def play_seeds(program: str, keys: np.ndarray, seeds: np.ndarray, config: FootballConfig) -> Episodes:
    """Play actions `[T]` in a program without parameters, an episode for each seed `[E]`."""
    with closing(FootballVectorEnv(program, len(seeds), config=config)) as env:
        levels = np.zeros(len(seeds), level_dtype(env.theta_dim))
        levels["seed"] = seeds
        return play_keys(env, keys, levels)


def compare(pairs: Sequence[Pair]) -> list[Row]:
    """Return the comparison: medians over scenes of the mean over pairs of episodes."""
    rows = [
        by_distance(
            "differential",
            "endings that agree",
            float(np.mean([pair.agreement() for pair in pairs])),
            float(np.mean([pair.agreement(limit=True) for pair in pairs])),
            "share",
            AGREEMENT,
        )
    ]
    for what in ("ball", "players"):
        for step in LOOKED_AT:
            ours, grf = (_median([pair.apart(step, what, limit) for pair in pairs]) for limit in (False, True))
            rows.append(by_factor("differential", f"{what} apart at step {step}", ours, grf, "m", DISTANCE))
    return rows


def energies(pairs: Sequence[Pair]) -> dict[str, tuple[float, float]]:
    """Return the energy distance by "ball_10" .. "players_40", in m: its mean over scenes, and the standard error.

    Both are nan if too few scenes last as long.
    """
    distances = {}
    for what in ("ball", "players"):
        for step in LOOKED_AT:
            known = [value for value in (pair.energy(step, what) for pair in pairs) if np.isfinite(value)]
            error = np.std(known, ddof=1) / np.sqrt(len(known)) if len(known) > 1 else np.nan
            distances[f"{what}_{step}"] = (float(np.mean(known)) if known else np.nan, float(error))
    return distances


def energy_table(pairs: Sequence[Pair]) -> list[list[str]]:
    """Return the energy distances as a table."""
    distances = energies(pairs)
    head = ["energy distance in m, mean over scenes", *(f"step {step}" for step in LOOKED_AT)]
    spelled = {name: f"{mean:.2f} ± {error:.2f}" for name, (mean, error) in distances.items()}
    return [head, *([what, *(spelled[f"{what}_{step}"] for step in LOOKED_AT)] for what in ("ball", "players"))]


def worst(pairs: Sequence[Pair], count: int = WORST) -> list[Pair]:
    """Return the least similar scenes, the worst first."""
    return sorted(pairs, key=Pair.badness, reverse=True)[:count]


def worst_table(pairs: Sequence[Pair]) -> list[list[str]]:
    """Return the worst scenes as a table."""
    head = ["worst scenes", "sides", "ball at step 20 (GRF's own), m", "players", "endings, ours", "endings, GRF's"]
    return [head, *(pair.line() for pair in worst(pairs))]


def as_json(pairs: Sequence[Pair]) -> list[dict[str, Any]]:
    """Return all scenes, the worst first."""
    return [
        {
            "scene": pair.drawn.name,
            "sides": pair.drawn.sides,
            "badness": pair.badness(),
            "endings_agree": pair.agreement(),
            "endings_agree_limit": pair.agreement(limit=True),
            **{
                f"{what}_{step}{'_limit' * limit}": _or_none(pair.apart(step, what, limit))
                for what in ("ball", "players")
                for step in LOOKED_AT
                for limit in (False, True)
            },
            **{
                f"{what}_{step}_energy": _or_none(pair.energy(step, what))
                for what in ("ball", "players")
                for step in LOOKED_AT
            },
            "endings_ours": dict(Counter(pair.ours.endings().tolist())),
            "endings_grf": dict(Counter(pair.grf.endings().tolist())),
        }
        for pair in worst(pairs, len(pairs))
    ]


def show(folder: Path, pairs: Sequence[Pair]) -> None:
    """Write a figure of the distances over time, and the worst scenes as programs and as a recording, to a folder.

    Raises CommandError if writing fails.
    """
    from regista.experiments.pictures.side_by_side import record_side_by_side

    chosen = worst(pairs)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for pair in chosen:
            (folder / f"{pair.drawn.name.replace(':', '-')}.scenic").write_text(program_text(pair.drawn.scene))
        seen = [side_by_side(pair.drawn.name, pair.painter(), pair.ours, pair.grf, 0) for pair in chosen]
        record_side_by_side(folder / "worst.rrd", "worst drawn scenes", seen)
    except OSError as error:
        raise cannot_write(folder, error) from error
    figure(folder / "differential.png", pairs)


def figure(path: Path, pairs: Sequence[Pair]) -> None:
    """Draw the distances of ball and players over time."""
    steps = range(0, STEPS, 2)
    panels = []
    for what in ("ball", "players"):
        curves = [[_median([pair.apart(t, what, limit) for pair in pairs]) for t in steps] for limit in (True, False)]
        panels.append(Panel(f"{what} apart", (steps, curves[0]), (steps, curves[1]), f"step of {seconds(1)}", "m"))
    draw_panels(path, "drawn scenes", panels)


def _apart(first: Episodes, second: Episodes, step: int, what: str) -> float:
    """Return `Pair.apart` of two sets of episodes, or of different episodes of one set."""
    one, other = (side.places if what == "players" else side.ball[:, :, None, :2] for side in (first, second))
    if step >= min(one.shape[1], other.shape[1]):
        return np.nan
    gap = np.linalg.norm(one[:, None, step] - other[None, :, step], axis=-1).mean(-1)
    there = (first.lengths[:, None] >= step) & (second.lengths[None, :] >= step)
    return _mean(gap, there & _others(gap.shape, first is second))


def _others(shape: tuple[int, ...], limit: bool) -> np.ndarray:
    """Return which pairs count: all of them, or within one set only pairs of different episodes."""
    return np.eye(shape[0]) == 0 if limit else np.ones(shape, bool)


def _mean(values: np.ndarray, counted: np.ndarray) -> float:
    return float(values[counted].mean()) if counted.any() else np.nan


def _median(values: Sequence[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.median(known)) if known else np.nan


def _spelled(value: float) -> str:
    return f"{value:.1f}" if np.isfinite(value) else "over"


def _or_none(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _counted(words: np.ndarray) -> str:
    return ", ".join(f"{count} {word}" for word, count in Counter(words.tolist()).most_common())
