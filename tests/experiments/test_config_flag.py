"""`--config FILE` takes the settings of a run back; flags beside it win."""

import json

import pytest

from regista.experiments.__main__ import main
from regista.experiments.calls import compare as compare_in_python
from regista.experiments.calls import train as train_in_python
from regista.experiments.commands import compare, train
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder
from ued.config import ACCELConfig

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


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["", "config.json"])
def test_a_run_of_the_same_settings_gives_the_same_numbers(run, name, tmp_path):
    assert main(["train", "--config", str(run / name), "--out", str(tmp_path / "again")]) == 0
    again = RunFolder.open(tmp_path / "again")
    assert again.config == RunFolder.open(run).config and again.about != RunFolder.open(run).about
    rows = [(path / "levels.csv").read_text() for path in (run, again.path)]
    assert rows[0] == rows[1]


@pytest.mark.slow
def test_a_run_that_started_from_a_student_warns_that_the_settings_do_not_hold_it(run, tmp_path, capsys):
    tuned = tmp_path / "tuned"
    assert main(["train", GAME, "--method", "dr", *SMALL, "--from", str(run), "--out", str(tuned)]) == 0
    capsys.readouterr()
    again = ["train", "--config", str(tuned), "--out"]
    assert main([*again, str(tmp_path / "new")]) == 0
    assert f"warning: {tuned} started from {run}; this run starts from a new student without --from {run}" in (
        capsys.readouterr().err
    )
    assert main([*again, str(tmp_path / "same"), "--from", str(run)]) == 0
    assert "started from" not in capsys.readouterr().err


@pytest.mark.slow
def test_a_budget_below_what_a_run_has_done_is_refused(run, capsys):
    before = (run / "config.json").read_bytes()
    assert main(["train", "--resume", str(run), "--total-env-steps", "128"]) == 1
    assert f"{run} has 256 env_steps; it cannot continue with total_env_steps = 128" in capsys.readouterr().err
    assert (run / "config.json").read_bytes() == before
    assert main(["train", "--resume", str(run), "--total-env-steps", "256"]) == 0


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


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (
            [GAME, "--method", "plr", "--paired.roles", "flexible"],
            "--paired.roles is a setting of paired; plr would not",
        ),
        ([GAME, "--plr.score", "mna"], "--plr.score is a setting of plr and robust_plr; paired would not use it"),
        (["--config", "{run}", "--method", "dr", "--plr.score", "mna"], "--plr.score is a setting of plr and"),
        (["--resume", "{run}", "--alp-gmm.fit-every", "20"], "--alp-gmm.fit-every is a setting of alp_gmm; plr would"),
        (
            [GAME, "--seeds", "2", "--method", "dr", "--paired.adversary.ent-coef", "0"],
            "--paired.adversary.ent-coef is a setting of paired; dr would not use it",
        ),
    ],
)
def test_flags_of_another_method_are_refused(run, words, sentence, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["train", *(word.format(run=run) for word in words)]) == 2
    assert capsys.readouterr().err.startswith(f"regista: {sentence}")
    assert not [*tmp_path.iterdir()]


def test_settings_of_another_method_from_files_and_presets_are_kept(run, tmp_path):
    """The file sets plr.replay_prob, the preset paired.roles."""
    typed = train._typed(["--config", str(run), "--method", "dr", "--out", str(tmp_path / "one")])
    assert train._begin(typed).config.plr.replay_prob == 0.25
    typed = train._typed(["--preset", "thesis", "--method", "dr", "--out", str(tmp_path / "two")])
    assert train._begin(typed).config.paired.roles == "dennis2020"
    assert main(["train", "--resume", str(run), "--plr.replay-prob", "0.25"]) == 0
    config, _ = compare._read(["--config", str(run), "--methods", "dr"])
    assert config.train.plr.replay_prob == 0.25


@pytest.mark.parametrize("rows", [["--methods", "dr", "accel"], ["--methods", "dr", "--variants", "a: --method accel"]])
def test_one_compared_method_must_use_a_flag(rows, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    config, _ = compare._read([GAME, *rows, "--accel.num-edits", "3"])
    assert config.train.accel.num_edits == 3
    assert main(["compare", GAME, *rows, "--plr.score", "mna"]) == 2
    expected = "--plr.score is a setting of plr and robust_plr; dr and accel would not use it"
    assert capsys.readouterr().err.startswith(f"regista: {expected}")
    assert not [*tmp_path.iterdir()]


def test_python_refuses_them_too(tmp_path):
    with pytest.raises(UsageError, match="accel is a setting of accel; plr would not use it"):
        train_in_python(GAME, "plr", out=tmp_path / "run", accel=ACCELConfig())
    with pytest.raises(UsageError, match="accel is a setting of accel; dr and plr would not use it"):
        compare_in_python(GAME, ["dr", "plr"], out=tmp_path / "both", accel=ACCELConfig())


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


@pytest.mark.parametrize(("content", "what"), [(b"GIF89a\xf7\xff", "not a text file"), (b"epochs: 3", "not JSON")])
def test_a_file_of_another_kind_is_refused_with_what_is_right(content, what, tmp_path, capsys):
    file = tmp_path / "maze.gif"
    file.write_bytes(content)
    assert main(["train", "--config", str(file)]) == 1
    message = capsys.readouterr().err
    assert f"{file} is {what}" in message and "expected the config.json of a run, or its folder" in message
    assert "codec" not in message
