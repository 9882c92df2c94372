"""`regista clone`: behavior cloning of demonstrations; `train --from` and `evaluate` accept the result.

    regista clone demos/1v1Free --out runs/clone
    regista evaluate runs/clone
    regista train 1v1Free --method dr --from runs/clone

    clone.json       the `CloneConfig`
    cloning.csv      one row per epoch: losses and accuracies; cloning.png draws them
    accuracy.csv     one row per action, on held-out episodes
    cloning.pt       the full training state; after a kill, the same command continues and gives the same tables
    config.json, checkpoint.pt    a run folder with zero training steps

Read next: `ued.learning.cloning`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from regista.experiments.pictures.plots import FORMAT_HELP, PictureFormat
from regista.experiments.run import arguments, build, starting, versions
from regista.experiments.run import config as configs
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.config import TrainConfig, football_ppo
from regista.experiments.run.errors import CommandError, UsageError, read_from
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import Source, football_game
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.progress import Progress, counted
from regista.experiments.run.table import Table, cannot_write, spell
from ued.config import LARGEST_SEED, Checked, CloningConfig, PPOConfig, most_threads, setting
from ued.core.files import write_whole

if TYPE_CHECKING:
    from regista.experiments.imitation.cloning_data import CloningData
    from regista.experiments.imitation.demonstrations import Demonstrations
    from ued.learning.cloning import Agreement, Cloner

DESCRIPTION = "Train a student on demonstrations by behavior cloning; regista train --from continues from the result."


@dataclass(frozen=True)
class CloneConfig(Checked):
    """Arguments of `regista clone`."""

    demonstrations: Path | None = positional("folder written by regista demonstrate", default=None)
    out: Path | None = setting(None, "run folder (default runs/MINIGAME-clone-SEED)")
    minigame: str | None = setting(None, "minigame of the clone (default: that of the demonstrations)")
    preset: Literal["fast", "thesis"] = setting("fast", "preset of the student")
    seed: int = setting(0, "seed of the weights, the shuffling and the held-out split", ">=0", most=LARGEST_SEED)
    threads: int = setting(1, "threads for the networks", ">=1", most=most_threads)
    format: PictureFormat = setting("png", FORMAT_HELP)
    cloning: CloningConfig = group(CloningConfig, "cloning")
    ppo: PPOConfig = group(football_ppo, "network of the student, and PPO for later training", prefix="ppo.")


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    bases = {name: CloneConfig(ppo=preset.ppo) for name, preset in configs.presets().items()}
    base = bases.pop(starting.preset_of(argv))
    others = {f"with --preset {name}": [other] for name, other in bases.items()}
    config = arguments.replace_paths(base, arguments.typed_settings(base, argv, "clone", DESCRIPTION, others))
    if config.demonstrations is None:
        raise UsageError("clone needs a folder of demonstrations, such as demos/1v1Free")
    if config.ppo.memory != "none":
        raise CommandError(f"cloning supports no memory: --ppo.memory must be none, got {config.ppo.memory}")
    from regista.experiments.imitation.cloning_data import CloningData
    from regista.experiments.imitation.demonstrations import Demonstrations

    demos = Demonstrations.open(config.demonstrations)
    versions.check_present(demos.simulator, f"{demos.path} was recorded on", "it cannot be cloned")
    data = CloningData(demos, config.cloning.gamma, config.cloning.validation, config.seed)
    method, run, source = _begin(config, demos, data)
    with StopRequest() as stop:
        clone(run, source, config, data, method, stop)
    if stop:
        print("stopped; run the same command to continue")
    return stop.exit_code


def _begin(config: CloneConfig, demos: Demonstrations, data: CloningData) -> tuple[Any, RunFolder, Source]:
    """Return the method with the student, the run folder and the program.

    Raises `CommandError` if the demonstrations do not match the game.
    """
    game = football_game(config.minigame or demos.config.minigame)
    minigame, base = game.name, game.start(config.preset)
    env = replace(demos.config.env, rewards=base.env.rewards)
    training = replace(
        base, minigame=minigame, method="dr", env=env, ppo=config.ppo, seed=config.seed, threads=config.threads
    )
    if game.name == demos.config.minigame:
        training = replace(training, program=demos.config.program)
    upomdp = build.make_upomdp(game.task(training).make, training.num_envs, training.seed)
    method = build.make_method(training, upomdp)
    seen, space = data.observation_shape, upomdp.single_observation_space
    if seen != space.shape or data.action_shape != upomdp.single_action_space.shape:
        raise CommandError(
            f"{demos.path} holds observations {list(seen)} of {demos.config.minigame}; {minigame} has "
            f"{list(space.shape or ())}: the demonstrations belong to another game"
        )
    data.opponents = upomdp.individual_rewards
    stem = Path(minigame).stem if minigame.endswith(".scenic") else minigame
    path = config.out or Path("runs") / f"{stem}-clone-{config.seed}"
    asked = configs.to_dict(replace(config, out=None))
    del asked["format"]  # a setting of the picture only
    run = _open(path, training, asked)
    return method, run, game.source(training)


def _open(path: Path, training: TrainConfig, settings: dict[str, Any]) -> RunFolder:
    """Create the run folder, or continue one that has the same settings."""
    file, text = path / "clone.json", json.dumps(settings, indent=2) + "\n"
    if file.exists():
        if file.read_text(errors="replace") != text:
            raise CommandError(f"{path} holds a clone with other settings, see {file}; choose another --out")
        run = RunFolder.open(path)
        versions.check_present(run.simulator, f"{path} was started on", "it cannot be continued")
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
    """Train until the held-out loss stops falling; write tables, a picture and the checkpoint of the best epoch."""
    from regista.experiments.imitation.picture import draw_cloning
    from ued.core.seeding import torch_generator
    from ued.learning.cloning import Cloner

    cloner = Cloner(method.student, config.cloning, torch_generator(config.seed))
    table, goes_on, elapsed = Table(run.path / "cloning.csv"), *_restore(run, cloner, data)
    lines = table.until(cloner.epoch)  # read everything before writing anything
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
        _save(run, cloner, data, goes_on, elapsed)
        progress.show(cloner.epoch, {"loss": agreement.loss, "accuracy": agreement.accuracy})
    if stop and goes_on:
        return
    method.student.load_state_dict(cloner.best)
    agreement = cloner.evaluate(data.chunks(held_out=True))
    write_accuracies(run.path / "accuracy.csv", agreement)
    with read_from(f"{table.path} is"):
        draw_cloning(table.path, agreement, run.path / f"cloning.{config.format}")
    saved = {"update": 0, "env_steps": 0, "elapsed": 0.0, **versions.stamp(run.config)}
    run.save({**saved, "method": method.state_dict()})
    progress.finish(
        f"{run.path}: {counted(cloner.epoch, 'epoch')}, best epoch {cloner.best_epoch}; held-out accuracy "
        f"{agreement.accuracy:.2f}, balanced accuracy {agreement.balanced_accuracy:.2f}; "
        f"{counted(data.episodes, 'episode')}, {elapsed:.0f} s"
    )


def _row(cloner: Cloner, losses: dict[str, float], agreement: Agreement) -> dict[str, float]:
    """Return the table row of an epoch; the epoch is in column `update`, by which tables are cut back."""
    return {
        "update": cloner.epoch,
        "loss": losses["loss"],
        "value_loss": losses["value_loss"],
        "held_out/loss": agreement.loss,
        "held_out/value_loss": agreement.value_loss,
        "held_out/accuracy": agreement.accuracy,
        "held_out/balanced_accuracy": agreement.balanced_accuracy,
    }


def _restore(run: RunFolder, cloner: Cloner, data: CloningData) -> tuple[bool, float]:
    """Restore the last saved epoch, if any; return whether training continues, and the seconds spent so far.

    Raises `CommandError` if episodes were added since: some former training episodes would now be held out.
    """
    from ued.core import checkpoint

    path = run.path / "cloning.pt"
    if not path.exists():
        return True, 0.0
    state = checkpoint.load(path)
    saw = state.get("episodes", data.episodes)  # unknown in older files
    if saw != data.episodes:
        raise CommandError(
            f"{run.path} was cloned from {saw} episodes, {data.demos.path} now has {data.episodes}; choose another "
            "--out"
        )
    with read_from(f"{path} is"):
        cloner.load_state_dict(state["cloner"])
        return bool(state["goes_on"] or not cloner.best), float(state["elapsed"])


def _save(run: RunFolder, cloner: Cloner, data: CloningData, goes_on: bool, elapsed: float) -> None:
    from ued.core import checkpoint

    progress = {"goes_on": goes_on, "elapsed": elapsed, "episodes": data.episodes}
    checkpoint.save(run.path / "cloning.pt", {"cloner": cloner.state_dict(), **progress})


def write_accuracies(path: Path, agreement: Agreement) -> None:
    """Write for each action its count in held-out episodes, and the recall and precision of the student."""
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
