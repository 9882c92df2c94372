"""`regista clone`: behavior cloning of demonstrations to a checkpoint that `train --from` and `evaluate` take.

    regista clone demos/1v1Free --out runs/clone
    regista evaluate runs/clone
    regista train 1v1Free --method dr --from runs/clone

    clone.json       the `CloneConfig`
    cloning.csv      one row per epoch: losses and accuracies; cloning.png draws them
    accuracy.csv     one row per action, of held-out episodes
    cloning.pt       everything that is needed to go on; the same command does, after a kill, to the same tables
    config.json, checkpoint.pt    a run that was never trained

Read next: `ued.learning.cloning`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from regista.experiments.run import arguments, build, starting, versions
from regista.experiments.run import config as configs
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import TrainConfig, football_ppo
from regista.experiments.run.errors import CommandError, UsageError, read_from
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import Source, football_game
from regista.experiments.run.progress import Progress
from regista.experiments.run.signals import StopRequest
from regista.experiments.run.table import Table, cannot_write, spell
from ued.config import LARGEST_SEED, Checked, CloningConfig, PPOConfig, most_threads, setting
from ued.core.files import write_whole

if TYPE_CHECKING:
    from regista.experiments.run.cloning_data import CloningData
    from regista.experiments.run.demonstrations import Demonstrations
    from ued.learning.cloning import Agreement, Cloner

DESCRIPTION = "Let a student learn to do what was done in demonstrations; the result is a run that can be trained on."


@dataclass(frozen=True)
class CloneConfig(Checked):
    """What is typed after `regista clone`."""

    demonstrations: Path | None = positional("a folder of regista demonstrate", default=None)
    out: Path | None = setting(None, "run folder (default runs/MINIGAME-clone-SEED)")
    minigame: str | None = setting(None, "the minigame that the clone is to play; without, the demonstrations' own")
    preset: Literal["fast", "thesis"] = setting("fast", "starting point of the student's settings: fast, or thesis")
    seed: int = setting(0, "seed of weights, of shuffling and of which episodes are held out", ">=0", most=LARGEST_SEED)
    threads: int = setting(1, "threads for the networks", ">=1", most=most_threads)
    cloning: CloningConfig = group(CloningConfig, "cloning")
    ppo: PPOConfig = group(football_ppo, "the student, and PPO if it is trained on", prefix="ppo.")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    bases = {name: CloneConfig(ppo=preset.ppo) for name, preset in configs.presets().items()}
    base = bases.pop(starting.preset_of(argv))
    others = {f"with --preset {name}": [other] for name, other in bases.items()}
    config = arguments.replace_paths(base, arguments.typed_settings(base, argv, "clone", DESCRIPTION, others))
    if config.demonstrations is None:
        raise UsageError("clone needs a folder of demonstrations, such as demos/1v1Free")
    if config.ppo.memory != "none":
        raise CommandError(f"cloning teaches single steps: --ppo.memory must be none, got {config.ppo.memory}")
    from regista.experiments.run.cloning_data import CloningData
    from regista.experiments.run.demonstrations import Demonstrations

    demos = Demonstrations.open(config.demonstrations)
    versions.check_present(demos.simulator, f"{demos.path} was played on", "it cannot be cloned")
    data = CloningData(demos, config.cloning.gamma, config.cloning.validation, config.seed)
    method, run, source = _begin(config, demos, data)
    with StopRequest() as stop:
        clone(run, source, config, data, method, stop)
    if stop:
        print("stopped; the same command goes on")
    return stop.exit_code


def _begin(config: CloneConfig, demos: Demonstrations, data: CloningData) -> tuple[Any, RunFolder, Source]:
    """Return the method that holds the student, folder and program. Raises `CommandError` where they do not fit."""
    game = football_game(config.minigame or demos.config.minigame)
    minigame, base = game.name, game.start(config.preset)
    env = replace(demos.config.env, rewards=base.env.rewards)
    training = replace(
        base, minigame=minigame, method="dr", env=env, ppo=config.ppo, seed=config.seed, threads=config.threads
    )
    upomdp = build.make_upomdp(game.task(training).make, training.num_envs, training.seed)
    method = build.make_method(training, upomdp)
    seen, space = data.observation_shape, upomdp.single_observation_space
    if seen != space.shape or data.action_shape != upomdp.single_action_space.shape:
        raise CommandError(
            f"{demos.path} shows observations {list(seen)} of {demos.config.minigame}; {minigame} gives "
            f"{list(space.shape or ())}: the demonstrations are of another game"
        )
    stem = Path(minigame).stem if minigame.endswith(".scenic") else minigame
    path = config.out or Path("runs") / f"{stem}-clone-{config.seed}"
    run = _open(path, training, configs.to_dict(replace(config, out=None)))
    return method, run, game.source(training)


def _open(path: Path, training: TrainConfig, asked: dict[str, Any]) -> RunFolder:
    """Make the run folder, or go on with one that was begun with the same settings."""
    file, text = path / "clone.json", json.dumps(asked, indent=2) + "\n"
    if file.exists():
        if file.read_text(errors="replace") != text:
            raise CommandError(f"{path} holds a clone of other settings, those of {file}; choose another --out")
        run = RunFolder.open(path)
        versions.check_present(run.simulator, f"{path} was begun on", "it cannot be gone on with")
        return run
    run = RunFolder.create(path, training)
    try:
        write_whole(file, text)
    except OSError as error:
        raise cannot_write(file, error) from error
    return run


def clone(
    run: RunFolder, source: Source, config: CloneConfig, data: CloningData, method: Any, stop: StopRequest
) -> None:
    """Learn until the held-out loss no longer falls; leave tables, a picture and the checkpoint of the best epoch."""
    from regista.experiments.pictures.cloning import draw_cloning
    from ued.core.seeding import torch_generator
    from ued.learning.cloning import Cloner

    cloner = Cloner(method.student, config.cloning, torch_generator(config.seed))
    table, goes_on, elapsed = Table(run.path / "cloning.csv"), *_restore(run, cloner)
    lines = table.until(cloner.epoch)  # all is read before anything is written
    run.save_source(source)
    table.replace(lines)
    if goes_on:
        cloner.look_through(data.chunks(held_out=False))
    progress = Progress(config.cloning.epochs, cloner.epoch, unit="epochs")
    while goes_on and not stop:
        began = time.perf_counter()
        losses = cloner.learn(data.chunks(held_out=False, generator=cloner.generator))
        agreement = cloner.evaluate(data.chunks(held_out=True))
        goes_on = cloner.keep_if_best(agreement.loss)
        elapsed += time.perf_counter() - began
        table.append([_row(cloner, losses, agreement) | {"time/elapsed": elapsed}])
        _save(run, cloner, goes_on, elapsed)
        progress.show(cloner.epoch, {"loss": agreement.loss, "accuracy": agreement.accuracy})
    if stop and goes_on:
        return
    method.student.load_state_dict(cloner.best)
    agreement = cloner.evaluate(data.chunks(held_out=True))
    write_accuracies(run.path / "accuracy.csv", agreement)
    with read_from(f"{table.path} is"):
        draw_cloning(table.path, agreement, run.path / "cloning.png")
    kept = {"update": 0, "env_steps": 0, "elapsed": 0.0, **versions.stamp(run.config)}
    run.save({**kept, "method": method.state_dict()})
    progress.finish(
        f"{run.path}: {cloner.epoch} epochs, the best was {cloner.best_epoch}; of held-out steps "
        f"{agreement.accuracy:.2f} as done, over actions {agreement.balanced_accuracy:.2f}; "
        f"{data.episodes} episodes, {elapsed:.0f} s"
    )


def _row(cloner: Cloner, losses: dict[str, float], agreement: Agreement) -> dict[str, float]:
    """Return the row of an epoch; its number stands under `update`, as in every table that is cut back."""
    return {
        "update": cloner.epoch,
        "loss": losses["loss"],
        "value_loss": losses["value_loss"],
        "held_out/loss": agreement.loss,
        "held_out/value_loss": agreement.value_loss,
        "held_out/accuracy": agreement.accuracy,
        "held_out/balanced_accuracy": agreement.balanced_accuracy,
    }


def _restore(run: RunFolder, cloner: Cloner) -> tuple[bool, float]:
    """Go on from the last epoch, if there was one; return whether there is more to do, and the seconds spent."""
    from ued.core import checkpoint

    path = run.path / "cloning.pt"
    if not path.exists():
        return True, 0.0
    state = checkpoint.load(path)
    with read_from(f"{path} is"):
        cloner.load_state_dict(state["cloner"])
        return bool(state["goes_on"] or not cloner.best), float(state["elapsed"])


def _save(run: RunFolder, cloner: Cloner, goes_on: bool, elapsed: float) -> None:
    from ued.core import checkpoint

    checkpoint.save(run.path / "cloning.pt", {"cloner": cloner.state_dict(), "goes_on": goes_on, "elapsed": elapsed})


def write_accuracies(path: Path, agreement: Agreement) -> None:
    """Write how often each action was done in held-out episodes, and how often the student agrees."""
    from regista.envs.football.constants import ACTION_NAMES

    done, meant = agreement.counts.sum(1), agreement.counts.sum(0)
    lines = ["action,name,done,meant,recall,precision"]
    for action, name in enumerate(ACTION_NAMES):
        rates = agreement.recall[action], agreement.precision[action]
        lines.append(",".join([str(action), name, str(done[action]), str(meant[action]), *map(spell, rates)]))
    try:
        write_whole(path, "\n".join(lines) + "\n")
    except OSError as error:
        raise cannot_write(path, error) from error
