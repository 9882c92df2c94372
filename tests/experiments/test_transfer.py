"""`regista transfer`: episodes in two engines, ratios, features that leave their range, where goals come from."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from envs.football.constants import CB, GK, GOAL, OUT_OF_PLAY
from envs.football.kick_off import Roster
from envs.football.observation.simple115 import SIZE, simple115_names
from experiments.__main__ import main
from experiments.grf.episodes import NO_ACTION, Episodes, join
from experiments.grf.goals import goals_of
from experiments.grf.transfer import Transfer, leaving, rate_ratio, summary
from tests.envs.grf.fixtures import fake_python, real_python

STEPS = 4
ROSTER = Roster([0, 0, 1], [GK, CB, GK])


def episodes(goals, count, **changes):
    """Return so many episodes of which so many are scored, of three players; the second one has the ball."""
    scored = np.arange(count) < goals
    fields = {
        "ball": np.zeros((count, STEPS + 1, 3)),
        "places": np.zeros((count, STEPS + 1, 3, 2)),
        "owner": np.ones((count, STEPS + 1), int),
        "actions": np.full((count, STEPS), 5),
        "observations": np.zeros((count, STEPS, 2), np.float32),
        "lengths": np.full(count, STEPS),
        "ended": np.where(scored, GOAL, OUT_OF_PLAY),
        "score": np.stack([scored, 0 * scored], 1).astype(int),
        "returns": scored.astype(float),
    }
    return Episodes(**fields | changes)


def transfer(ours, grf, name="run"):
    features = {"names": ("a", "b"), "unit": np.ones(2), "mean": np.zeros(2), "deviation": np.ones(2)}
    return Transfer(name, "game", "sampled", ours, grf, ROSTER, **features)


def test_a_summary_counts_goals_endings_and_keys():
    actions = np.array([[5, 5, 12, NO_ACTION]] * 4)
    found = summary(episodes(1, 4, actions=actions))
    assert (found["goals"], found["goal_rate"], found["median_length"]) == (1, 0.25, 4.0)
    assert found["endings"]["scored"] == 0.25 and found["endings"]["out of play"] == 0.75
    assert found["actions"][5] == pytest.approx(2 / 3) and sum(found["actions"]) == pytest.approx(1)
    assert found["goal_rate_low"] < 0.25 < found["goal_rate_high"]


def test_the_ratio_of_one_run_is_over_its_episodes_and_of_several_over_runs():
    one = transfer(episodes(80, 100), episodes(40, 100))
    assert one.ratio.estimate == pytest.approx(0.5)
    assert 0.35 < one.ratio.low < 0.45 and 0.55 < one.ratio.high < 0.65
    runs = [one, transfer(episodes(90, 100), episodes(90, 100)), transfer(episodes(85, 100), episodes(10, 100))]
    several = rate_ratio(runs)
    assert several.estimate == pytest.approx(140 / 255)
    assert several.low < 0.3 and several.high > 0.9  # runs differ more than the luck of one of them


def test_where_nothing_is_scored_here_there_is_no_ratio_and_where_nothing_is_there_it_is_about_none():
    assert np.isnan(transfer(episodes(0, 100), episodes(40, 100)).ratio.estimate)
    ratio = transfer(episodes(90, 100), episodes(0, 100)).ratio
    assert ratio.estimate == 0 and 0 <= ratio.low < ratio.high < 0.1


def test_the_first_step_outside_counts_and_names_the_feature():
    outside = np.zeros((4, 6, 3), bool)
    outside[0, 2:, 1] = outside[1, 4, 1] = outside[1, 5, 2] = True
    found = leaving(outside, ("a", "b", "c"))
    assert (found.share, found.step, found.first) == (0.5, 3.0, ("b",))
    assert "never" in leaving(outside[2:], ("a", "b", "c")).line()


def test_features_leave_ours_by_more_than_a_tenth_of_their_unit():
    seen = np.zeros((2, STEPS, 2), np.float32)
    seen[0, 1, 0], seen[1, 3, 0] = 0.05, 0.2
    seen[1, 0, 1] = 7.0
    seen[0, 3] = np.nan  # after the end
    found = transfer(episodes(1, 2), episodes(1, 2, observations=seen))
    assert found.leaves_ours() == leaving(np.abs(np.nan_to_num(seen)) > 0.1, ("a", "b"))
    assert found.leaves_training().first == ("b",) and found.leaves_training("ours").share == 0


def test_goals_come_from_where_the_left_team_had_the_ball_last():
    ball, places = np.zeros((3, STEPS + 1, 3)), np.zeros((3, STEPS + 1, 3, 2))
    owner = np.tile([-1, 1, 1, 2, -1], (3, 1))  # the keeper has touched it, too
    ball[:, 2, 0], places[:, 2, 2, 0] = (44.0, 20.0, 44.0), (54.0, 30.0, 54.0)
    found = goals_of(episodes(2, 3, ball=ball, places=places, owner=owner), ROSTER)
    np.testing.assert_allclose(found.distance, [11, 35])
    np.testing.assert_allclose(found.keeper_out, [1, 25])
    assert found.summary()["distance_shares"] == {"<11": 0.5, "<20": 0.0, "<30": 0.0, ">30": 0.5}
    assert "2 goals from 23 m" in found.line()
    alone = goals_of(episodes(2, 3, ball=ball, places=places, owner=owner), Roster([0, 0, 1], [GK, CB, CB]))
    assert "no keeper" in alone.line()
    assert goals_of(episodes(0, 3), ROSTER).line() == "no goal"


def test_joined_episodes_stay_where_they_ended():
    short = episodes(1, 1)
    cut = replace(short, ball=short.ball[:, :3] + 1, places=short.places[:, :3], owner=short.owner[:, :3])
    cut = replace(cut, actions=short.actions[:, :2], observations=short.observations[:, :2], lengths=np.array([2]))
    both = join([short, cut])
    assert both.ball.shape == (2, STEPS + 1, 3) and (both.ball[1] == 1).all()
    assert both.actions[1].tolist() == [5, 5, NO_ACTION, NO_ACTION] and np.isnan(both.observations[1, 2:]).all()


def test_every_entry_of_simple115_has_a_name():
    names = simple115_names()
    assert len(names) == len(set(names)) == SIZE
    at = {names.index(name) for name in ("our1.dx", "their0.x", "ball.x", "owned.ours", "active.0", "mode.0")}
    assert at == {24, 44, 88, 95, 97, 108}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run that has learned nothing yet."""
    out = tmp_path_factory.mktemp("runs") / "short"
    words = ["train", "academy/pass_and_shoot_with_keeper", "--method=dr", "--representation=simple115"]
    short = ["--total-env-steps=64", "--num-envs=4", "--num-steps=8", "--eval-every=0", "--no-record"]
    assert main([*words, *short, "--out", str(out)]) == 0
    return out


@pytest.fixture(params=["ours twice", "stand-in", "real"])
def engine(request, tmp_path):
    """Flags of a second engine."""
    if request.param == "ours twice":
        return ["--engine", "regista"]
    python = real_python() if request.param == "real" else str(fake_python(tmp_path))
    return ["--grf-python", python, "--grf-workers", "1"]


def test_the_command_tells_of_both_engines(run, engine, capsys, tmp_path):
    files = ["--csv", str(tmp_path / "t.csv"), "--traces", str(tmp_path / "t.rrd"), "--trace-episodes", "2"]
    words = ["transfer", str(run), "--episodes", "6", "--grf-episodes", "4", *engine, *files]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [each["policy"] for each in found] == ["sampled", "greedy"]
    assert [found[0]["engines"][name]["episodes"] for name in ("ours", "grf")] == [6, 4]
    with open(tmp_path / "t.csv") as file:
        rows = list(csv.DictReader(file))
    assert [(row["policy"], row["engine"]) for row in rows] == [
        (policy, engine) for policy in ("sampled", "greedy") for engine in ("ours", "grf")
    ]
    assert sum(float(row[name]) for name in rows[0] if name.startswith("ended/") for row in rows[:1]) == pytest.approx(
        1
    )
    assert (tmp_path / "t.rrd").stat().st_size > 1000


def test_the_tables_can_be_read(run, capsys):
    assert main(["transfer", str(run), str(run), "--episodes", "4", "--grf-episodes", "4", "--engine", "regista"]) == 0
    shown = capsys.readouterr().out
    assert "2 runs of academy/pass_and_shoot_with_keeper, simple115, dr" in shown
    assert "features leave what ours shows" in shown and "goals, grf:" in shown


def test_without_runs_or_without_the_engine_it_says_so(run, capsys, tmp_path):
    assert main(["transfer"]) == 2
    assert main(["transfer", str(run), "--episodes", "1", "--grf-python", str(tmp_path / "none")]) == 1
    assert "make grf" in capsys.readouterr().err
