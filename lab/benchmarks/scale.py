"""How do costs grow with environments, players, columns of θ, levels in a buffer, threads and agents?

Everything but threads is reported per second of one processor, which other users of the machine hardly affect. Read
next: `benchmarks.training`, what a step of training is made of.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lab.benchmarks.timing import rate
from lab.benchmarks.training import ELEVEN, TEAMS
from regista.experiments.run import build
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.games import find_minigame
from regista.experiments.run.programs import load_program
from regista.experiments.run.progress import count
from regista.experiments.run.table import cannot_write
from ued.config import ACCELConfig, BufferConfig, PairedConfig, PLRConfig
from ued.core.curriculum import Curriculum, ThetaSpace
from ued.levels.record import RESULTS

ENVIRONMENTS = (1, 4, 16, 64, 256, 1024, 4096, 16_384)
PLAYERS = (2, 4, 6, 10, 14, 18, 22)
COLUMNS = (1, 3, 10, 30, 100, 300, 1000)  # of θ
LEVELS = (100, 1_000, 10_000, 100_000, 1_000_000)  # in a buffer
AT_A_TIME = 64  # levels per request to a curriculum, and results per update of it
WARM_UPDATES = 2  # training updates before the measurement


class Point(NamedTuple):
    """One point of a curve: its `panel`, its `curve`, its x, and the measured `per_second`."""

    panel: str
    curve: str
    x: int
    per_second: float


class Panel(NamedTuple):
    """Title and axis labels of a panel of the figure."""

    title: str
    x: str
    y: str


PANELS = {
    "environments": Panel("Environments at a time", "environments", "env steps per processor second"),
    "players": Panel("Players on the pitch", "players", "env steps per processor second"),
    "columns": Panel("Free parameters", "columns of θ", "levels per processor second"),
    "buffer": Panel("Levels in a buffer", "levels", "levels per processor second"),
    "threads": Panel("Threads", "threads", "env steps per second"),
    "agents": Panel("Agents that learn, eleven a side", "agents", "agent steps per processor second"),
}


def scale_suite(minigame: str, seconds: float) -> Iterator[Point]:
    """Measure point by point, each for about `seconds`."""
    yield from _environments(minigame, seconds)
    yield from _players(seconds)
    for dim in COLUMNS:
        for name, curriculum in _curricula(dim):
            yield Point("columns", name, dim, _levels_per_second(curriculum, seconds))
    for levels in LEVELS:
        yield Point("buffer", "plr", levels, _levels_per_second(_filled(levels), seconds))
    yield from _threads(minigame, seconds)
    yield from _agents(seconds)


# ---------------------------------------------------------------- the simulator


def _environments(minigame: str, seconds: float) -> Iterator[Point]:
    program = load_program(find_minigame(minigame).program, None)
    for num_envs in ENVIRONMENTS:
        speed = _steps_per_second(program, num_envs, 1, seconds, time.process_time)
        yield Point("environments", minigame, num_envs, speed)


def _players(seconds: float) -> Iterator[Point]:
    """Measure matches with half of the players on either side, all without behaviors: the simulator moves them."""
    from regista.envs.football.scenic.domain import FOOTBALL
    from scenic_lite import load

    for players in PLAYERS:
        speed = _steps_per_second(load(_match_of(players), FOOTBALL), 64, 1, seconds, time.process_time)
        yield Point("players", "random actions", players, speed)


def _match_of(players: int) -> str:
    """Return a program with keepers, ego in the left team, and all others at random places in their own half."""
    never = [f"param end_episode_on_{what} = False" for what in ("score", "out_of_play", "possession_change")]
    left = ["LeftCM at Range(-90, -5) @ Range(-40, 40)"] * (players // 2 - 1) + ["LeftGK at -99 @ 0"]
    right = ["RightCM at Range(5, 90) @ Range(-40, 40)"] * (players // 2 - 1) + ["RightGK at 99 @ 0"]
    return "\n".join([*never, f"ego = {left[0]}", *left[1:], *right, "ball = Ball at 0 @ 0"])


def _threads(minigame: str, seconds: float) -> Iterator[Point]:
    program = load_program(find_minigame(minigame).program, None)
    for threads in range(1, (os.cpu_count() or 1) + 1):
        speed = _steps_per_second(program, 1024, threads, seconds, time.perf_counter)
        yield Point("threads", minigame, threads, speed)


def _steps_per_second(program: Any, num_envs: int, threads: int, seconds: float, clock: Any) -> float:
    """Step with random actions, drawn beforehand; episodes restart as they end."""
    env = build.make_matches(program, num_envs, TrainConfig().env, 0, threads)
    actions = np.random.default_rng(0).integers(0, env.single_action_space.n, (16, num_envs))

    def step(count: int) -> None:
        for t in range(count):
            env.step(actions[t % 16])

    return num_envs * rate(step, seconds, clock=clock)


# ---------------------------------------------------------------- curricula


def _curricula(dim: int) -> list[tuple[str, Curriculum]]:
    from ued.methods.accel import ACCELCurriculum
    from ued.methods.dr import RandomCurriculum
    from ued.methods.paired import PairedCurriculum
    from ued.methods.plr import PLRCurriculum

    return [
        ("dr", RandomCurriculum(ThetaSpace(dim))),
        ("plr", PLRCurriculum(ThetaSpace(dim), PLRConfig())),
        ("accel", ACCELCurriculum(ThetaSpace(dim), ACCELConfig())),
        ("paired", PairedCurriculum(ThetaSpace(dim), PairedConfig())),
    ]


def _filled(levels: int) -> Curriculum:
    """Return a curriculum with a full buffer of `levels` levels."""
    from ued.methods.plr import PLRCurriculum

    curriculum = PLRCurriculum(ThetaSpace(6), PLRConfig(buffer=BufferConfig(capacity=levels, no_duplicates=False)))
    rng, next_id = np.random.default_rng(0), 0
    while len(curriculum.buffer.slots) < levels:
        records = curriculum._new(min(levels, 10_000))
        records["id"] = next_id + np.arange(len(records))
        next_id += len(records)
        _play(records, rng)
        curriculum.update(records)
    return curriculum


def _levels_per_second(curriculum: Curriculum, seconds: float) -> float:
    """Request levels and report their results repeatedly, with one thread for networks as in training."""
    import torch

    torch.set_num_threads(1)
    rng, numbers = np.random.default_rng(0), iter(range(10**9, 10**15))

    def turn(count: int) -> None:
        for _ in range(count):
            records = curriculum.propose(AT_A_TIME)
            new = records["id"] < 0
            records["id"][new] = [next(numbers) for _ in range(int(new.sum()))]
            _play(records, rng)
            curriculum.update(records)

    turn(4)
    return AT_A_TIME * rate(turn, seconds, clock=time.process_time)


def _play(records: np.ndarray, rng: np.random.Generator) -> None:
    """Write results into records like a student that solves half of the levels."""
    for name in RESULTS:
        records[name] = rng.random(records[name].shape)
    records["returns"] = rng.random(records["returns"].shape) < 0.5
    records["success"] = records["returns"]
    records["num_played"] = records["num_episodes"][:, None]


# ---------------------------------------------------------------- learning


def _agents(seconds: float) -> Iterator[Point]:
    config = replace(TrainConfig(), minigame=ELEVEN, method="dr")
    program = load_program(find_minigame(ELEVEN).program, None)
    for team in ("independent", "shared"):
        for control in TEAMS:
            env, ppo = replace(config.env, control=control), replace(config.ppo, team=team)
            upomdp = build.make_matches(program, 16, env, 0, 1)
            method = build.make_method(replace(config, env=env, ppo=ppo), upomdp)
            yield Point("agents", team, upomdp.num_agents, _agent_steps_per_second(method, seconds))


def _agent_steps_per_second(method: Any, seconds: float) -> float:
    for _ in range(WARM_UPDATES):
        method.update()
    began, steps = time.process_time(), method.env_steps
    while time.process_time() - began < seconds:
        method.update()
    return method.upomdp.num_agents * (method.env_steps - steps) / (time.process_time() - began)


# ---------------------------------------------------------------- the page


def draw(points: Sequence[Point], folder: Path) -> Path:
    """Draw the curves on one page, scale.png. Raises `CommandError` if writing fails."""
    import matplotlib.pyplot as plt

    from regista.experiments.pictures import plots

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
    with plots.style():
        figure, grid = plt.subplots(2, 3, figsize=(12, 6.6))
        for axes, (name, panel) in zip(grid.flat, PANELS.items(), strict=True):
            mine = [point for point in points if point.panel == name]
            for curve in dict.fromkeys(point.curve for point in mine):
                x, y = zip(*((point.x, point.per_second) for point in mine if point.curve == curve), strict=True)
                shade = plots.METHOD_COLORS.get(curve)  # not a method: the next color of the style
                look: dict[str, Any] = {"color": shade, "label": plots.title(curve)}
                if name == "threads":  # two points are not a curve
                    axes.bar(x, y, 0.5, **look)
                else:
                    axes.plot(x, y, "o-", markersize=4, **look)
            axes.set(xlabel=panel.x, ylabel=panel.y)
            axes.set_title(panel.title, pad=24)  # above the legend
            _scale_axes(axes, name)
            axes.legend(loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=4, fontsize=7.5, handlelength=1.0)
        figure.tight_layout()
        path = folder / "scale.png"
        plots.save(figure, path)
    return path


def _scale_axes(axes: Any, name: str) -> None:
    """Choose the scales of a panel's axes, and write their numbers as 500k or 2M in all panels."""
    from matplotlib.ticker import LogLocator, NullFormatter

    if name in ("environments", "columns", "buffer"):
        axes.set(xscale="log", yscale="log")
        low, high = axes.get_ylim()
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,)))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(bottom=0)
        places = [x for line in axes.lines for x in line.get_xdata()] + [bar.get_center()[0] for bar in axes.patches]
        axes.set_xticks(sorted({round(x) for x in places}))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: count(value))


def rows_of(points: Sequence[Point]) -> list[list[str]]:
    """Return the points as a table, with the cost of each."""
    rows = [["", "curve", "", "per second", "µs each"]]
    tell = partial("{:,.0f}".format)
    for point in points:
        cost = f"{1e6 / point.per_second:,.2f}"
        x = f"{point.x:,} {PANELS[point.panel].x}"
        rows.append([point.panel, point.curve, x, tell(point.per_second).rjust(11), cost.rjust(9)])
    return rows
