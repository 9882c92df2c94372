"""Train the policies that are installed with Regista, `shipped:NAME`, write their files, and tabulate them.

    make policies                        # all of POLICIES
    python -m lab.policies maze          # some of them

A policy is trained in a folder of `--runs`; its student goes to a folder of `--out` that `regista play` and `regista
evaluate` read. The table of `--page` has all policies of `--out`. Policies of another simulator version must be trained
again: remove their folders from `--runs` first. Read next: `regista.experiments.run.shipped`.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from lab.studies.cells import percent
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.__main__ import main as regista
from regista.experiments.commands.evaluate import EvaluateConfig, evaluator
from regista.experiments.run import config as configs
from regista.experiments.run import shipped, versions
from regista.experiments.run.errors import nearest
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.results import Counted, Result, goal_rate
from ued.core import checkpoint
from ued.core.task import TRAINING_SCENE


class Recipe(NamedTuple):
    """Settings for training a policy; without `flags`, the defaults of `regista train GAME`."""

    method: str
    env_steps: int
    flags: tuple[str, ...] = ()


POLICIES = {  # by game, one for each suite
    "1v1Restricted": Recipe("dr", 1_500_000),
    "offense/11_vs_gk": Recipe("dr", 1_500_000),
    "defense/hesitant_dribble": Recipe("dr", 2_000_000),
    "grf/run_to_score": Recipe("dr", 1_000_000),
    "academy/run_to_score": Recipe("dr", 1_000_000, ("--rewards", "scoring,checkpoints")),
    "maze": Recipe("accel", 5_000_000),
}
SEED = 0
PAGE = Path("docs/games.md")
KEPT = ("update", "env_steps", "spaces", versions.KEY)  # fields of a checkpoint, besides its student


def train(game: str, recipe: Recipe, path: Path) -> RunFolder:
    """Return the trained run of a policy; a stopped run is continued. Raises `SystemExit` if it is stopped again."""
    begun = ["--resume", str(path)] if (path / "config.json").exists() else command(game, recipe)
    if regista(["train", *begun, *([] if begun[0] == "--resume" else ["--out", str(path)])]):
        raise SystemExit(f"the training of {game} has not finished")
    return RunFolder.open(path)


def command(game: str, recipe: Recipe) -> list[str]:
    """Return the arguments of `regista train` for a policy."""
    words = [game, "--method", recipe.method, "--total-env-steps", str(recipe.env_steps), "--seed", str(SEED)]
    return [*words, "--no-record", "--eval-every", "0", *recipe.flags]


def ship(run: RunFolder, folder: Path, words: Sequence[str]) -> None:
    """Write a run's settings and its students to a folder, without history or data about the machine."""
    state = run.load()
    assert state is not None
    learners = [
        {"agents": learner["agents"], "ppo": {"student": learner["ppo"]["student"]}}
        for learner in state["method"]["learners"]
    ]
    kept = {name: state[name] for name in KEPT if name in state}
    about = {"command": " ".join(["regista", "train", *words])} | versions.stamp(run.config)
    folder.mkdir(parents=True, exist_ok=True)
    student = {"config": configs.to_dict(run.config), "elapsed": 0.0, "method": {"learners": learners}}
    checkpoint.save(folder / "checkpoint.pt", kept | student)
    configs.save(run.config, folder / "config.json", about)


# ---------------------------------------------------------------- table


def row(name: str, folder: Path, episodes: int) -> list[str]:
    """Return the table row of a policy: its success and the random policy's, on training and on test levels."""
    run = RunFolder.open(folder)
    report = evaluator(run.config, EvaluateConfig(episodes=episodes, levels=0)).report([run])
    rates = [
        success([r for r in report.results if r.method == policy and (r.scene == TRAINING_SCENE) == training])
        for training in (True, False)
        for policy in (run.label, "random")
    ]
    return [f"`{name}`", f"`{run.config.method}`, {report.results[0].env_steps / 1e6:.1f}M", *rates]


def success(results: Sequence[Result]) -> str:
    """Return the success rate over the episodes of all scenes with its interval; a dash without scenes."""
    if not results:
        return "–"
    played = Counted(sum(one.goals for one in results), sum(one.episodes for one in results))
    return percent(goal_rate([played]))


def table(folders: dict[str, Path], episodes: int) -> str:
    """Return the table of policies in Markdown, by name."""
    head = ["policy", "method, steps", "training levels", "random policy", "test scenes", "random policy"]
    rows = as_markdown([head, *(row(name, folder, episodes) for name, folder in folders.items())])
    note = (
        f"Success rates over {episodes} episodes on training levels and on each test scene, with Wilson's 95% "
        f"intervals over episodes; one training seed, {SEED}. Football is simulator version {SIMULATOR_VERSION}. Made "
        f"by `make policies`."
    )
    return f"{rows}\n\n{note}"


def main(argv: Sequence[str] | None = None) -> None:
    """Train, ship and evaluate the policies."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("games", nargs="*", help="games to train on (default: all)")
    parser.add_argument("--runs", type=Path, default=Path("runs/policies"), help="folder of the trainings")
    parser.add_argument("--out", type=Path, default=shipped.FOLDER, help="folder of the policies")
    parser.add_argument("--page", type=Path, default=PAGE, help="page with the table")
    parser.add_argument("--env-steps", type=int, help="train each for this many steps, for a test")
    parser.add_argument("--episodes", type=int, default=500, help="episodes of each evaluation")
    typed = parser.parse_args(argv)
    for game in typed.games or POLICIES:
        if game not in POLICIES:
            parser.error(f"no policy is made for {game}{nearest(game, POLICIES)}; known: {', '.join(POLICIES)}")
        recipe = POLICIES[game]._replace(**({"env_steps": typed.env_steps} if typed.env_steps else {}))
        run = train(game, recipe, typed.runs / game.replace("/", "_"))
        ship(run, typed.out / game, command(game, recipe))
    made = {f"{shipped.PREFIX}{game}": typed.out / game for game in POLICIES if (typed.out / game).is_dir()}
    text = table(made, typed.episodes)
    page = typed.page.read_text()
    write_text(typed.page, re.sub(r"(<!-- policies -->\n).*?(<!-- end -->)", rf"\g<1>{text}\n\g<2>", page, flags=re.S))


if __name__ == "__main__":
    main()
