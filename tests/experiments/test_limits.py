"""Every number that can be typed, or read from a file, has bounds; a value beyond them is refused in a sentence."""

from __future__ import annotations

import dataclasses
import json
import math
import time
import typing
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from types import NoneType
from typing import Any, NamedTuple

import pytest

from regista.envs.football.config import FootballConfig
from regista.experiments.__main__ import COMMANDS, main
from regista.experiments.run import arguments
from regista.experiments.run import config as configs
from regista.experiments.run.config import ConfigError, EngineConfig, TaskTrainConfig, TrainConfig
from regista.experiments.run.launch.workers import LaunchConfig
from tests.attacks.files import TASK
from ued.config import PPOConfig, bounds_of, most_threads
from ued.core import room

LINES = [[name] for name in COMMANDS]
SECONDS = 5.0  # of processor time for a refusal


class Number(NamedTuple):
    """A setting that is a number: its flag, its field and the class that has it."""

    flag: str
    item: dataclasses.Field
    owner: type


def numbers_of(config: Any, prefix: str = "", without: tuple[str, ...] = ()) -> Iterator[Number]:
    """Yield all numbers of a configuration and its parts, as `arguments` makes flags of them."""
    hints = typing.get_type_hints(type(config))
    for item in fields(config):
        value = getattr(config, item.name)
        if item.name in without:
            continue
        if is_dataclass(value):
            inside = prefix + item.metadata.get("prefix", f"{item.name}.")
            yield from numbers_of(value, inside, item.metadata.get("without", ()))
        elif {int, float} & {hints[item.name], *typing.get_args(hints[item.name])} and hints[item.name] is not bool:
            yield Number(arguments.flag_name(item.name, prefix), item, type(config))


class ParsedError(Exception):
    """The command has come to its flags."""


def settings_of(line: list[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the configuration of which a command makes flags."""
    found = []

    def keep(base: Any, *_: Any) -> None:
        found.append(base)
        raise ParsedError

    with monkeypatch.context() as patch:
        patch.setattr(arguments, "typed_settings", keep)
        with pytest.raises(ParsedError):
            main(line)
    return found[0]


def beyond(item: dataclasses.Field) -> list[str]:
    """Return values that a field must refuse."""
    least, most = bounds_of(item.metadata)
    above = str(most + 1) if isinstance(most, int) else repr(most * 1.01 + 1e-9)
    return [above, str(least - 1), "1e18", "-1e18", "nan", "inf", "-inf", "1e999", "9" * 400]


@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_every_number_of_every_command_has_bounds(line, monkeypatch):
    for number in numbers_of(settings_of(line, monkeypatch)):
        least, most = bounds_of(number.item.metadata)
        assert math.isfinite(least) and math.isfinite(most) and least < most, number.flag
        default = number.item.default
        assert not isinstance(default, int | float) or least <= default <= most, number.flag


seen: set[tuple[type, str]] = set()  # what a command before has in common with this one


@pytest.mark.long
@pytest.mark.parametrize("line", LINES, ids=" ".join)
def test_what_is_beyond_the_bounds_is_refused_with_the_flag(line, monkeypatch, capsys):
    for number in numbers_of(settings_of(line, monkeypatch)):
        about = number.owner, number.item.name
        for value in beyond(number.item) if about not in seen else ():
            began = time.process_time()
            assert main([*line, number.flag, value]) == 2, (number.flag, value)
            said = capsys.readouterr().err
            assert said.startswith(f"regista: {number.flag}: ") and said.count("\n") == 1, said
            assert time.process_time() - began < SECONDS
        seen.add(about)


def test_the_sentence_names_flag_value_and_maximum(capsys):
    assert main(["train", "--threads", "100000"]) == 2
    assert capsys.readouterr().err == (
        f"regista: --threads: must be at most {most_threads()} on this machine, got 100000; see regista train --help\n"
    )


# ---------------------------------------------------------------- from Python, from files


def every_number(config: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], dataclasses.Field]]:
    hints = typing.get_type_hints(type(config))
    for item in fields(config):
        value, kinds = getattr(config, item.name), {hints[item.name], *typing.get_args(hints[item.name])} - {NoneType}
        if is_dataclass(value):
            yield from every_number(value, (*path, item.name))
        elif kinds <= {int, float}:
            yield (*path, item.name), item


@pytest.mark.long
@pytest.mark.parametrize("kind", [TrainConfig, TaskTrainConfig])
def test_a_file_cannot_say_what_cannot_be_typed(kind):
    for path, item in every_number(kind()):
        whole = item.type == "int" or "int" in str(item.type)
        values = [10**18, 10**400, -(10**18)] + ([] if whole else [math.inf, math.nan, -math.inf])
        for value in values:
            data = configs.to_dict(kind())
            part = data
            for name in path[:-1]:
                part = part[name]
            part[path[-1]] = value
            with pytest.raises(ConfigError, match=f"^c.json: .*{path[-1]}"):
                configs.from_dict(kind, data, "c.json")


@pytest.mark.slow
@pytest.mark.parametrize("kind", [TrainConfig, TaskTrainConfig])
def test_python_cannot_either(kind):
    for path, item in every_number(kind()):
        part: Any = kind()
        for name in path[:-1]:
            part = getattr(part, name)
        for value in (bounds_of(item.metadata)[1] + 1, 1e18, math.nan, math.inf, -math.inf):
            with pytest.raises(ValueError, match=path[-1]):
                dataclasses.replace(part, **{path[-1]: value})


def test_a_run_of_a_larger_machine_is_read_with_the_threads_of_this_one(tmp_path):
    data = configs.to_dict(TrainConfig())
    data["threads"], data["env"]["grf_workers"] = 512, 512
    (tmp_path / "config.json").write_text(json.dumps(data))
    found = configs.load(None, tmp_path / "config.json")
    assert found.threads == found.env.grf_workers == most_threads() < 512
    data["threads"] = 100_000
    (tmp_path / "config.json").write_text(json.dumps(data))
    with pytest.raises(ConfigError, match=r"threads must be at most \d+ on this machine, got 100000"):
        configs.load(None, tmp_path / "config.json")


def test_processes_of_this_machine_are_bound_to_its_cores():
    with pytest.raises(ValueError, match="processes must be at most"):
        LaunchConfig(processes=most_threads() + 1)
    assert LaunchConfig("ray", most_threads() + 1).processes == most_threads() + 1
    for make in (FootballConfig, EngineConfig):
        with pytest.raises(ValueError, match=r"grf_workers must be .*at most"):
            make(grf_workers=most_threads() + 1)


# ---------------------------------------------------------------- memory


@pytest.mark.parametrize(
    ("flags", "named"),
    [
        (["--num-envs", "100000", "--num-steps", "65536"], "--num-envs and --num-steps: "),
        (["--hidden-size", "16384", "--hidden-layers", "64"], "--hidden-size and --hidden-layers: "),
        (["--hidden-size", "16384", "--hidden-layers", "8", "--paired.students", "64"], "--hidden-size and --hidden"),
    ],
)
def test_what_does_not_fit_into_memory_is_refused_before_it_is_taken(flags, named, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(room, "machine_bytes", lambda: 20 * 10**9)
    began = time.process_time()
    assert main(["train", TASK, "--method", "paired", *flags, "--out", str(tmp_path / "run")]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith(f"regista: {named}") and said.endswith("; this machine has 20 GB")
    assert time.process_time() - began < 60  # one of 64 students after the other, those that fit
    assert not (tmp_path / "run" / "metrics.csv").exists()


@pytest.mark.parametrize("game", [TASK, "1v1Free"])
def test_environments_that_do_not_fit_are_refused(game, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(room, "machine_bytes", lambda: 100_000)
    assert main(["train", game, "--num-envs", "50000", "--out", str(tmp_path / "run")]) == 2
    assert "--num-envs: too large for the environments: 50_000 environments of" in capsys.readouterr().err


def test_needs_are_estimated_from_below():
    from gymnasium.spaces import Box, Discrete

    from ued.core.seeding import torch_generator
    from ued.learning.student import Student

    for space in (Box(-1, 1, (50,)), Box(0, 255, (72, 96, 16), "uint8")):
        for changes in ({}, {"shared_torso": True}, {"memory": "gru"}, {"hidden_layers": 4}):
            config = PPOConfig(**changes)
            student = Student(space, Discrete(19), config, torch_generator(0))
            count = sum(weight.numel() for weight in student.parameters())
            assert 0.5 * count < room.weights(config, space, 1) <= count
