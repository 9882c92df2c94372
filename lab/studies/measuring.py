"""Play a run, the random policy or a semi-expert program on all scenes of a minigame, and make rows of the results.

Results count goals, whatever the rewards of training. All policies play the same levels. Read next:
`lab/studies/rows.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lab.studies.rows import TRAIN, Point, Row
from regista.envs.football.version import version_on
from regista.experiments.run import build, versions
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.evaluator import EvalScenes, load_student
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import find_minigame
from regista.experiments.run.provenance import commit, processor_of
from regista.experiments.run.table import read_columns
from ued.core.task import TRAINING_SCENE

TEAM = "team_"  # prefix of the names of agents
HELD_OUT = "held out, "  # prefix of the names of scenes that are never used for tuning
TEAM_SETTINGS: dict[str, dict[str, Any]] = {  # of teams trained from scratch, by kind
    "ppo": {},  # independent policies and critics, as in the thesis
    "shared_ppo": {"ppo.team": "shared"},
    "mappo": {"ppo.critic": "central"},
    "shared_mappo": {"ppo.team": "shared", "ppo.critic": "central"},
}

if TYPE_CHECKING:
    from regista.envs.football.config import FootballConfig
    from regista.minigames.suites import Minigame
    from ued.config import PPOConfig
    from ued.evaluation import Evaluation


def measure_run(run: RunFolder, episodes: int) -> list[Row]:
    """Play `episodes` episodes of a trained run on each scene of its minigame."""
    game = build.find_game(run.config.minigame)
    student, (env_steps, _) = load_student(run, game)
    evaluations = EvalScenes(run.config, game, episodes).play(student)
    return rows_of(run.config, evaluations, about_run(run, agent_of(run), env_steps))


def about_run(run: RunFolder, agent: str, env_steps: int) -> dict[str, Any]:
    """Return the columns of a row that belong to a trained run."""
    about = {"agent": agent, "seed": run.config.seed, "env_steps": env_steps, "seconds": round(run.seconds(), 3)}
    return about | {"processor": processor_of(run.about)}


def agent_of(run: RunFolder) -> str:
    """Return the name of an agent in tables, by its training and whether it is a team."""
    trained = {"clone": "cloned", "dr fine-tuned": "pretrained"}.get(run.label)
    if run.config.env.control == find_minigame(run.config.minigame).control:
        return trained or "ppo"
    return TEAM + (trained or team_kind(run.config.ppo))


def team_kind(config: PPOConfig) -> str:
    """Return the name of a team's algorithm: whether policies are shared, and whether the critic is central."""
    return ("shared_" if config.team == "shared" else "") + ("mappo" if config.critic == "central" else "ppo")


def measure_variant(run: RunFolder, agent: str, episodes: int, held_out: bool) -> tuple[list[Row], list[Point]]:
    """Play a run on random levels and on scenes of its game; return rows, and its learning curve.

    `held_out`: on the game's held-out scenes, or on its test scenes if it has no others. Such rows are named `held out,
    ...`. No tuning run may be played on them. In a game without further test scenes, tuning plays only random levels
    and has no curve.
    """
    game = build.find_game(run.config.minigame)
    student, (env_steps, _) = load_student(run, game)
    has_held_out = bool(game.task(run.config.scored()).held_out)
    scenes = EvalScenes(run.config, game, episodes, held_out and has_held_out)
    played = scenes.play(student, None if held_out or has_held_out else [TRAINING_SCENE])
    if held_out:
        played = {
            label if label == TRAINING_SCENE else f"{HELD_OUT}{label}": result for label, result in played.items()
        }
    rows = rows_of(run.config, played, about_run(run, agent, env_steps))
    return rows, learning_curve(run, agent) if held_out or has_held_out else []


def learning_curve(run: RunFolder, agent: str) -> list[Point]:
    """Return the mean success over the test scenes after each evaluation of a run's training."""
    table = read_columns(run.metrics.path)
    named = {name.removeprefix("eval_success/"): value for name, value in table.items() if "eval_success/" in name}
    scenes = np.stack([values for label, values in named.items() if label != TRAINING_SCENE])  # [S, U]
    tested = np.flatnonzero(np.isfinite(scenes).all(0))
    student = next(
        values for name, values in table.items() if name.endswith("/trained_steps")
    )  # the tested student is first
    trained = np.cumsum(np.nan_to_num(student))
    columns = (table["env_steps"], table["time/elapsed"], scenes.mean(0))
    about = (run.config.minigame, agent, run.config.seed)
    version = versions.spelled(versions.present_version(run.config))
    return [
        Point(*about, int(columns[0][u]), round(columns[1][u], 1), round(columns[2][u], 4), version, int(trained[u]))
        for u in tested
    ]


def measure_random(config: TrainConfig, episodes: int) -> list[Row]:
    """Play `episodes` random-policy episodes on each scene of a minigame, with the players that a run moves."""
    scenes = EvalScenes(config, build.find_game(config.minigame), episodes)
    policy = scenes.task.make_baselines(scenes.scenes[TRAINING_SCENE])["random"]
    return rows_of(config, scenes.play(policy), {"agent": "random", "seed": 0, "env_steps": 0, "seconds": 0.0})


def measure_experts(game: Minigame, episodes: int) -> list[Row]:
    """Play `episodes` episodes of each of a game's semi-expert programs."""
    from lab.grf.experts import OURS, Expert, play_expert

    rows = []
    for agent, path in (("expert", game.expert), ("team_expert", game.team_expert)):
        if path is not None:
            played = play_expert(Expert(path.stem, agent == "team_expert", 0.0, None), OURS, episodes)
            difference = (played.score[:, 0] - played.score[:, 1]).astype(float)
            row = _row(difference, played.lengths, OURS)
            rows.append(Row(game=game.name, agent=agent, scene=TRAIN, seed=0, env_steps=0, seconds=0.0, **row))
    return rows


def rows_of(config: TrainConfig, evaluations: Mapping[str, Evaluation], about: dict[str, Any]) -> list[Row]:
    """Return a row for each played scene of a run, with the policy's data from `about`."""
    rows = []
    for label, evaluation in evaluations.items():
        scene = TRAIN if label == TRAINING_SCENE else label
        measured = _row(evaluation.returns, evaluation.lengths, config.env)
        rows.append(Row(game=config.minigame, scene=scene, **about, **measured))
    return rows


def _row(difference: np.ndarray, lengths: np.ndarray, env: FootballConfig) -> dict[str, Any]:
    """Return the measured columns of a row from goal differences `[E]` and lengths `[E]` of episodes."""
    return {
        "control": env.control,
        "episodes": len(difference),
        "goal_difference": round(float(difference.mean()), 6),
        "deviation": round(float(difference.std()), 6),
        "scored": int((difference > 0).sum()),
        "conceded": int((difference < 0).sum()),
        "mean_length": round(float(lengths.mean()), 3),
        "commit": commit(),
        "simulator": versions.spelled(version_on(env.engine)),
    }
