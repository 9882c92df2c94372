"""The folder of `regista demonstrate`: parts of episodes, each complete or absent, and their Minari dataset.

    demonstrations.json     the `DemonstrationsConfig`; `about`: the version of the simulator,
                            and the env_steps of the student's training
    program.scenic          the text of the program
    records/0000.npz        the saved episodes of a part, for `regista play --replay`
    data/part-0000.hdf5     their observations and actions
    data/main_data.hdf5     the Minari dataset, which links to the parts; with data/metadata.json
    episodes.csv            one row per played episode: θ, seed, return, length, and its number if it was saved

Files of a part are written to a temporary file, synced and renamed, the record first, so a part with data is complete.
Read next: `imitation.demonstrator`, which plays the episodes.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from regista.envs.football.config import FootballConfig
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import config as configs
from regista.experiments.run import versions
from regista.experiments.run.errors import DAMAGE, CommandError
from regista.experiments.run.table import cannot_write, check_files, spell
from ued.config import LARGEST_SEED, Checked, setting
from ued.core.files import is_partial, write_whole

if TYPE_CHECKING:
    from gymnasium.spaces import Space

    from regista.experiments.imitation.demonstrator import Episode, Part

EXTRA = "pip install 'regista[demonstrations]'"
COMPRESSION = {"compression": "gzip", "compression_opts": 1}  # planes are mostly zeros
TRAINED = "env_steps"  # key in `about`: env_steps of the student's training
SMALL = 8192  # bytes; smaller arrays are not compressed


@dataclass(frozen=True)
class DemonstrationsConfig(Checked):
    """Settings of a folder of demonstrations; the same settings give the same episodes."""

    minigame: str = setting("", "minigame or path of a .scenic program")
    source: str = setting("program", "policy: program, or the path of a run")
    keep: Literal["successful", "all"] = setting("successful", "episodes to save: successful or all")
    success_above: float | None = setting(
        None, "success threshold on the return (default: the success criterion of the game)", most=1e9, least=-1e9
    )
    greedy: bool = setting(False, "the student takes its most likely action")
    seed: int = setting(0, "seed of levels and episodes", ">=0", most=LARGEST_SEED)
    part: int = setting(256, "episodes played in parallel", ">=1", most=100_000)
    env: FootballConfig = field(default_factory=FootballConfig)
    program: configs.ProgramConfig = field(default_factory=configs.ProgramConfig)


class Summary(NamedTuple):
    """The N episodes of a part as numbers: θ `[N, D]`, seeds, returns, success, lengths `[N]`, kept: bool `[N]`."""

    theta: np.ndarray
    seed: np.ndarray
    returns: np.ndarray
    success: np.ndarray
    lengths: np.ndarray
    kept: np.ndarray


class Demonstrations:
    """One folder of demonstrations on disk."""

    def __init__(self, path: Path, config: DemonstrationsConfig) -> None:
        self.path, self.config = path, config

    @classmethod
    def open(cls, path: Path) -> Demonstrations:
        """Open an existing folder. Raises `CommandError` for one that holds no demonstrations."""
        file = path / "demonstrations.json"
        if not file.exists():
            raise CommandError(f"{path} holds no demonstrations: it has no demonstrations.json")
        check_files(path)
        return cls(path, configs.load(DemonstrationsConfig, file))

    @property
    def simulator(self) -> int | None:
        """The simulator version of the episodes; 0: unnumbered, None: another engine."""
        file = self.path / "demonstrations.json"
        return versions.saved_version(self.config, configs.about(file), f"{file}: '{configs.ABOUT}'")

    @classmethod
    def create_or_continue(
        cls, path: Path, config: DemonstrationsConfig, program: str, env_steps: int | None = None
    ) -> Demonstrations:
        """Create a folder, or continue one that has the same settings and program.

        `env_steps` is the length of the student's training, None for a program. Raises `CommandError` for a folder
        that differs in one of these.
        """
        if (path / "demonstrations.json").exists():
            found = cls.open(path)
            versions.check_present(found.simulator, f"{path} was recorded on", "nothing can be added to it")
            for name, (old, new) in configs.differences(found.config, config).items():
                raise CommandError(f"{path} was made with {name} = {old}; it cannot continue with {new}")
            before = configs.about(path / "demonstrations.json").get(TRAINED, env_steps)  # missing in older folders
            if before != env_steps:
                raise CommandError(
                    f"{path} holds episodes of {config.source} at {before} env_steps, which now has {env_steps}; "
                    "choose another --out"
                )
            if (path / "program.scenic").read_text(errors="replace") != program:
                raise CommandError(f"the program has changed since {path} was created, see its program.scenic")
            return found
        if path.exists() and not (path.is_dir() and all(map(_is_initial, path.iterdir()))):
            raise CommandError(f"{path} exists and holds no demonstrations; choose another --out")
        try:
            for folder in ("records", "data"):
                (path / folder).mkdir(parents=True, exist_ok=True)
            write_whole(path / "program.scenic", program)
            trained = {} if env_steps is None else {TRAINED: env_steps}
            configs.save(config, path / "demonstrations.json", versions.stamp(config) | trained)
        except OSError as error:
            raise cannot_write(path, error) from error
        return cls(path, config)

    def num_episodes(self) -> int:
        """Return the number of episodes of the finished dataset. Raises `CommandError` for an unfinished one."""
        path = self.path / "data" / "metadata.json"
        try:
            return int(json.loads(path.read_text())["total_episodes"])
        except FileNotFoundError as error:
            raise CommandError(
                f"{self.path} is not finished; run the same regista demonstrate command to continue"
            ) from error
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise CommandError(f"{path} is damaged; run the same regista demonstrate command to rewrite it") from error

    # ------------------------------------------------------------ parts

    def part_path(self, number: int) -> Path:
        """Return the path of a part's data."""
        return self.path / "data" / f"part-{number:04d}.hdf5"

    def num_parts(self) -> int:
        """Return the number of complete parts, up to the first missing one."""
        number = 0
        while self.part_path(number).exists():
            number += 1
        return number

    def summaries(self) -> Iterator[Summary]:
        """Yield the summary of every part. Raises `CommandError` for a damaged part."""
        for number in range(self.num_parts()):
            with self.reading(number) as file:
                summary = Summary(*(file["summary"][name][()] for name in Summary._fields))
                size = summary.kept.shape
                whole = summary.kept.dtype == bool and summary.lengths.dtype.kind == "i" and summary.lengths.min() >= 0
                if not whole or any(each.shape[:1] != size or len(size) != 1 for each in summary):
                    raise ValueError("its numbers are inconsistent")
            yield summary

    @contextmanager
    def reading(self, number: int) -> Iterator[Any]:
        """Open the data of a part. Raises `CommandError` for a damaged file, also during later reads."""
        path = self.part_path(number)
        try:
            with _h5py().File(path, "r") as file:
                yield file
        except (OSError, *DAMAGE) as error:
            raise CommandError(
                f"{path} is damaged or incomplete; delete it and run the same regista demonstrate command, which plays "
                "the same episodes again"
            ) from error

    def add(self, number: int, part: Part, first: int) -> Summary:
        """Write a part, with its saved episodes numbered from `first` on; return its summary.

        Raises `CommandError` if the file cannot be written; earlier parts stay intact.
        """
        from regista.envs.football.replay import save_record

        above = self.config.success_above
        success = part.success > 0 if above is None else part.returns > above
        kept = np.ones_like(success) if self.config.keep == "all" else success
        levels = part.levels
        summary = Summary(levels["theta"], levels["seed"], part.returns, success, part.lengths, kept)
        indices, content = np.flatnonzero(kept), io.BytesIO()
        if len(indices):
            save_record(part.record.rows(indices), content)
        data = _part_file(part, summary, first)
        try:
            if len(indices):
                write_whole(self.path / "records" / f"{number:04d}.npz", content.getvalue())
            write_whole(self.part_path(number), data)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        return summary

    # ------------------------------------------------------------ the dataset

    def finish(self, names: list[str], spaces: tuple[Space, Space], settings: dict[str, Any], episodes: int) -> None:
        """Write the files over all parts: the Minari dataset of the first `episodes` saved episodes, and the table.

        `settings` are the arguments with which Minari recreates `FootballEnv`.
        """
        numbers = [number for number, summary in enumerate(self.summaries()) for _ in range(int(summary.kept.sum()))]
        numbers = numbers[:episodes]
        steps = sum(int(length) for summary in self.summaries() for length in summary.lengths[summary.kept])
        if len(numbers) < sum(int(summary.kept.sum()) for summary in self.summaries()):
            lengths = [int(n) for summary in self.summaries() for n in summary.lengths[summary.kept]]
            steps = sum(lengths[:episodes])
        try:
            write_whole(self.path / "data" / "main_data.hdf5", _main_file(numbers))
            metadata = _metadata(self, spaces, settings, len(numbers), steps)
            write_whole(self.path / "data" / "metadata.json", json.dumps(metadata))
            write_whole(self.path / "episodes.csv", self._table(names, episodes))
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def _table(self, names: list[str], episodes: int) -> str:
        header = [
            "part",
            "match",
            "episode",
            "seed",
            "return",
            "success",
            "length",
            *(f"theta/{name}" for name in names),
        ]
        lines, number = [",".join(f'"{name}"' if "," in name else name for name in header)], 0
        for part, summary in enumerate(self.summaries()):
            for row in range(len(summary.kept)):
                label = number if summary.kept[row] and number < episodes else None
                number += bool(summary.kept[row])
                results = (summary.seed[row], summary.returns[row], int(summary.success[row]), summary.lengths[row])
                cells = [part, row, label, *results, *summary.theta[row]]
                lines.append(",".join(spell(cell) for cell in cells))
        return "\n".join(lines) + "\n"


def _is_initial(path: Path) -> bool:
    """Return whether a folder may hold this file before it has a demonstrations.json."""
    empty = path.name in ("records", "data") and path.is_dir() and not any(path.iterdir())
    return empty or path.name == "program.scenic" or is_partial(path.name)


# ---------------------------------------------------------------- HDF5 in Minari's layout


def _h5py() -> Any:
    try:
        import h5py
        import minari  # noqa: F401 (the files follow its layout)
    except ImportError as error:
        raise CommandError(f"demonstrations need minari and h5py, which are not installed: {EXTRA}") from error
    return h5py


def check_installed() -> None:
    """Raise `CommandError` if minari or h5py is not installed."""
    _h5py()


def _in_memory(fill: Callable[[Any], None]) -> bytes:
    """Return the bytes of an HDF5 file filled by `fill`; only `write_whole` writes to the disk."""
    with _h5py().File("memory", "w", driver="core", backing_store=False) as file:
        fill(file)
        file.flush()
        return file.id.get_file_image()


def _part_file(part: Part, summary: Summary, first: int) -> bytes:
    def fill(file: Any) -> None:
        for name, value in summary._asdict().items():
            file[f"summary/{name}"] = value
        for number, index in enumerate(np.flatnonzero(summary.kept), first):
            group = file.create_group(f"episode_{number}")
            group.attrs.update({"id": number, "seed": part.levels["seed"][index]})
            group.attrs["options/theta"] = part.levels["theta"][index]
            group.attrs["options/return"] = part.returns[index]
            _write_episode(group, part.episode(int(index)))

    return _in_memory(fill)


def _write_episode(group: Any, episode: Episode) -> None:
    steps = len(episode.actions)
    ends = np.zeros((2, steps), bool)
    ends[0 if episode.terminated else 1, -1] = True
    arrays = {
        "observations": episode.observations,
        "actions": episode.actions,
        "rewards": episode.rewards,
        "terminations": ends[0],
        "truncations": ends[1],
        "infos/told": episode.mask,
    }
    if episode.actions.ndim > 1:
        arrays["infos/agent_rewards"] = episode.agent_rewards
    group.attrs["total_steps"] = steps
    for name, array in arrays.items():
        group.create_dataset(name, data=array, **(COMPRESSION if array.nbytes > SMALL else {}))


def _main_file(parts: list[int]) -> bytes:
    """Return the dataset's main file, which links episode e to part `parts[e]`."""
    link = _h5py().ExternalLink

    def fill(file: Any) -> None:
        for number, part in enumerate(parts):
            file[f"episode_{number}"] = link(f"part-{part:04d}.hdf5", f"/episode_{number}")

    return _in_memory(fill)


def _metadata(
    demos: Demonstrations, spaces: tuple[Space, Space], settings: dict[str, Any], episodes: int, steps: int
) -> dict[str, Any]:
    import minari
    from gymnasium.envs.registration import EnvSpec
    from minari.serialization import serialize_space

    observation, action = (serialize_space(space) for space in spaces)
    name = "".join(letter if letter.isalnum() else "-" for letter in Path(demos.config.minigame).stem)
    id = f"regista/{name}-v{SIMULATOR_VERSION}"
    return {
        "dataset_id": id,
        "minari_version": minari.__version__,
        "data_format": "hdf5",
        "jpeg_encoding": False,
        "observation_space": observation,
        "action_space": action,
        "total_episodes": episodes,
        "total_steps": steps,
        "algorithm_name": demos.config.source,
        "regista": {name: value for name, value in asdict(demos.config).items() if name != "source"}
        | versions.stamp(demos.config),
        "env_spec": EnvSpec(id, entry_point="regista.envs.football.gym_env:FootballEnv", kwargs=settings).to_json(),
    }
