"""Shots past a lone back in drawn scenes: how often does the back stop them, or win the ball before the kick?

Read next: `grf.report`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab.grf.differential import OURS, play_seeds
from lab.grf.drawn_scenes import program_text
from lab.grf.figures import Panel, draw_panels
from lab.grf.report import read_data
from lab.grf.rows import Row, by_distance
from lab.grf.scenes import KEEPER, Scene
from regista.envs.football.constants import CB, CF, DIRECTION_RIGHT, IDLE, SHOT, STEP
from regista.experiments.transfer.episodes import Episodes

TITLE = "shots past a lone back"
REQUIRED = 1.0
EPISODES = 16  # of each scene; GRF has 4
LASTS = 22  # steps
WAITS = 8  # steps after the shot action in which the ball may be kicked
KICKED = 4.0  # m/s of extra speed in the step of a kick
ONWARD = 12.0  # m/s forward; a faster ball has passed the back
BEHIND = 0.012  # in GRF's units, from the striker to the ball
TOLERANCES = {"stopped": 0.06, "past": 0.12}  # share of episodes
NAMES = {"stopped": "stopped", "past": "gets past"}


@dataclass(frozen=True)
class Shooting:
    """A drawn scene, the step of the shot action, and GRF's shares of episodes with a stopped shot and a passed back.

    The other episodes have no shot.
    """

    number: int
    scene: Scene
    pressed: int
    stopped: float
    past: float

    def play(self) -> Episodes:
        """Play the scene in our simulator."""
        keys = np.full(LASTS, IDLE)
        keys[0], keys[self.pressed] = DIRECTION_RIGHT, SHOT
        seeds = EPISODES * self.number + np.arange(EPISODES)
        return play_seeds(program_text(self.scene), keys, seeds, OURS)


def shootings() -> Iterator[Shooting]:
    """Read the scenes."""
    for row in read_data("blocks"):
        x, y = float(row["ball_x"]), float(row["ball_y"])
        back = (CB, float(row["x"]), float(row["y"]))
        scene = Scene((KEEPER, (CF, x - BEHIND, y)), (KEEPER, back), (x, y))
        yield Shooting(int(row["scene"]), scene, int(row["pressed"]), float(row["stopped"]), float(row["past"]))


def what_becomes(episodes: Episodes, pressed: int) -> tuple[float, float]:
    """Return the shares of episodes in which a shot requested in step `pressed` is stopped, and gets past the back."""
    found = [
        _outcome(ball[: length + 1], pressed) for ball, length in zip(episodes.ball, episodes.lengths, strict=True)
    ]
    return found.count("stopped") / len(found), found.count("past") / len(found)


def _outcome(ball: np.ndarray, pressed: int) -> str:
    """Return the outcome of the shot in an episode with ball positions [T + 1, 3]."""
    velocity = np.diff(ball[:, :2], axis=0) / STEP
    speed = np.linalg.norm(velocity, axis=1)
    for step in range(max(pressed, 1), min(len(speed), pressed + WAITS + 1)):
        if speed[step] - speed[step - 1] > KICKED:
            return "past" if velocity[min(step + 2, len(speed) - 1), 0] > ONWARD else "stopped"
    return "none"


def measure(effort: float = 1.0) -> list[Row]:
    """Compare how often shots are stopped and get past; `effort` below 1 plays fewer scenes."""
    ours, theirs = found(effort)
    return [
        by_distance(
            "blocks", f"a shot {NAMES[name]}", float(ours[name].mean()), float(theirs[name].mean()), "share", most
        )
        for name, most in TOLERANCES.items()
    ]


def found(effort: float) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Play every scene, or fewer with less effort; return the shares of our simulator and of GRF, `[S]` of each."""
    every = max(round(1.0 / effort), 1)
    chosen = [shooting for shooting in shootings() if shooting.number % every == 0]
    ours = np.array([what_becomes(shooting.play(), shooting.pressed) for shooting in chosen])
    theirs = np.array([(shooting.stopped, shooting.past) for shooting in chosen])
    return dict(zip(TOLERANCES, ours.T, strict=True)), dict(zip(TOLERANCES, theirs.T, strict=True))


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw the shares of both engines, with the scenes in the order of GRF's shares."""
    ours, theirs = found(effort)
    panels = []
    for name, there in theirs.items():
        order = np.argsort(there, kind="stable")
        place = np.linspace(0.0, 1.0, len(order))
        running = np.cumsum(ours[name][order]) / len(order), np.cumsum(there[order]) / len(order)
        panels.append(Panel(NAMES[name], (place, running[1]), (place, running[0]), "share of scenes", "sum of shares"))
    draw_panels(path, TITLE, panels, columns=2)
