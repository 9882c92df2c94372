"""The defaults that `--help` states are those that a command uses: for games, tasks and presets."""

import re
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.__main__ import main
from regista.experiments.commands import clone, compare, train
from regista.experiments.run import build, starting, trust
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import all_starts
from regista.minigames.suites import NAMED

TASK = f"{Path(__file__).parents[2] / 'examples' / 'own_levels.py'}:make"
CASES = [
    [],
    [TASK],
    ["maze"],
    ["1v1Free"],
    ["--preset", "thesis"],
    ["--preset=thesis", TASK],
    ["offense/11_vs_gk"],
    ["academy/run_to_score+1v1Free", "--preset", "thesis"],
]
CHOSEN = ("minigame", "method", "seed")


@pytest.fixture(autouse=True)
def trusted():
    trust.allow(TASK)


def flat(config, path=""):
    """Return the settings of nested dataclasses by dotted path, but for those that a command line chooses."""
    found = {}
    for item in fields(config):
        value = getattr(config, item.name)
        found |= flat(value, f"{path}{item.name}.") if is_dataclass(value) else {path + item.name: value}
    return {name: value for name, value in found.items() if name not in CHOSEN}


@pytest.fixture
def effective(monkeypatch):
    """Return what a run would be trained with, given what is typed after `regista train`."""
    made = []
    monkeypatch.setattr(RunFolder, "create", lambda out, config, prepare: made.append(config))

    def settings(argv):
        train._begin(train._typed(argv))
        return flat(made[-1])

    return settings


@pytest.mark.parametrize("argv", CASES)
def test_train_states_what_it_uses(argv, effective):
    assert flat(train._known(argv)) == effective(argv)


@pytest.mark.parametrize("argv", CASES)
def test_compare_states_what_it_uses(argv):
    assert flat(starting.settings_for(argv)) == flat(compare._read(argv)[0].train)


@pytest.mark.parametrize("argv", CASES)
def test_other_cases_are_what_they_are_called(argv, effective):
    cases = starting.other_settings(argv)
    games = [word for word in argv if word != "thesis" and not word.startswith("--preset")]
    preset = starting.preset_of(argv)
    other = {"fast": "thesis", "thesis": "fast"}[preset]
    (config,) = cases.pop(f"with --preset {other}")
    assert flat(config) == effective([*games, "--preset", other])
    if TASK not in argv and "maze" not in argv:
        (config,) = cases.pop("for tasks")
        assert flat(config) == effective([TASK, "--preset", preset])
    found = {str(flat(config)) for config in cases.pop("for other games", [])}
    if not games:
        assert {str(effective([name, "--preset", preset])) for name in ("1v1Free", "offense/11_vs_gk")} <= found
    assert not cases


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["fast", "thesis"])
def test_the_settings_of_all_minigames_are_there(preset):
    found = [flat(config) for config in all_starts(preset)]
    for name in NAMED:
        assert flat(build.find_game(name).start(preset)) in found
    assert len(found) < len(NAMED) / 5  # a command line makes each once


def stated(capsys, *words):
    """Return what a page of help says of the default of each flag."""
    with pytest.raises(SystemExit):
        main([*words])
    text = re.sub(r"\s+", " ", capsys.readouterr().out)
    return dict(re.findall(r"(--[a-z.-]+) [NX] [^()]*(?:\([^()]*\)[^()]*)*?\(default ([^()]*)\)", text))


def test_help_says_how_many_environments_there_are_in_each_case(capsys):
    assert stated(capsys, "train", "--help")["--num-envs"] == "128; 16 with --preset thesis or for tasks"
    assert stated(capsys, "train", TASK, "--help")["--num-envs"] == "16"
    assert stated(capsys, "compare", TASK, "--help")["--total-env-steps"] == "500_000"
    assert stated(capsys, "train", "--preset", "thesis", "--help")["--num-envs"] == "16; 128 with --preset fast"
    assert stated(capsys, "clone", "--preset", "thesis", "--help")["--ppo.learning-rate"].startswith(
        "8e-05; 0.003 with"
    )


def test_a_run_that_is_named_says_what_it_was_trained_with(tmp_path, capsys):
    run = RunFolder.create(tmp_path / "run", replace(build.find_game("1v1Free").start("fast"), num_envs=7))
    assert stated(capsys, "train", "--resume", str(run.path), "--help")["--num-envs"] == "7"


@pytest.mark.parametrize("preset", ["fast", "thesis"])
def test_clone_states_what_it_uses(preset, monkeypatch, capsys):
    used = []

    def opened(path):
        return SimpleNamespace(simulator=SIMULATOR_VERSION, path=path)

    monkeypatch.setattr(clone, "_begin", lambda config, demos, data: used.append(config.ppo) or 1 / 0)
    monkeypatch.setattr("regista.experiments.imitation.demonstrations.Demonstrations.open", opened)
    monkeypatch.setattr("regista.experiments.imitation.cloning_data.CloningData", lambda *settings: None)
    with pytest.raises(ZeroDivisionError):
        clone.main(["demos", "--preset", preset])
    rate = stated(capsys, "clone", "--preset", preset, "--help")["--ppo.learning-rate"].partition(";")[0]
    assert float(rate) == used[0].learning_rate
