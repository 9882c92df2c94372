"""`--config FILE` takes the settings of a run back; flags beside it win."""

import json

import pytest

from regista.experiments.__main__ import main
from regista.experiments.commands import compare, train
from regista.experiments.run.folder import RunFolder

GAME = "ued.probes:frontier"
SMALL = ["--total-env-steps", "256", "--num-envs", "4", "--num-steps", "32", "--eval-every", "0", "--no-record"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("settings") / "run"
    flags = ["--method", "plr", "--learning-rate", "0.002", "--plr.replay-prob", "0.25", "--seed", "3"]
    assert main(["train", GAME, *flags, *SMALL, "--out", str(out)]) == 0
    return out


def edited(run, folder, **changes):
    """Return a copy of the run's config.json with other values; None removes a key."""
    data = json.loads((run / "config.json").read_text())
    data |= changes
    file = folder / "edited.json"
    file.write_text(json.dumps({key: value for key, value in data.items() if value is not None}))
    return str(file)


@pytest.mark.parametrize("name", ["", "config.json"])
def test_a_run_of_the_same_settings_gives_the_same_numbers(run, name, tmp_path):
    assert main(["train", "--config", str(run / name), "--out", str(tmp_path / "again")]) == 0
    again = RunFolder.open(tmp_path / "again")
    assert again.config == RunFolder.open(run).config and again.about != RunFolder.open(run).about
    rows = [(path / "levels.csv").read_text() for path in (run, again.path)]
    assert rows[0] == rows[1]


def test_flags_win(run, tmp_path):
    words = ["--seed", "4", "--learning-rate", "0.001", "--out", str(tmp_path / "out")]
    typed = train._typed(["--config", str(run), *words])
    config = train._begin(typed).config
    assert (config.seed, config.ppo.learning_rate) == (4, 0.001)
    assert (config.minigame, config.method, config.plr.replay_prob, config.num_envs) == (GAME, "plr", 0.25, 4)


def test_compare_takes_them_too(run):
    config, game = compare._read(["--config", str(run), "--methods", "dr", "accel", "--num-envs", "8"])
    assert game.name == GAME and config.methods == ("dr", "accel")
    assert (config.train.ppo.learning_rate, config.train.num_envs, config.train.total_env_steps) == (0.002, 8, 256)


def test_help_states_the_defaults_of_the_file(run, capsys):
    with pytest.raises(SystemExit):
        train._typed(["--config", str(run), "--help", "ppo"])
    assert "default 0.002)" in capsys.readouterr().out


def test_older_files_open(run, tmp_path):
    file = edited(run, tmp_path, levels_format=None, device=None, ncc=None)  # settings that they lack
    config = train._begin(train._typed(["--config", file, "--out", str(tmp_path / "out")])).config
    assert config == RunFolder.open(run).config


@pytest.mark.parametrize(
    ("change", "words", "message"),
    [
        ({"num_env": 3}, [], "unknown key 'num_env' (did you mean 'num_envs'?)"),
        ({"num_envs": "many"}, [], "'num_envs' must be int, got \"many\""),
        ({"num_envs": 0}, [], "num_envs"),
        ({}, ["--preset", "fast"], "--preset and --config exclude each other"),
        ({}, ["1v1Free"], "which do not apply to 1v1Free"),
    ],
)
@pytest.mark.parametrize("command", ["train", "compare"])
def test_what_does_not_fit_is_refused(command, change, words, message, run, tmp_path, capsys):
    file = edited(run, tmp_path, **change)
    assert main([command, *words, "--config", file, "--out", str(tmp_path / "out")]) in (1, 2)
    assert message in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_missing_file_and_a_resumed_run_are_refused(run, tmp_path, capsys):
    assert main(["train", "--config", str(tmp_path / "none.json")]) == 2
    assert "there is no file" in capsys.readouterr().err
    assert main(["train", "--resume", str(run), "--config", str(run)]) == 2
    assert "--config and --resume exclude each other" in capsys.readouterr().err
