"""How much is evaluated: rounds of episodes that fit into a time, what is said of it, and how far it is."""

import json

import numpy as np
import pytest

from regista.experiments.__main__ import main
from regista.experiments.run import watch
from regista.experiments.run.evaluator import joined
from regista.experiments.run.watch import Watch
from ued.evaluation import Evaluation


class Clock:
    """Stands in for `time`: seconds pass when they are told to."""

    now = 0.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(watch, "time", clock)
    return clock


def test_no_batch_begins_that_would_not_end_in_time(clock):
    watched, batches = Watch(1_000, seconds=60.0), 0
    going = True
    while going:
        clock.now += 7.0  # of each batch of 8 episodes
        batches += 1
        going = watched.go_on(8)
    assert batches == 8  # a ninth would have ended after 63 s
    assert watched.done == 64


def test_one_batch_is_played_however_long_it_takes(clock):
    watched = Watch(200, seconds=60.0)
    clock.now += 500.0
    assert not watched.go_on(8)


def test_without_a_limit_all_is_played(clock):
    watched = Watch(200)
    clock.now += 1e6
    assert watched.go_on(8)


def test_progress_and_time_left_are_shown_once_it_takes_long(clock, capsys):
    watched = Watch(100)
    watched.ended(10)
    assert capsys.readouterr().err == ""
    clock.now += 10.0
    watched.ended(10)
    assert "20%  20 episodes" in capsys.readouterr().err
    watched.finish()
    assert "20 episodes, 10 s" in capsys.readouterr().err


def test_other_things_than_episodes_are_counted_too(clock, capsys):
    watched = Watch(2, unit="replay")
    clock.now += 10.0
    watched.ended(1)
    watched.finish()
    told = capsys.readouterr().err
    assert "50%  1 replay\n" in told and "1 replay, 10 s" in told


def evaluation(returns, levels):
    count = len(returns)
    index = np.arange(count) % levels
    returns = np.array(returns, float)
    return Evaluation(returns, (returns > 0) * 1.0, np.full(count, 5), index, np.arange(levels), 5 * count)


def test_rounds_of_a_policy_are_one_evaluation_whose_levels_stay_apart():
    whole = joined([evaluation([1, 0, 1, 1], 2), evaluation([0, 0, 1], 3)])
    assert whole.returns.tolist() == [1, 0, 1, 1, 0, 0, 1]
    assert whole.level.tolist() == [0, 1, 0, 1, 2, 3, 4]
    assert (len(whole.levels), whole.env_steps) == (5, 35)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "run"
    steps = ["--total-env-steps", "64", "--num-envs", "4", "--num-steps", "8", "--eval-every", "0", "--no-record"]
    assert main(["train", "1v1Restricted", "--method", "dr", *steps, "--out", str(out)]) == 0
    return out


@pytest.mark.slow
def test_evaluate_plays_whole_rounds_with_all_policies_alike(run, capsys):
    assert main(["evaluate", str(run), "--minutes", "0.01", "--levels", "0", "--json"]) == 0
    told = capsys.readouterr()
    episodes = {row["episodes"] for row in json.loads(told.out)["results"]}
    assert len(episodes) == 1  # dr, shoot, random and built-in, on each scene
    assert not episodes.pop() % 8
    assert "rounds of 8 episodes on each of 4 scenes by each of 4 policies for at most 0.01 minutes" in told.err


@pytest.mark.long
def test_other_rounds_are_of_other_episodes(run, capsys):
    rows = []
    for minutes in ("0.000001", "0.05"):
        assert main(["evaluate", str(run), "--minutes", minutes, "--levels", "0", "--no-baselines", "--json"]) == 0
        rows.append(json.loads(capsys.readouterr().out)["results"])
    once, often = rows
    assert often[0]["episodes"] > once[0]["episodes"] == 8
    assert [row["mean_length"] for row in once] != [row["mean_length"] for row in often]


@pytest.mark.slow
def test_episodes_and_minutes_exclude_each_other(run, capsys):
    assert main(["evaluate", str(run), "--minutes", "1", "--episodes", "5"]) == 2
    assert "episodes or minutes, not both" in capsys.readouterr().err
