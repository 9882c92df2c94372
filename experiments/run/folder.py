"""The run folder: the files of a training run, and how it resumes after a kill.

    config.json       the TrainConfig, enough to repeat the run; `about`: id, command, commit, versions, machine,
                      the version of the simulator, and the name of a variant
    program.scenic    the text of the program at the start of the run; task.py for a Python task
    metrics.csv       one row per update; eval_env_steps are the steps of evaluations, not part of env_steps
    levels.csv        one row per played level: source, θ in [-1, 1], returns, score; or the folder levels.parquet
    events.csv        warnings, if any: see `run.events`
    replays.csv       actions of the students on the levels with the highest scores: see `run.replays`
    checkpoint.pt     the full training state; replaced atomically
    origin.pt         the initial student and its KL coefficient, if the run started from another run
    curriculum.rrd    the recording for the Rerun viewer; a resumed run adds curriculum.2.rrd and so on
    tensorboard/, wandb/   the logs of `--report`
    learning_curve.png
    owner.json        the process that trains the run, during training: see `run.launch.owner`

docs/files.md lists the columns of the tables.
After a kill, the tables may be ahead of the checkpoint. Resuming cuts them back to it, so a killed and resumed run ends
with the same tables as an uninterrupted one, except for wall-clock columns (`time/...`).
Read next: `commands.train`.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from regista.experiments.run import config as configs
from regista.experiments.run import provenance, shipped, trust, versions
from regista.experiments.run.config import ConfigError, TrainConfig
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.launch.owner import OWNER, owned
from regista.experiments.run.launch.signals import CHILD_GRACE_SECONDS
from regista.experiments.run.level_table import open_levels
from regista.experiments.run.notes import warn
from regista.experiments.run.table import Table, cannot_write, check_files, read_columns
from ued.config import own_names
from ued.core import own_code
from ued.core.files import is_partial, write_whole
from ued.methods import METHODS

if TYPE_CHECKING:
    from regista.experiments.run.games import Source


class RunFolder:
    """One run on disk. `RunFolder.create` makes a new one, `RunFolder.open` opens an existing one."""

    def __init__(self, path: Path, config: TrainConfig, about: Mapping[str, Any] | None = None) -> None:
        self.path, self.about = path, about or {}
        self.config: Any = config  # a `TaskTrainConfig` for a task in Python
        self._saved: Any = config  # the content of config.json
        self.metrics = Table(path / "metrics.csv")
        self.levels = open_levels(path, config.levels_format)
        self.events = Table(path / "events.csv")
        self.replays = Table(path / "replays.csv")
        self.saved_update = 0
        self._saved_at = time.monotonic()
        self._made: list[Path] | None = None  # folders that `create` made, the run's first; None: an existing run

    @classmethod
    def create(
        cls, path: Path, config: TrainConfig, prepare: Callable[[RunFolder], None] = lambda run: None, name: str = ""
    ) -> RunFolder:
        """Create the folder and write its configuration; `prepare` writes other files first. `name`: see the property.

        The configuration comes last, since a folder that has one can be resumed. Raises `CommandError` if the folder
        already holds a run.
        """
        named = {"name": name} if name not in ("", config.method) else {}
        run = cls(path, config, provenance.about() | versions.stamp(config) | named)
        if run.begun():
            raise CommandError(f"{path} already holds a run; continue it with --resume {path}, or choose another --out")
        names = [entry.name for entry in path.iterdir()] if path.is_dir() else []
        foreign = any(name not in UNTRAINED and not is_partial(name) for name in names) or path.is_file()
        if foreign:
            raise CommandError(f"{path} exists and is not a run folder; choose another --out")
        run._made = [folder for folder in (path, *path.parents) if not folder.exists()]
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path, error) from error
        with run.locked():
            run._saved = None
            prepare(run)
            run.save_config()
        run._remember_code()
        return run

    @classmethod
    def create_or_extend(cls, path: Path, config: TrainConfig, name: str = "") -> RunFolder:
        """Create the folder, or open an existing one whose configuration must match this one."""
        if not (path / "config.json").exists():
            return cls.create(path, config, name=name)
        run = cls.open(path)
        run.extend(config)
        with run.locked():
            run.save_config()
        return run

    @classmethod
    def open(cls, path: Path) -> RunFolder:
        """Open an existing run. Raises `CommandError` for a folder without a run."""
        if shipped.is_name(path):
            raise UsageError(
                f"only `play --player` and `evaluate` accept {path}; copy its folder, {shipped.located(path)}, to use "
                f"the policy as a run"
            )
        if not (path / "config.json").exists():
            inside = sorted(entry.parent.name for entry in path.glob("*/config.json"))
            holds = f"; it holds runs, such as {path / inside[0]}" if inside else ""
            raise CommandError(f"{path} is not a run folder: {advice_on_file(path) or f'it has no config.json{holds}'}")
        check_files(path)
        return cls(path, configs.load(None, path / "config.json"), configs.about(path / "config.json"))

    @property
    def simulator(self) -> int | None:
        """The simulator version of the run; 0: unnumbered, None: a task or engine other than our simulator."""
        return versions.saved_version(self.config, self.about, f"{self.path / 'config.json'}: '{configs.ABOUT}'")

    def extend(self, config: TrainConfig) -> None:
        """Change the budget, logging settings or places of moved code; settings that affect results must not differ.

        `save_config` writes the change, so a folder that turns out to be damaged stays unchanged. Raises `CommandError`
        for a run of another simulator version, and for a budget that the run has exceeded.
        """
        if self.begun():
            versions.check_present(self.simulator, f"{self.path} was trained on", EVALUATED_ALONE)
        elif self.simulator != versions.present_version(self.config):
            self.about, self._saved = {**self.about, **versions.stamp(self.config)}, None
        done = self.env_steps() if self.checkpoint.exists() else 0  # without a checkpoint, it restarts from zero
        total = config.total_env_steps
        if total < min(done, self.config.total_env_steps):
            raise ConfigError(f"{self.path} has {done:_} env_steps; it cannot continue with total_env_steps = {total}")
        others = {row.group for row in METHODS.values()} - {METHODS[self.config.method].group}
        for name, (old, new) in configs.differences(self.config, config).items() if self.begun() else ():
            of_others = name.partition(".")[0] in others
            if name not in MAY_CHANGE and not of_others and not trust.is_moved(old, new):
                raise ConfigError(f"{self.path} was trained with {name} = {old}; it cannot continue with {new}")
        self.config, self.levels = config, open_levels(self.path, config.levels_format)
        self._remember_code()

    def _remember_code(self) -> None:
        """Trust the scores and networks that the user named, on the command line or in Python, in later commands."""
        for name in own_names(self.config):
            if not own_code.is_noted(name):
                trust.allow(name)
                trust.remember(name)

    def save_config(self) -> None:
        """Write the settings if they differ from config.json. The caller must hold the lock, see `locked`."""
        if self.config == self._saved:
            return
        path = self.path / "config.json"
        try:
            configs.save(self.config, path, self.about)
        except OSError as error:
            raise cannot_write(path, error) from error
        self._saved = self.config

    def note_processor(self) -> None:
        """Record this machine's processor and warn, if another one began the run. The caller must hold the lock."""
        about = provenance.continued(self.about)
        if about != self.about:
            before, here = provenance.processor_of(self.about), provenance.processor_of(about).rpartition("; ")[2]
            warn(
                f"{self.path} was trained on {before}; on {here} the last bits of numbers may differ, so it may not "
                "equal an uninterrupted run"
            )
            self.about, self._saved = about, None
            self.save_config()

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the run against training by other processes on any machine. Raises `BusyError` if one trains it."""
        with owned(self.path):
            yield

    @contextmanager
    def removed_if_refused(self) -> Iterator[None]:
        """Remove the files and folders of a new run if an error ends it before its first update.

        Otherwise commands on a folder of runs would find a run without a checkpoint. Other files stay.
        """
        try:
            yield
        except own_code.FAILURES:
            if self._made is not None and all(entry.name in UNTRAINED for entry in self.path.iterdir()):
                for entry in self.path.iterdir():
                    entry.unlink()
                with suppress(OSError):  # the folder is not empty
                    for folder in self._made:
                        folder.rmdir()
            raise

    @property
    def argv(self) -> list[str]:
        """Arguments of `regista` that resume the run, in any working directory."""
        engine = getattr(getattr(self.config, "env", None), "grf_python", None)  # a flag, stored in no file
        typed = ["--grf-python", engine] if engine else []
        return [
            "train",
            "--resume",
            str(self.path.resolve()),
            *typed,
            *trust.flags(self.config.minigame, *own_names(self.config)),
        ]

    def save_source(self, source: Source) -> None:
        """Save the source of the game in the folder of a new run.

        Raises `CommandError` if a frozen source differs from the saved one. Python files may change, with a warning.
        """
        saved = self.path / source.file
        if not self.begun():
            try:
                write_whole(saved, source.text)
            except OSError as error:
                raise cannot_write(saved, error) from error
        elif saved.exists() and saved.read_text(errors="replace") != source.text:
            changed = f"{self.config.minigame} has changed since {self.path} was started, see {saved}"
            if source.frozen:
                raise CommandError(changed)
            warn(f"{changed}; levels, scores and results from before are of the earlier task")

    @property
    def picture(self) -> Path:
        """The picture of the learning curve; `--format` changes its extension."""
        paths = [self.path / f"learning_curve.{kind}" for kind in ("png", "svg", "pdf")]
        return next((path for path in paths if path.exists()), paths[0])

    # ------------------------------------------------------------ the checkpoint

    @property
    def checkpoint(self) -> Path:
        return self.path / "checkpoint.pt"

    def load(self) -> dict[str, Any] | None:
        """Return the checkpoint, None if there is none. Raises `CheckpointError` for a damaged one."""
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
        """Cut the tables back to the update of the checkpoint from which the run resumes.

        Raises `CommandError` if one of them is damaged; then all stay unchanged.
        """
        read_columns(self.metrics.path)
        tables: tuple[Any, ...] = (self.metrics, self.levels, self.events, self.replays)
        cuts = [table.until(update) for table in tables]
        self.saved_update = update
        for table, lines in zip(tables, cuts, strict=True):
            table.replace(lines)

    def save(self, state: dict[str, Any]) -> None:
        """Replace the checkpoint atomically, after the rows of levels up to it.

        Raises `CheckpointError` if it cannot be written; the old one stays.
        """
        from ued.core import checkpoint

        self.levels.flush()  # first: resuming cuts rows beyond a checkpoint, but cannot restore missing rows
        checkpoint.save(self.checkpoint, {"config": configs.to_dict(self.config), **state})
        self.saved_update = state["update"]
        self._saved_at = time.monotonic()

    @property
    def name(self) -> str:
        """The method of the run, or the name of its variant in a comparison."""
        name = self.about.get("name")
        return name if isinstance(name, str) and re.fullmatch(ROW_NAME, name) else self.config.method

    @property
    def label(self) -> str:
        """Name of the run in tables: "clone", or its `name`, with "fine-tuned" if it started from another student."""
        if (self.path / "clone.json").exists():
            return "clone"
        return f"{self.name} fine-tuned" if (self.path / "origin.pt").exists() else self.name

    def checkpoint_due(self, update_seconds: float = 0.0) -> bool:
        """Return whether to save a checkpoint: the last one is older than `checkpoint_seconds`, or updates are slow.

        After a signal, the process may end during a slow update; saving after each one then loses one update at most.
        """
        old = time.monotonic() - self._saved_at >= self.config.checkpoint_seconds
        return old or update_seconds > CHILD_GRACE_SECONDS / 2

    def finished(self) -> bool:
        """Return whether the budget is spent and the picture, the last file of a run, exists."""
        if not (self.checkpoint.exists() and self.picture.exists()):
            return False
        from ued.core import checkpoint

        done = checkpoint.load_entry(self.checkpoint, "env_steps")
        if not isinstance(done, int):
            raise checkpoint.CheckpointError(f"{self.checkpoint} is damaged: its env_steps is {done!r}")
        return done >= self.config.total_env_steps

    def begun(self) -> bool:
        """Return whether the run has trained; a run that failed before its first update may be replaced."""
        return self.metrics.path.exists() or self.checkpoint.exists()

    def env_steps(self) -> int:
        """Return the env_steps of the last row of metrics.csv, 0 if there is none."""
        return int(self._last("env_steps"))

    def seconds(self) -> float:
        """Return the seconds of training in the last row of metrics.csv, 0 if there is none."""
        return self._last("time/elapsed")

    def _last(self, name: str) -> float:
        column = read_columns(self.metrics.path).get(name)
        last = 0.0 if column is None or not len(column) else float(column[-1])
        if not 0 <= last < LARGEST:
            raise CommandError(f"{self.metrics.path} is damaged: its last {name} is {last}")
        return last

    def recordings(self) -> list[Path]:
        """Return the existing parts of the recording."""
        return list(self.path.glob("curriculum*.rrd"))

    @property
    def recording_id(self) -> str:
        """Id of its recordings; a viewer merges recordings with the same id."""
        return f"regista-{self.about.get('id') or self.path.resolve()}"

    def next_recording(self) -> Path:
        """Return the path for the next part of the recording: curriculum.rrd, then curriculum.2.rrd ..."""
        first = self.path / "curriculum.rrd"
        parts = len(self.recordings())
        return first if not parts else self.path / f"curriculum.{parts + 1}.rrd"


def advice_on_file(path: Path) -> str:
    """Return advice for a path that is a file in a run folder, such as its config.json; "" for others."""
    inside = path.is_file() and (path.parent / "config.json").exists()
    return f"it is a file in one; give the folder, {path.parent}" if inside else ""


ROW_NAME = r"[A-Za-z0-9._+-]{1,60}"  # of a variant, as part of a folder name
EVALUATED_ALONE = "it can be evaluated, but not resumed or compared"
# Files that a folder may hold before training, and settings that may change on resume
UNTRAINED = ("config.json", "program.scenic", "task.py", "train.log", "origin.pt", "curriculum.rrd", OWNER)
COUNTERS = ("update", "env_steps", "elapsed")  # numbers in a checkpoint
LARGEST = 10**15  # upper limit of each counter
MAY_CHANGE = (
    *("total_env_steps", "checkpoint_seconds", "record", "record_rollouts", "record_limit", "report", "device"),
    "env.grf_python",
)
