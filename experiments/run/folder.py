"""The run folder: what a training run leaves behind, and how it continues after a kill.

    config.json       the TrainConfig, enough to start the run over; `about`: id, command, commit, versions, machine,
                      and the version of the simulator
    program.scenic    the text of the program, as it was when the run began; task.py of a task of one's own
    metrics.csv       one row per update; where students were tested, eval_env_steps is what that took, beside env_steps
    levels.csv        one row per level that was played: where from, θ in [-1, 1], returns, score
    events.csv        what somebody should know, if anything: see `run.events`
    replays.csv       what students did on the levels of the highest scores: see `run.replays`
    checkpoint.pt     everything that `train` needs to continue; replaced in one step
    origin.pt         the student that it began with and how close it stays, if it was begun with one
    curriculum.rrd    the recording for the Rerun viewer; a resumed run adds curriculum.2.rrd and so on
    tensorboard/, wandb/   what `--report` tells these
    learning_curve.png
    owner.json        who trains it, while somebody does: see `run.launch.owner`

docs/files.md has the columns of the tables.
The tables may be ahead of the checkpoint when a run is killed; resuming cuts them back to it, so that a killed and
resumed run ends with the table of one that was left alone. Wall-clock columns (`time/...`) differ, of course.
Read next: `commands.train`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from regista.experiments.run import config as configs
from regista.experiments.run import provenance, trust, versions
from regista.experiments.run.config import ConfigError, TrainConfig
from regista.experiments.run.errors import CommandError
from regista.experiments.run.launch.owner import OWNER, owned
from regista.experiments.run.launch.signals import CHILD_GRACE_SECONDS
from regista.experiments.run.table import Table, cannot_write, check_files, read_columns
from ued.core.files import is_partial, write_whole
from ued.methods import METHODS

if TYPE_CHECKING:
    from regista.experiments.run.games import Source


class RunFolder:
    """One run on disk. `RunFolder.create` starts one, `RunFolder.open` continues one."""

    def __init__(self, path: Path, config: TrainConfig, about: Mapping[str, Any] | None = None) -> None:
        self.path, self.about = path, about or {}
        self.config: Any = config  # a `TaskTrainConfig` for a task in Python
        self._kept: Any = config  # what config.json says
        self.metrics = Table(path / "metrics.csv")
        self.levels = Table(path / "levels.csv")
        self.events = Table(path / "events.csv")
        self.replays = Table(path / "replays.csv")
        self.saved_update = 0
        self._saved_at = time.monotonic()

    @classmethod
    def create(
        cls, path: Path, config: TrainConfig, prepare: Callable[[RunFolder], None] = lambda run: None
    ) -> RunFolder:
        """Make the folder and write its configuration; what else it needs, `prepare` writes before.

        For where there is a configuration, the run can be resumed. Raises `CommandError` if there is a run already.
        """
        run = cls(path, config, provenance.about() | versions.stamp(config))
        if run.begun():
            raise CommandError(f"{path} holds a run already; continue it with --resume {path}, or choose another --out")
        names = [entry.name for entry in path.iterdir()] if path.is_dir() else []
        foreign = any(name not in UNTRAINED and not is_partial(name) for name in names) or path.is_file()
        if foreign:
            raise CommandError(f"{path} exists and is no run folder; choose another --out")
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path, error) from error
        with run.locked():
            run._kept = None
            prepare(run)
            run.save_config()
        return run

    @classmethod
    def create_or_extend(cls, path: Path, config: TrainConfig) -> RunFolder:
        """Make a folder that is not there yet; continue another with this configuration, with which it must agree."""
        if not (path / "config.json").exists():
            return cls.create(path, config)
        run = cls.open(path)
        run.extend(config)
        with run.locked():
            run.save_config()
        return run

    @classmethod
    def open(cls, path: Path) -> RunFolder:
        """Open an existing run. Raises `CommandError` for a folder that holds none."""
        if not (path / "config.json").exists():
            raise CommandError(f"{path} is no run folder: it has no config.json")
        check_files(path)
        return cls(path, configs.load(None, path / "config.json"), configs.about(path / "config.json"))

    @property
    def simulator(self) -> int | None:
        """The version of the simulator that it plays on; 0 from before there was one, None if it plays no football of
        ours.
        """
        return versions.saved_version(self.config, self.about, f"{self.path / 'config.json'}: '{configs.ABOUT}'")

    def extend(self, config: TrainConfig) -> None:
        """Continue with a longer budget or other bookkeeping; nothing that changes the numbers may differ.

        The folder has it from `save_config` on: one that turns out damaged is left as it was. Raises `CommandError` for
        a run of another version of the simulator.
        """
        if self.begun():
            versions.check_present(self.simulator, f"{self.path} was trained on", EVALUATED_ALONE)
        elif self.simulator != versions.present_version(self.config):
            self.about, self._kept = {**self.about, **versions.stamp(self.config)}, None
        others = {row.group for row in METHODS.values()} - {METHODS[self.config.method].group}
        for name, (old, new) in configs.differences(self.config, config).items() if self.begun() else ():
            of_others = name.partition(".")[0] in others
            if name not in MAY_CHANGE and not of_others:
                raise ConfigError(f"{self.path} was trained with {name} = {old}; it cannot continue with {new}")
        self.config = config

    def save_config(self) -> None:
        """Write the settings, if they are others than the folder has; whoever does has the folder `locked`."""
        if self.config == self._kept:
            return
        path = self.path / "config.json"
        try:
            configs.save(self.config, path, self.about)
        except OSError as error:
            raise cannot_write(path, error) from error
        self._kept = self.config

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep others from training this run meanwhile, here or elsewhere. Raises `BusyError` if one does already."""
        with owned(self.path):
            yield

    @property
    def argv(self) -> list[str]:
        """What is typed behind `regista` to train it on, wherever that is."""
        engine = getattr(getattr(self.config, "env", None), "grf_python", None)  # as it was typed here: no file says it
        typed = ["--grf-python", engine] if engine else []
        return ["train", "--resume", str(self.path.resolve()), *typed, *trust.flags(self.config.minigame)]

    def save_source(self, source: Source) -> None:
        """Save the text of what is trained on beside a run that begins.

        Raises `CommandError` if a run began with another text that may not change; Python files may.
        """
        kept = self.path / source.file
        if not self.begun():
            try:
                write_whole(kept, source.text)
            except OSError as error:
                raise cannot_write(kept, error) from error
        elif source.frozen and kept.exists() and kept.read_text(errors="replace") != source.text:
            raise CommandError(f"{self.config.minigame} has changed since {self.path} began with what is now in {kept}")

    @property
    def picture(self) -> Path:
        return self.path / "learning_curve.png"

    # ------------------------------------------------------------ the checkpoint

    @property
    def checkpoint(self) -> Path:
        return self.path / "checkpoint.pt"

    def load(self) -> dict[str, Any] | None:
        """Return the checkpoint, None if the run has none yet. Raises `CheckpointError` for one that is damaged."""
        from ued.core import checkpoint

        if not self.checkpoint.exists():
            return None
        state = checkpoint.load(self.checkpoint)
        for name in COUNTERS:
            value: Any = state.get(name)
            if type(value) not in (int, float) or not 0 <= value < LARGEST:
                raise checkpoint.CheckpointError(f"{self.checkpoint} is damaged: its {name} is {value!r}")
        return state

    def cut_back(self, update: int) -> None:
        """Cut the tables back to an update, that of the checkpoint from which the run goes on.

        Raises `CommandError` where one of them is damaged; then all are left as they were.
        """
        read_columns(self.metrics.path)
        tables = (self.metrics, self.levels, self.events, self.replays)
        cuts = [table.until(update) for table in tables]
        self.saved_update = update
        for table, lines in zip(tables, cuts, strict=True):
            table.replace(lines)

    def save(self, state: dict[str, Any]) -> None:
        """Replace the checkpoint in one step. Raises `CheckpointError` if the disk refuses; the old one stays."""
        from ued.core import checkpoint

        checkpoint.save(self.checkpoint, {"config": configs.to_dict(self.config), **state})
        self.saved_update = state["update"]
        self._saved_at = time.monotonic()

    @property
    def label(self) -> str:
        """What a table calls the run: its method, and whether it is a clone or began with another run's student."""
        if (self.path / "clone.json").exists():
            return "clone"
        return f"{self.config.method} fine-tuned" if (self.path / "origin.pt").exists() else self.config.method

    def checkpoint_due(self, update_seconds: float = 0.0) -> bool:
        """Return whether the last checkpoint is older than `checkpoint_seconds`, or updates take so long.

        A signal may not wait for the end of a long one: then there is what the one before left.
        """
        old = time.monotonic() - self._saved_at >= self.config.checkpoint_seconds
        return old or update_seconds > CHILD_GRACE_SECONDS / 2

    def finished(self) -> bool:
        """Return whether the checkpoint is at the end of the budget, and the picture is drawn, which comes last."""
        if not (self.checkpoint.exists() and self.picture.exists()):
            return False
        from ued.core import checkpoint

        done = checkpoint.load_entry(self.checkpoint, "env_steps")
        if not isinstance(done, int):
            raise checkpoint.CheckpointError(f"{self.checkpoint} is damaged: its env_steps is {done!r}")
        return done >= self.config.total_env_steps

    def begun(self) -> bool:
        """Return whether anything was trained here: a run that failed before its first update leaves the name free."""
        return self.metrics.path.exists() or self.checkpoint.exists()

    def env_steps(self) -> int:
        """Return the env_steps of the last row of metrics.csv, 0 if there is none."""
        return int(self._last("env_steps"))

    def seconds(self) -> float:
        """Return how long was trained by the last row of metrics.csv, 0 if there is none."""
        return self._last("time/elapsed")

    def _last(self, name: str) -> float:
        column = read_columns(self.metrics.path).get(name)
        last = 0.0 if column is None or not len(column) else float(column[-1])
        if not 0 <= last < LARGEST:
            raise CommandError(f"{self.metrics.path} is damaged: its last {name} is {last}")
        return last

    def recordings(self) -> list[Path]:
        """Return the parts of the recording that are there."""
        return list(self.path.glob("curriculum*.rrd"))

    @property
    def recording_id(self) -> str:
        """What its recordings are called among those of others: a viewer merges those of one id."""
        return f"regista-{self.about.get('id') or self.path.resolve()}"

    def next_recording(self) -> Path:
        """Return the path for the next part of the recording: curriculum.rrd, then curriculum.2.rrd ..."""
        first = self.path / "curriculum.rrd"
        parts = len(self.recordings())
        return first if not parts else self.path / f"curriculum.{parts + 1}.rrd"


EVALUATED_ALONE = "it can be evaluated, but not resumed or compared"
# What a folder may hold before its run has begun, and which settings of a run may be changed later
UNTRAINED = ("config.json", "program.scenic", "task.py", "train.log", "origin.pt", "curriculum.rrd", OWNER)
COUNTERS = ("update", "env_steps", "elapsed")  # of a checkpoint
LARGEST = 10**15  # of any of them
MAY_CHANGE = (
    *("total_env_steps", "checkpoint_seconds", "record", "record_rollouts", "record_limit", "report", "device"),
    "env.grf_python",
)
