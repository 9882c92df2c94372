"""Policies that are installed with Regista load, play, and beat the random policy on their game.

Read next: `run.shipped`.
"""

import shutil

import pytest

import regista
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.__main__ import main
from regista.experiments.commands.evaluate import EvaluateConfig, evaluator
from regista.experiments.run import shipped
from regista.experiments.run.build import find_game
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.evaluator import Evaluator
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.results import goal_rate, select
from ued.core.task import TRAINING_SCENE

NAMES = shipped.names()
EPISODES = 64
MAZE = "shipped:maze"
MOST = 250_000  # bytes of a policy


def said(words, capsys):
    capsys.readouterr()
    code = main(words)
    shown = capsys.readouterr()
    return code, shown.out + shown.err


def test_each_suite_has_a_policy():
    suites = {name.removeprefix(shipped.PREFIX).partition("/")[0] for name in NAMES}
    assert suites == {"1v1Restricted", "offense", "defense", "grf", "academy", "maze"}


@pytest.mark.parametrize("name", NAMES)
def test_a_policy_is_small_and_of_the_present_simulator(name):
    folder = shipped.located(name)
    run = RunFolder.open(folder)
    assert {path.name for path in folder.iterdir()} == {"config.json", "checkpoint.pt"}
    assert sum(path.stat().st_size for path in folder.iterdir()) < MOST
    assert find_game(run.config.minigame).short == name.removeprefix(shipped.PREFIX)
    assert run.simulator == (None if run.config.engine is None else SIMULATOR_VERSION)
    assert run.about["command"].startswith("regista train ") and set(run.about) <= {"command", "simulator"}


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_policy_plays_its_game(name, capsys):
    code, shown = said(["play", "--player", name], capsys)
    assert code == 0 and " steps by " in shown and "warning" not in shown


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.long
def test_a_policy_beats_the_random_one(name):
    """By intervals that are apart, on levels of its game's training distribution."""
    run = RunFolder.open(shipped.located(name))
    results = evaluator(run.config, EvaluateConfig(episodes=EPISODES, levels=0)).report([run]).results
    ours, random = (goal_rate(select(results, policy, TRAINING_SCENE)) for policy in (run.label, "random"))
    assert ours.low > random.high + 0.2


@pytest.mark.long
def test_policies_are_evaluated_by_name(capsys):
    code, shown = said(["evaluate", MAZE, "--episodes", "5", "--levels", "0"], capsys)
    assert code == 0 and "Labyrinth" in shown and "random" in shown
    assert regista.evaluate(MAZE, episodes=5).scenes


@pytest.mark.long
def test_policies_are_listed(capsys):
    _, everything = said(["list"], capsys)
    assert all(name in everything for name in NAMES) and MAZE in said(["list", "maze"], capsys)[1]
    assert "shipped" not in said(["list", "maze60"], capsys)[1] and "maze60" in BUILT_IN


@pytest.mark.parametrize("words", [["play", "--player"], ["evaluate"], ["play", "maze", "--player"]])
def test_an_unknown_name_is_refused_with_all_names(words, capsys):
    code, shown = said([*words, "shipped:mazes"], capsys)
    assert code == 2 and "there is no policy shipped:mazes (did you mean 'shipped:maze'?)" in shown
    assert all(name in shown for name in NAMES) and len(shown.splitlines()) == 1


@pytest.mark.parametrize("flag", ["--csv", "--markdown"])
def test_a_file_that_cannot_be_written_is_refused_before_the_evaluation(flag, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Evaluator, "report", lambda *_: pytest.fail("evaluated"))
    code, shown = said(["evaluate", MAZE, flag, str(tmp_path / "none" / "x.csv")], capsys)
    assert code == 2 and f"x.csv: the folder {tmp_path}/none does not exist" in shown
    code, shown = said(["evaluate", MAZE, flag, str(tmp_path)], capsys)
    assert code == 2 and f"{tmp_path} is a folder; give the name of a file" in shown


def test_a_name_that_is_near_to_none_is_refused_without_a_suggestion(capsys):
    code, shown = said(["play", "--player", "shipped:foo"], capsys)
    assert code == 2 and f"there is no policy shipped:foo; these are shipped: {', '.join(NAMES)}" in shown


@pytest.mark.parametrize("run", [MAZE, "runs/copy"])
def test_a_run_in_the_place_of_a_game_is_named_with_its_flag(run, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(shipped.located(MAZE), "runs/copy")
    code, shown = said(["play", run], capsys)
    assert code == 2 and f"{run} is a run, not a game; add --player: regista play --player {run}" in shown
    code, shown = said(["play", "--player", "runs/none"], capsys)
    assert code == 2 and "there is no folder runs/none; play needs a program" in shown


@pytest.mark.parametrize("name", ["shipped:", "shipped:..", "shipped:offense", "shipped:../run"])
def test_only_policies_have_names(name, capsys):
    assert said(["evaluate", name], capsys)[0] == 2


def test_a_policy_plays_another_game_of_the_same_observations_and_actions(capsys):
    code, shown = said(["play", "maze60", "--player", MAZE, "--steps", "5"], capsys)
    assert code == 0 and "5 steps by accel after" in shown


def test_a_policy_of_another_game_is_refused(capsys):
    code, shown = said(["play", "ued.probes:frontier", "--player", MAZE], capsys)
    assert code == 2 and f"{MAZE} is a run on maze, whose observations are " in shown
    assert "it cannot play probes-frontier, whose observations are Box(" in shown
    code, shown = said(["play", "1v1Free", "--player", MAZE], capsys)
    assert code == 2 and f"{MAZE} is a run on maze; it cannot play football" in shown


@pytest.mark.parametrize("words", [["train", "--resume"], ["transfer"], ["play", "--id", "1", "--level"]])
def test_other_commands_name_the_folder_to_copy(words, capsys):
    code, shown = said([*words, MAZE], capsys)
    assert code == 2 and f"accept {MAZE}; copy its folder, {shipped.located(MAZE)}," in shown


@pytest.mark.slow
def test_a_copy_is_a_run_from_which_training_starts(tmp_path, capsys):
    copy = shutil.copytree(shipped.located(MAZE), tmp_path / "copy")
    short = ["--total-env-steps", "256", "--num-envs", "4", "--num-steps", "32", "--eval-every", "0", "--no-record"]
    code, shown = said(["train", "maze", "--from", str(copy), *short, "--out", str(tmp_path / "out")], capsys)
    assert code == 0, shown
    assert regista.load_policy(copy).observation_space is not None
