"""Scripted policies for the academy scenes, by the names under which Google Research Football's goals were counted.

A policy starts with an opening, the actions of the first steps. It may then wait until a teammate has the ball, and may
then run. It ends with a cycle of actions that repeats forever. Each match goes through these phases independently. Read
next: `grf.academy`, which counts what they score.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from lab.grf.stage import METRES_X
from regista.envs.football.constants import (
    DIRECTION_BOTTOM,
    DIRECTION_BOTTOM_RIGHT,
    DIRECTION_RIGHT,
    IDLE,
    LEFT,
    NOBODY,
    SHORT_PASS,
    SHOT,
    SPRINT,
)

TOWARDS = np.array([5, 4, 3, 2, 1, 8, 7, 6])  # direction actions by sector of 45°, counterclockwise from +x
GOAL = (55.0, 0.0)  # m
CYCLE = 8  # steps of a cycle that ends with idle actions
DIRECTIONS = {
    "bottom": DIRECTION_BOTTOM,
    "bottom_right": DIRECTION_BOTTOM_RIGHT,
    "nodir": IDLE,
}
PASS = re.compile(r"short_pass_(bottom_right|bottom|nodir)_(?:then_(.*)|run_([\d.]+)_(.*))")
RUN = re.compile(r"(sprint_right|run_right_nosprint|run_to_goal)_(aimed_)?shot_[\d.]+")


@dataclass
class Policy:
    """The actions of a policy, see the module; `run_to` is in GRF's units, `finish` names the final cycle.

    Its inputs are match records of either engine.
    """

    opening: tuple[int, ...] = ()
    waits: bool = False
    run_to: float = -np.inf
    sprints: bool = True
    to_goal: bool = False
    must_own: bool = False
    finish: str = "always"

    def begin(self, n: int) -> None:
        """Reset the state for n new matches."""
        self.clock = np.zeros(n, int)
        self.running = np.full(n, not self.waits)
        self.run_clock = np.zeros(n, int)
        self.finishing = np.zeros(n, bool)
        self.passer = np.full(n, NOBODY)

    def __call__(self, matches: np.ndarray, step: int) -> np.ndarray:
        """Return the actions [N] of a step."""
        if step < len(self.opening):
            self.passer = matches["agents"][:, 0].copy()
            return np.full(len(matches), self.opening[step])
        me = matches["players"][np.arange(len(matches)), matches["agents"][:, 0]]
        self._watch_pass(matches)
        self._watch_run(matches, me)
        keys = np.where(self.finishing, self._finish(me), np.where(self.running, self._run(me), IDLE))
        self.run_clock += self.running & ~self.finishing
        self.clock += self.finishing
        return keys

    def _watch_pass(self, matches: np.ndarray) -> None:
        """Start the run when a teammate of the passer has the ball."""
        owner = matches["reported_owner"]
        ours = (owner >= 0) & (matches["players"]["team"][np.arange(len(owner)), np.maximum(owner, 0)] == LEFT)
        self.running |= ours & (owner != self.passer)

    def _watch_run(self, matches: np.ndarray, me: np.ndarray) -> None:
        """Finish when the run is over; with `must_own`, only if the player has the ball."""
        there = me["x"] > self.run_to * METRES_X
        if self.must_own:
            there &= matches["reported_owner"] == matches["agents"][:, 0]
        self.finishing |= self.running & there

    def _run(self, me: np.ndarray) -> np.ndarray:
        way = towards_goal(me) if self.to_goal else np.full(len(me), DIRECTION_RIGHT)
        return np.where(self.sprints & (self.run_clock == 1), SPRINT, way)

    def _finish(self, me: np.ndarray) -> np.ndarray:
        phase = self.clock % CYCLE
        if self.finish == "always":
            return np.full(len(me), SHOT)
        if self.finish == "shotcycle":
            return np.choose(np.minimum(phase, 2), (DIRECTION_RIGHT, SHOT, IDLE))
        return np.where(phase == 0, towards_goal(me), np.where(phase == 1, SHOT, IDLE))  # aimed


def towards_goal(me: np.ndarray) -> np.ndarray:
    """Return the direction action [N] that points best at the middle of the right goal."""
    angle = np.arctan2(GOAL[1] - me["y"], GOAL[0] - me["x"])
    return TOWARDS[np.round(angle / (np.pi / 4)).astype(int) % 8]


def policy_named(name: str) -> Policy:
    """Return the policy measured under this name. Raises ValueError if there is none."""
    simple = {
        "always_shot": Policy(),
        "aimed_shot_now_press1": Policy(finish="aimed"),
        "sprint_right_hold_only": Policy(run_to=np.inf),
    }
    if name in simple:
        return simple[name]
    if match := PASS.fullmatch(name):
        way, then, to, run_then = match.groups()
        run_to = float(to) if to else -np.inf
        finish = "shotcycle" if (then or run_then) == "shotcycle" else "aimed"
        return Policy((DIRECTIONS[way], SHORT_PASS), True, run_to, must_own=bool(to), finish=finish)
    if match := RUN.fullmatch(name):
        aimed, to_goal = "aimed" in name, name.startswith("run_to_goal")
        return Policy(
            run_to=float(name.rpartition("_")[2]),
            sprints="nosprint" not in name,
            to_goal=to_goal,
            must_own=aimed,
            finish="aimed" if aimed else "always",
        )
    raise ValueError(f"no policy is called {name!r}")
