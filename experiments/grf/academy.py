"""Whole episodes: how often scripted policies, and the built-in players, score on the academy scenes.

Read next: `grf.matches`, eleven against eleven.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from regista.envs.football.constants import BUILTIN_AI, OUT_OF_PLAY, RUNNING, STAND
from regista.envs.football.simulator import step_everybody, step_matches
from regista.experiments.grf.figures import Panel, draw_panels
from regista.experiments.grf.policies import Policy, policy_named
from regista.experiments.grf.report import read_data
from regista.experiments.grf.rows import Row, by_distance
from regista.experiments.grf.scenes import ACADEMY, SCENES, stage_scene

TITLE = "academy scenes"
REQUIRED = 0.8  # share of the rows that should be within tolerance
TOLERANCE = 0.12
EPISODES = 400
LAZY_EPISODES = 60  # of 3000 steps


@dataclass(frozen=True)
class Outcomes:
    """How N episodes ended."""

    scored: np.ndarray  # [N] bool, by the left team
    length: np.ndarray  # [N], steps
    ended: np.ndarray  # [N], as in `constants.RUNNING` ..
    mode: np.ndarray  # [N], game mode at the end


def measure(effort: float = 1.0) -> list[Row]:
    """Compare the goal rates; `effort` below 1 plays fewer episodes."""
    return [
        by_distance(
            "academy",
            f"{target['scene']} {target['policy']}",
            float(play_policy(target["scene"], target["policy"], effort).scored.mean()),
            int(target["goals"]) / int(target["episodes"]),
            "goal rate",
            TOLERANCE,
        )
        for target in read_data("academy")
    ]


def play_policy(scene: str, policy: str, effort: float = 1.0) -> Outcomes:
    """Play episodes of a scene by a policy, `builtin_ai` for the built-in players."""
    episodes = LAZY_EPISODES if SCENES[scene].lazy else EPISODES
    n = max(round(episodes * effort), 4)
    if policy == "builtin_ai":
        return play_built_in(scene, n)
    if SCENES[scene].lazy:
        return play_against_lazy(scene, policy_named(policy), n)
    matches, keys = stage_scene(scene, ACADEMY, n).matches, policy_named(policy)
    keys.begin(n, 0)
    step = 0
    while (matches["ended"] == RUNNING).any():
        step_matches(matches, keys(matches, step)[:, None])
        step += 1
    return outcomes(matches)


def play_built_in(scene: str, n: int) -> Outcomes:
    """Play episodes in which the built-in players have both teams, or only the left one against lazy players."""
    stage = stage_scene(scene, replace(ACADEMY, control="none"), n)
    teams = stage.matches["players"]["team"][:, : stage.num_players]
    actions = np.where((teams == 1) & SCENES[scene].lazy, STAND, BUILTIN_AI)
    while (stage.matches["ended"] == RUNNING).any():
        step_everybody(stage.matches, actions)
    return outcomes(stage.matches)


def play_against_lazy(scene: str, policy: Policy, n: int) -> Outcomes:
    """Play episodes by a policy whose mates are built-in players, against players who stand still."""
    stage = stage_scene(scene, ACADEMY, n)
    teams = stage.matches["players"]["team"][:, : stage.num_players]
    policy.begin(n, 0)
    step = 0
    while (stage.matches["ended"] == RUNNING).any():
        actions = np.where(teams == 1, STAND, BUILTIN_AI)
        actions[np.arange(n), stage.matches["agents"][:, 0]] = policy(stage.matches, step)
        step_everybody(stage.matches, actions)
        step += 1
    return outcomes(stage.matches)


def outcomes(matches: np.ndarray) -> Outcomes:
    """Read how episodes ended from their records."""
    length, ended, mode = (matches[name].copy() for name in ("step", "ended", "game_mode"))
    return Outcomes(matches["score"][:, 0] > 0, length, ended, mode)


def ends(outcomes: Outcomes) -> dict[str, int]:
    """Count what ended episodes, by the original's words."""
    words = {1: "score", 3: "possession", 4: "time"}
    names = [
        f"out_{mode}" if end == OUT_OF_PLAY else words[int(end)]
        for end, mode in zip(outcomes.ended, outcomes.mode, strict=True)
    ]
    return {name: names.count(name) for name in sorted(set(names), key=names.count, reverse=True)}


def figure(path: Path, effort: float = 1.0) -> None:
    """Draw goal rates and median lengths of all policies, in the order of the table."""
    targets = read_data("academy")
    outcomes = [play_policy(target["scene"], target["policy"], effort) for target in targets]
    order = np.arange(len(targets))
    rates = [int(target["goals"]) / int(target["episodes"]) for target in targets]
    lengths = [float(target["median_length"]) for target in targets]
    panels = [
        Panel("goal rate", (order, rates), (order, [one.scored.mean() for one in outcomes]), "row", "", points=True),
        Panel(
            "median length",
            (order, lengths),
            (order, [np.median(one.length) for one in outcomes]),
            "row",
            "steps",
            points=True,
        ),
    ]
    draw_panels(path, TITLE, panels)
