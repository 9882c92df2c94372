"""A stand-in for gfootball, run as `python fake_gfootball.py envs/grf/worker.py`: an engine of a few lines.

Players walk where they are told, the nearest one has the ball, chance is a stream from the seed. FAKE_GRF, a JSON
object, makes it misbehave: `do` (die, hang, garbage, refuse, version) at step `at` of the process, once if `once` names
a file that is not there yet. Read next: `regista.envs.grf.worker`.
"""

import importlib.metadata
import importlib.util
import json
import os
import random
import sys
import time
import types
from pathlib import Path
from typing import Any

import numpy as np

STDOUT = os.dup(1)  # before the worker takes it for its answers
PLAN = json.loads(os.environ.get("FAKE_GRF", "{}"))
STEPS = iter(range(1_000_000))
MOVES = [(0, 0), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1)]


class Builder:
    def __init__(self) -> None:
        self.settings, self.teams, self.side = types.SimpleNamespace(), {"left": [], "right": []}, "left"

    def config(self) -> Any:
        return self.settings

    def SetBallPosition(self, x: float, y: float) -> None:
        self.ball = [x, y]

    def SetTeam(self, side: str) -> None:
        self.side = side

    def AddPlayer(self, x: float, y: float, role: int, lazy: bool = False, controllable: bool = True) -> None:
        sign = 1 if self.side == "left" else -1
        self.teams[self.side].append((sign * x * 55 / 54.4, sign * y * 36 * 2.36 / 83.6, role, controllable))


class Config(dict):
    def __init__(self, values: dict[str, Any]) -> None:
        super().__init__(values)
        self.builder = Builder()
        sys.modules["gfootball.scenarios." + values["level"]].build_scenario(self.builder)


class Core:
    """What the worker uses of `FootballEnvCore`."""

    def __init__(self, config: Config) -> None:
        self.random, self.scene = random.Random(config["game_engine_random_seed"]), config.builder
        players = config["players"][0] if config["players"] else "agent:left_players=0,right_players=0"
        self.agents = [int(part.split("=")[1]) for part in players.split(",")]
        self.teams = [np.array(team, float).reshape(-1, 4) for team in self.scene.teams.values()]
        self.moves = [np.zeros((len(team), 2)) for team in self.teams]
        self.keys = [np.zeros(count, int) for count in self.agents]
        self.ball, self.step_number, self.score = np.array([*self.scene.ball, 0.11]), -1, [0, 0]
        self._env = types.SimpleNamespace(perform_action=self.perform)
        self._observation = self.observed()

    def perform(self, action: int, left: bool, agent: int) -> None:
        if 1 <= action <= 8:
            self.keys[0 if left else 1][agent] = action

    def step(self, actions: list[int]) -> tuple[Any, float, bool, dict]:
        misbehave()
        for number, action in enumerate(actions):
            left = number < self.agents[0]
            self.perform(action, left, number if left else number - self.agents[0])
        for team, keys in enumerate(self.keys):
            self.moves[team][:] = [[self.random.gauss(0, 1e-3), 0.0] for _ in self.moves[team]]
            for agent, key in enumerate(keys):
                self.moves[team][np.flatnonzero(self.teams[team][:, 3])[agent]] += 0.01 * np.array(MOVES[key])
            self.teams[team][:, :2] += self.moves[team]
        self.step_number += 1
        before = self.score[0]
        if self.ball[0] > 1.0:
            self.ball[:2], self.score = 0.0, [before + 1, 0]
        self._observation = self.observed()
        if self._observation["ball_owned_team"] >= 0:
            owner = self._observation["ball_owned_team"], self._observation["ball_owned_player"]
            self.ball[:2] = self.teams[owner[0]][owner[1], :2] + [0.01, 0.0]
            self._observation["ball"] = self.ball.copy()
        return None, float(self.score[0] - before), self.step_number >= self.scene.settings.game_duration, {}

    def observed(self) -> dict[str, Any]:
        gaps = [np.hypot(*(team[:, :2] - self.ball[:2]).T) if len(team) else np.array([9.0]) for team in self.teams]
        best = int(gaps[1].min() < gaps[0].min())
        owned = self.step_number >= 0 and gaps[best].min() < 0.03
        seen = {
            "ball": self.ball.copy(),
            "ball_direction": np.zeros(3),
            "ball_rotation": np.zeros(3),
            "game_mode": 0,
            "score": list(self.score),
            "steps_left": self.scene.settings.game_duration - self.step_number,
            "ball_owned_team": best if owned else -1,
            "ball_owned_player": int(gaps[best].argmin()) if owned else -1,
        }
        for side, team, moves, keys in zip(("left", "right"), self.teams, self.moves, self.keys, strict=True):
            count = len(team)
            seen[f"{side}_team"], seen[f"{side}_team_direction"] = team[:, :2].copy(), moves.copy()
            seen[f"{side}_team_tired_factor"] = np.zeros(count)
            seen[f"{side}_team_roles"] = team[:, 2].astype(int)
            seen[f"{side}_team_active"], seen[f"{side}_team_yellow_card"] = np.ones(count, bool), np.zeros(count, bool)
            seen[f"{side}_team_designated_player"] = count - 1
            seen[f"{side}_agent_controlled_player"] = np.flatnonzero(team[:, 3])[: len(keys)].tolist()
            seen[f"{side}_agent_sticky_actions"] = [np.append(np.arange(1, 9) == key, [0, 0]) for key in keys]
        return seen

    def close(self) -> None:
        print("closed an engine")  # as gfootball prints: not into the answers


def misbehave() -> None:
    once = PLAN.get("once")
    if next(STEPS) != PLAN.get("at") or (once and Path(once).exists()):
        return
    if once:
        Path(once).touch()
    if PLAN["do"] == "die":
        print("the pitch is under water", file=sys.stderr, flush=True)
        os._exit(3)
    if PLAN["do"] == "hang":
        time.sleep(1000)
    if PLAN["do"] == "garbage":
        os.write(STDOUT, b"Segmentation fault, or some such words")
    if PLAN["do"] == "refuse":
        raise AssertionError("the referee is ill")


def install() -> None:
    """Put the stand-ins where the worker imports gfootball from."""
    actions = [types.SimpleNamespace(_backend_action=number) for number in range(20)]
    contents: dict[str, dict[str, Any]] = {
        "gfootball": {},
        "gfootball.env": {},
        "gfootball.env.config": {"Config": Config},
        "gfootball.env.football_action_set": {"get_action_set": lambda config: actions},
        "gfootball.env.football_env_core": {"FootballEnvCore": Core},
        "gfootball_engine": {
            "e_Team": types.SimpleNamespace(e_Left="left", e_Right="right"),
            "e_PlayerRole": types.SimpleNamespace(
                **{
                    f"e_PlayerRole_{role}": number
                    for number, role in enumerate(("GK", "CB", "LB", "RB", "DM", "CM", "LM", "RM", "AM", "CF"))
                }
            ),
        },
    }
    for name, members in contents.items():
        sys.modules[name] = module = types.ModuleType(name)
        vars(module).update(members)
        parent, _, child = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], child, module)
    importlib.metadata.version = lambda name: "0"  # type: ignore[assignment]


if __name__ == "__main__":
    install()
    found = importlib.util.spec_from_file_location("worker", sys.argv[1])
    assert found is not None and found.loader is not None
    worker = importlib.util.module_from_spec(found)
    found.loader.exec_module(worker)
    if PLAN.get("do") == "version":
        worker.PROTOCOL = 99
    worker.main()
