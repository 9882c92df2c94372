"""`TrainConfig`: all settings of a training run, saved in its folder as `config.json`.

The nested parts belong to the packages that use them; this file combines them, defines the presets, and converts
configurations to and from JSON. Read next: `run.build`, from settings to objects.
"""

from __future__ import annotations

import dataclasses
import json
import re
import typing
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar

import numpy as np

from regista.envs.football.config import FootballConfig
from regista.experiments.run.arguments import group, option, positional
from regista.experiments.run.errors import CommandError, UsageError, nearest
from ued.config import LARGEST_SEED, BuilderConfig, Checked, PairedConfig, PPOConfig
from ued.core.files import write_whole
from ued.core.own_code import note_read
from ued.methods import METHODS
from ued.settings import hints_of, most_threads, own_names, setting

Config = TypeVar("Config")

GAME = "minigame, .scenic program, maze, or Python task file.py:name"
TEST_ENVS = {"regista": 64, "grf": 8}  # parallel matches of an evaluation, by engine


class ConfigError(CommandError):
    """Invalid `config.json`: the message names the file, the key, and the expected value."""


def football_ppo() -> PPOConfig:
    """Return the PPO settings for football: larger steps and a longer horizon than the defaults of `PPOConfig`.

    On 1v1Restricted, shooting at once is a local optimum; with these settings, students learn to dribble around the
    keeper within a few million steps.
    """
    return PPOConfig(
        learning_rate=3e-3,
        gamma=0.995,
        gae_lambda=0.98,
        num_minibatches=8,
        update_epochs=3,
        clip_coef=0.3,
        ent_coef=0.001,
        hidden_size=64,
        shared_torso=True,
    )


@dataclass(frozen=True)
class ProgramConfig:
    """Settings for compiling a program; the names are those of Scenic's command line."""

    param: tuple[str, ...] = option((), "set a global parameter of the program", "-p", True, "NAME=VALUE")
    scenario: str | None = setting(None, "modular scenario to run (default: Main, or the only one)")
    model: str | None = option(None, "world model, instead of the one that the program names", "-m")


@dataclass(frozen=True)
class EngineConfig(Checked):
    """Engine settings that override a command's default engine."""

    engine: Literal["regista", "grf"] | None = setting(None, "simulator: regista, or grf for Google Research Football")
    grf_python: str | None = setting(None, "Python interpreter with gfootball (default: searched for)")
    grf_workers: int = setting(0, "GRF worker processes; 0: one per core", most=most_threads, least=0)

    def instead_of(self, env: FootballConfig) -> FootballConfig:
        """Return environment settings with this engine, if one is given."""
        engine = self.engine or env.engine
        return dataclasses.replace(
            env,
            engine=engine,
            engine_spread=0.0 if engine == "grf" else env.engine_spread,  # GRF cannot be randomized
            grf_python=self.grf_python or env.grf_python,
            grf_workers=self.grf_workers or env.grf_workers,
        )


@dataclass(frozen=True)
class RunConfig(Checked):
    """Settings of a training run that all methods share."""

    minigame: str = positional(GAME, default="1v1Restricted")
    method: str = setting("paired", f"method that chooses levels: {', '.join(METHODS)}")
    seed: int = setting(0, "seed of every random stream of the run", ">=0", most=LARGEST_SEED)
    total_env_steps: int = setting(3_000_000, "budget of environment steps, over all students", ">=1", most=10**12)
    num_envs: int = setting(128, "parallel environments of each student", ">=1", most=100_000)
    threads: int = setting(1, "threads of one run; with small networks, one is fastest", ">=1", most=most_threads)
    device: str = setting("cpu", "device of the networks: cpu, cuda, cuda:1, ..., or auto: a GPU if available")
    eval_every: int = setting(250_000, "env_steps between evaluations; 0: none", ">=0", most=10**12)
    eval_episodes: int = setting(64, "episodes of an evaluation per test scene, not in the budget", ">=1", most=10**6)
    checkpoint_seconds: float = setting(60.0, "seconds between checkpoints", ">=0", most=10**9)
    record: bool = setting(True, "write curriculum.rrd for Rerun")
    record_rollouts: int = setting(20, "updates between recorded rollouts; 0: none", ">=0", most=10**9)
    record_limit: int = setting(2_000, "maximum MB of the recording", ">=1", most=1_000_000)
    levels_format: Literal["csv", "parquet"] = setting("csv", "format of the table of levels")
    report: tuple[Literal["tensorboard", "wandb"], ...] = setting((), "also log to tensorboard, wandb")
    ppo: PPOConfig = group(PPOConfig, "PPO, the students' algorithm", topics={"ppo": "PPO, the students' algorithm"})

    def __post_init__(self) -> None:
        super().__post_init__()
        if not re.fullmatch(r"auto|cpu|cuda(:\d{1,2})?", self.device):
            raise ValueError(f"device must be auto, cpu, cuda or cuda:N, got {self.device!r}")

    @property
    def engine(self) -> str | None:
        """The engine that plays football: "regista" or "grf"; None for other tasks."""
        return None

    @property
    def test_envs(self) -> int:
        """Maximum number of parallel environments of an evaluation, for each scene."""
        return 16

    def on_engine(self, playing: EngineConfig) -> Any:
        """Return these settings; only football has several engines. Raises `UsageError` for `grf`."""
        _check_no_engine(playing)
        return self

    def scored(self) -> Any:
        """Return these settings with the reward of evaluations."""
        return self

    def watched(self, playing: EngineConfig) -> Any:
        """Return settings of environments for watching episodes; None: the same as for training.

        Raises `UsageError` for the engine `grf`.
        """
        _check_no_engine(playing)
        return None

    def seen(self) -> dict[str, Any]:
        """Return the settings that determine what a student observes and controls, by path."""
        return {}


def _check_no_engine(playing: EngineConfig) -> None:
    if playing.engine == "grf":
        raise UsageError("--engine grf plays football; this task has its own environments")


@dataclass(frozen=True)
class FootballRunConfig(RunConfig):
    """Settings of a training run on football."""

    ppo: PPOConfig = group(football_ppo, "PPO, the students' algorithm", topics={"ppo": "PPO, the students' algorithm"})
    program: ProgramConfig = group(ProgramConfig, "the training program")
    env: FootballConfig = group(
        FootballConfig,
        "environment: observations, actions, rewards, engine",
        topics={"environment": "observations, actions, rewards, engine"},
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.env.representation == "raw":
            raise ValueError("training needs observations that are arrays; 'raw' is for scripted policies")

    @property
    def engine(self) -> str | None:
        """The engine that plays: "regista" or "grf"."""
        return self.env.engine

    @property
    def test_envs(self) -> int:
        """Maximum number of parallel matches of an evaluation, for each scene; fewer in GRF, to save memory."""
        return TEST_ENVS[self.env.engine]

    def on_engine(self, playing: EngineConfig) -> Any:
        """Return these settings, on another engine if one is given."""
        return dataclasses.replace(self, env=playing.instead_of(self.env))

    def scored(self) -> Any:
        """Return these settings with goals as the reward."""
        return dataclasses.replace(self, env=dataclasses.replace(self.env, rewards="scoring"))

    def watched(self, playing: EngineConfig) -> FootballConfig:
        """Return the settings of matches with raw observations, on another engine if one is given."""
        return playing.instead_of(dataclasses.replace(self.env, representation="raw"))

    def seen(self) -> dict[str, Any]:
        """Return the representation and the players that agents control."""
        return {f"env.{name}": getattr(self.env, name) for name in ("representation", "control", "right_control")}


def _settings_of_methods() -> list[tuple[str, type, Any]]:
    """Return a field for each method with its own settings: `--name.setting` on the command line."""
    sharing = {
        row.name: {m.name: f"{m.title}: {m.help}" for m in METHODS.values() if m.group == row.name}
        for row in METHODS.values()
    }
    return [
        (
            row.name,
            type(row.settings()),
            group(row.settings, f"{row.title}: {row.help}", f"{row.name}.".replace("_", "-"), topics=sharing[row.name]),
        )
        for row in METHODS.values()
        if row.group == row.name
    ]


def _with_methods(base: type) -> Any:
    return dataclasses.make_dataclass("Settings", _settings_of_methods(), bases=(base,), frozen=True)


FootballSettings: Any = _with_methods(FootballRunConfig)
TaskSettings: Any = _with_methods(RunConfig)


class TrainConfig(FootballSettings):
    """Settings of one training run. Runs with equal settings on one machine have equal results."""


class TaskTrainConfig(TaskSettings):
    """Settings of one training run on a Python task, without football; `minigame` is the task's name."""


# ---------------------------------------------------------------- JSON

ABOUT = "about"  # key of config.json that is not a setting
LARGEST = 10**300  # largest integer that is read as a float
LARGEST_FILE = 10_000_000  # bytes of a config.json
OF_MACHINES = 1_024  # upper limit of threads on any machine

# Settings that are missing in older files, as JSON, with the values that reproduce those runs.
ADDED: dict[str, Any] = {"ppo.team": "independent", "ppo.critic": "own", "ppo.bptt_steps": 0, "ppo.network": "auto"}
ADDED |= {"ppo.head_size": 0, "ppo.norm_reward": False, "accel.new_levels": "random", "sfl.score": "learnability"}
ADDED |= {"record_limit": 2_000, "report": [], "device": "cpu", "levels_format": "csv"}
ADDED |= {"program": {"param": [], "scenario": None, "model": None}}  # in files of demonstrations
ADDED |= {row: dataclasses.asdict(METHODS[row].settings()) for row in ("cenie", "ncc", "lessons")}
WITH_ADVERSARY = [row.group for row in METHODS.values() if hasattr(row.settings(), "adversary")]
ADDED |= {f"{method}.adversary.builder": "auto" for method in WITH_ADVERSARY} | {"env.pixels": "dense"}
ADDED |= {f"{method}.adversary.steps": dataclasses.asdict(BuilderConfig()) for method in WITH_ADVERSARY}
RENAMED = {"distribution": {"squashed": "tanh_gaussian"}, "roles": {"fixed": "dennis2020"}}  # old names of values


def run_class(data: Any) -> type:
    """Return the configuration class of data from `to_dict`: a Python task has no `env`."""
    task = isinstance(data, dict) and "env" not in data and ":" in str(data.get("minigame"))
    return TaskTrainConfig if task else TrainConfig


def to_dict(config: Any) -> dict[str, Any]:
    """Return a configuration in a form that JSON supports: paths as strings, tuples as lists."""
    return {item.name: _plain(getattr(config, item.name)) for item in fields(config)}


def from_dict(kind: type[Config], data: Any, where: str) -> Config:
    """Return the configuration of class `kind` from data of `to_dict`.

    Raises `ConfigError` for an unknown or missing key and for a value of the wrong type; `where` names the source.
    """
    config: Config = _read(kind, data, where, path="")
    note_read(getattr(config, "minigame", ""), *own_names(config), file=where)  # code that an untrusted file may name
    return config


def changed(config: Config, values: Mapping[Any, Any], where: str) -> Config:
    """Return `config` with the values at these dotted paths replaced; each must have the type of its field.

    Raises `ConfigError` for an unknown path and for a value of the wrong type; `where` names the source.
    """
    data = to_dict(config)
    for path, value in values.items():
        section: Any = data
        *parts, last = str(path).split(".")
        for part in parts:
            section = section.get(part) if isinstance(section, dict) else None
        if not isinstance(section, dict) or last not in section:
            raise ConfigError(f"{where}: there is no setting '{path}'{nearest(str(path), _paths(data))}")
        if isinstance(section[last], dict) and not is_dataclass(value):
            first = next(iter(section[last]))
            raise ConfigError(f"{where}: '{path}' is a group of settings; give one, such as '{path}.{first}'")
        section[last] = value.item() if isinstance(value, np.generic) else _plain(value)
    return _read(type(config), data, where, path="")


def _paths(section: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Return the dotted paths of all settings."""
    nested = [
        _paths(value, f"{prefix}{key}.") if isinstance(value, dict) else [prefix + key]
        for key, value in section.items()
    ]
    return [path for paths in nested for path in paths]


def save(config: Any, path: Path, about: Mapping[str, Any] | None = None) -> None:
    """Write a configuration as JSON, with the information of `provenance.about`."""
    section = {ABOUT: about} if about else {}
    write_whole(path, json.dumps(to_dict(config) | section, indent=2) + "\n")


def about(path: Path) -> dict[str, Any]:
    """Return the `about` section of a run's JSON, empty if absent. Raises `ConfigError` unless it is an object."""
    section = _json(path).get(ABOUT, {})
    if not isinstance(section, dict):
        raise ConfigError(f"{path}: '{ABOUT}' must be an object, got {json.dumps(section)}")
    return section


def load(kind: type[Config] | None, path: Path) -> Config:
    """Read a configuration from JSON; without `kind`, that of a run.

    Raises `ConfigError` like `from_dict`, and for text that is not JSON.
    """
    data = _json(path)
    if isinstance(data, dict):
        data.pop(ABOUT, None)
        _rename(data)
    return from_dict(kind or run_class(data), data, str(path))


def _rename(section: dict[str, Any]) -> None:
    """Replace old names of values by current ones, also in nested sections."""
    for key, value in section.items():
        if isinstance(value, dict):
            _rename(value)
        elif isinstance(value, str):
            section[key] = RENAMED.get(key, {}).get(value, value)


def _json(path: Path) -> Any:
    if path.stat().st_size > LARGEST_FILE:
        raise ConfigError(
            f"{path} is not a settings file: it has more than {LARGEST_FILE:_} bytes; expected a run's config.json"
        )
    try:
        return json.loads(path.read_text(), parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        what = "a text file" if isinstance(error, UnicodeDecodeError) else f"JSON: {error}"
        raise ConfigError(f"{path} is not {what}; expected the config.json of a run, or its folder") from error


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is not a JSON number")


def differences(old: Any, new: Any, path: str = "") -> dict[str, tuple[Any, Any]]:
    """Return the settings that differ between two configurations of one class: dotted path to (old, new)."""
    differing: dict[str, tuple[Any, Any]] = {}
    for item in fields(old):
        before, after = getattr(old, item.name), getattr(new, item.name)
        if is_dataclass(before):
            differing |= differences(before, after, f"{path}{item.name}.")
        elif before != after:
            differing[path + item.name] = (before, after)
    return differing


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return to_dict(value)
    if isinstance(value, Path):
        return str(value)
    return list(value) if isinstance(value, tuple) else value


def _read(kind: Any, data: Any, where: str, path: str) -> Any:
    if not isinstance(data, dict):
        raise ConfigError(f"{where}: {path.rstrip('.') or 'the file'} must be an object, got {json.dumps(data)}")
    hints = hints_of(kind)
    names = [item.name for item in fields(kind)]
    for key in data:
        if key not in names:
            raise ConfigError(f"{where}: unknown key '{path}{key}'{nearest(key, names)}")
    values = {}
    for name in names:
        if name not in data and path + name not in ADDED:
            raise ConfigError(f"{where}: key '{path}{name}' is missing")
        values[name] = _value(hints[name], data.get(name, ADDED.get(path + name)), where, path + name)
    values = {item.name: _clipped(item, values[item.name]) for item in fields(kind)}
    if kind is FootballConfig:
        values["grf_python"] = None  # an executable: only the command line may choose it, never a file
    try:
        return kind(**values)
    except ValueError as error:
        raise ConfigError(f"{where}: {error}") from error


def _clipped(item: Any, value: Any) -> Any:
    """Clip a machine-dependent setting, such as `threads`, to this machine's maximum; results do not depend on it.

    Thus a smaller machine can read the run of a larger one. Values above OF_MACHINES are rejected later.
    """
    most = item.metadata.get("most")
    return min(value, most()) if callable(most) and value <= OF_MACHINES else value


def _value(hint: Any, value: Any, where: str, path: str) -> Any:
    """Return `value` converted to the field's type. Raises `ConfigError` for the wrong type."""
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if is_dataclass(hint):
        return _read(hint, value, where, f"{path}.")
    if origin in (typing.Union, UnionType):
        return None if value is None else _value(next(p for p in parts if p is not NoneType), value, where, path)
    if origin is typing.Literal and value in parts:
        return value
    if origin is tuple and isinstance(value, list | tuple):
        return tuple(_value(parts[0], item, where, path) for item in value)
    if hint is Path and isinstance(value, str):
        return Path(value)
    if hint is float and type(value) is int and abs(value) < LARGEST:
        return float(value)
    if type(value) is hint:
        return value
    name = "a list" if origin is tuple else getattr(hint, "__name__", str(hint))  # JSON has no tuples
    expected = " or ".join(map(repr, parts)) if origin is typing.Literal else name
    raise ConfigError(f"{where}: '{path}' must be {expected}, got {json.dumps(value, default=repr)}")


# ---------------------------------------------------------------- presets


def task_presets() -> dict[str, TaskTrainConfig]:
    """Return default settings for Python tasks: few environments and a medium budget."""
    fast = TaskTrainConfig(total_env_steps=500_000, num_envs=16, eval_every=50_000, eval_episodes=32)
    thesis = dataclasses.replace(fast, ppo=PPOConfig.thesis(), paired=PairedConfig.thesis())
    return {"fast": fast, "thesis": thesis}


def presets() -> dict[str, TrainConfig]:
    """Return the settings of each `--preset`.

    `fast` is the default: features and a small network, minutes on two cores. `thesis` reproduces the thesis: stacked
    SMM images, goals as the only reward, the network of Fig. 4.10, the coefficients of Table 4.2, 16 environments and
    5M steps.
    """
    fast = TrainConfig()
    thesis = dataclasses.replace(
        fast,
        total_env_steps=5_000_000,
        num_envs=16,
        ppo=PPOConfig.thesis(),
        env=FootballConfig(representation="smm_stacked", rewards="scoring", pixels="sparse"),
        paired=PairedConfig.thesis(),
    )
    return {"fast": fast, "thesis": thesis}
