"""What is said of a budget before training and at its end."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from regista.experiments.__main__ import main
from regista.experiments.run import build
from regista.experiments.run.config import task_presets
from regista.experiments.run.events import Learning
from regista.experiments.run.outlook import outlook, tell, warn_of_annealing
from regista.experiments.run.table import read_columns, read_rows
from ued.config import (
    ACCELConfig,
    AdversaryConfig,
    ALPGMMConfig,
    NCCConfig,
    PairedConfig,
    PairedLiteralConfig,
    PLRConfig,
    SFLConfig,
)
from ued.methods import METHODS
from ued.probes import Frontier

FILE = """
import gymnasium, ued

def put(env, values):
    env.unwrapped.g = values["g"]

def make(n):
    return ued.GymUPOMDP(lambda: gymnasium.make("Pendulum-v1", max_episode_steps=LIMIT), put, {"g": (5.0, 15.0)}, n)

task = ued.Task(make)
"""


def looked(name, settings=None, limit=1000, envs=16, total=100_000):
    config = replace(task_presets()["fast"], method=name, total_env_steps=total, num_envs=envs)
    if settings is not None:
        config = replace(config, **{METHODS[name].group: settings})
    method = build.make_method(config, Frontier(envs, 4))
    method.upomdp.max_episode_steps = limit
    return outlook(config, method)


def test_the_line_says_how_many_levels_there_are_and_when_the_method_begins():
    assert looked("dr").line() == "about 100 levels of at most 1_000 steps per episode"
    assert looked("dr", limit=100_000).line() == "about 1 level of at most 100_000 steps per episode"
    assert looked("accel").line() == (
        "about 100 levels of at most 1_000 steps per episode; "
        "ACCEL starts replay after 500 levels or 10_000 env_steps, whichever comes first"
    )
    assert looked("plr", limit=10).line().endswith("; PLR starts replay after 500 levels")
    assert looked("plr", PLRConfig(min_fill=0.01)).line().endswith("; PLR starts replay after 10 levels")
    paired = looked("paired").line()
    assert paired.startswith("about 25 levels of at most 1_000 steps per episode, 4_000 env_steps each; PAIRED updates")
    assert "starts replay" in looked("repaired").line() and "updates its adversary" in looked("repaired").line()


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("dr", None, "each of 64 environments plays fewer than 2 levels; --total-env-steps 128_000 would be enough"),
        (
            "accel",
            ACCELConfig(min_fill=0.5),
            "replay starts only after 500 levels; use a longer run or a smaller --accel.min",
        ),
        ("robust_plr", PLRConfig(min_fill=0.5), "a smaller --plr.min-fill"),
        ("paired", PairedConfig(adversary=AdversaryConfig(min_batch=32)), "a smaller --paired.adversary.min-batch"),
        ("alp_gmm", ALPGMMConfig(), "the first mixture is fitted only after 250 levels"),
        ("sfl", SFLConfig(), "levels are selected only after 1_024 levels"),
        (
            "ncc",
            NCCConfig(min_fill=0.5),
            "replay starts only after 128 levels; use a longer run or a smaller --ncc.min",
        ),
        ("paired_literal", PairedLiteralConfig(), "can be longer than a rollout of 64 steps"),
    ],
)
def test_a_budget_that_is_too_small_is_warned_of(name, settings, words):
    found = list(looked(name, settings, envs=64 if name == "dr" else 4).shortcomings())
    assert any(words in text for text in found)
    assert not list(looked(name, settings, limit=10, total=10_000_000).shortcomings())


def test_a_limit_that_nobody_knows_is_said(capsys):
    said = []
    method = SimpleNamespace(upomdp=SimpleNamespace(max_episode_steps=None))
    tell(SimpleNamespace(), method, said.append)
    (line,) = said
    assert line.startswith("the environment declares no step limit, so the number of levels in this run is unknown")
    assert line.endswith("TimeLimit, or, in a UPOMDP class of your own, set self.max_episode_steps")


def test_a_run_that_goes_on_at_a_learning_rate_of_0_is_warned_of(capsys):
    config = task_presets()["fast"]
    for annealed, total in ((0, 3_000), (3_000, 3_000), (3_000, 4_321)):
        warn_of_annealing(replace(config, total_env_steps=total, ppo=replace(config.ppo, anneal_env_steps=annealed)))
    said = capsys.readouterr().err
    assert said.startswith("warning: students do not learn from 3_000 of 4_321 env_steps on") and said.count("\n") == 1


def trained(tmp_path, limit, *words):
    (tmp_path / "long_task.py").write_text(FILE.replace("LIMIT", str(limit)))
    small = ["--num-envs", "4", "--num-steps", "20", "--update-epochs", "1", "--hidden-size", "8", "--no-record"]
    command = ["train", f"{tmp_path}/long_task.py:task", *small, "--eval-every", "0", "--out", str(tmp_path / "run")]
    assert main([*command, *words]) == 0
    return tmp_path / "run"


@pytest.mark.long
def test_long_episodes_do_not_keep_accel_from_learning(tmp_path, capsys):
    run = trained(tmp_path, 250, "--method", "accel", "--total-env-steps", "10_000")
    steps = read_columns(run / "metrics.csv")["student/gradient_steps"]
    assert (steps > 0).mean() > 0.5
    out = capsys.readouterr().out
    assert "about 40 levels of at most 250 steps per episode; ACCEL starts replay after 500 levels or 1_000" in out
    texts = [row["text"] for row in read_rows(run / "events.csv")]
    assert texts and all("steps so far, the limit is 250" in text for text in texts)  # none has learned nothing


@pytest.mark.long
def test_a_run_that_learns_nothing_says_so_before_during_and_after(tmp_path, capsys):
    words = ["--method", "accel", "--total-env-steps", "4000", "--accel.min-fill", "0.5"]
    run = trained(tmp_path, 250, *words)
    shown = capsys.readouterr()
    assert "too small for ACCEL: about 16 levels; replay starts only after 500 levels" in shown.err
    events = [(row["update"], row["event"], row["text"]) for row in read_rows(run / "events.csv")]
    told = [event for event in events if event[1] == "no learning"]
    assert [event[0] for event in told] == ["25", "50"]
    assert told[-1][2] == "student has taken no gradient step in 50 updates (4k env_steps)"
    assert shown.out.strip().splitlines()[-1] == told[-1][2]


def test_one_update_is_singular():
    learning = Learning()
    learning.look({"env_steps": 64, "student/gradient_steps": 0})
    assert [event.text for event in learning.seldom()] == [
        "student has taken no gradient step in 1 update (64 env_steps)"
    ]
