"""`regista transfer`: episodes in two engines, ratios, features that leave their range, where goals come from."""

import csv
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from regista.envs.football.constants import CB, GK, GOAL, OUT_OF_PLAY
from regista.envs.football.kick_off import Roster
from regista.envs.football.observation.simple115 import SIZE, simple115_names
from regista.experiments.__main__ import main
from regista.experiments.transfer import goals
from regista.experiments.transfer.episodes import NO_ACTION, Episodes, join
from regista.experiments.transfer.goals import goals_of
from regista.experiments.transfer.replaying import Played, Result, leaving, summary
from regista.experiments.transfer.report import by_game, groups, rate_ratio, verdict
from ued.core import checkpoint

pytestmark = pytest.mark.slow

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


def played(ours, grf):
    return Played(ours, grf, ROSTER, names=("a", "b"), unit=np.ones(2), mean=np.zeros(2), deviation=np.ones(2))


def result(ours, grf, run="run", game="game", policy="sampled"):
    """Return what a run of a hundred episodes in either engine is worth, of which so many are scored."""
    return Result(run, game, "features", "dr", policy, **played(episodes(ours, 100), episodes(grf, 100)).numbers())


def test_a_summary_counts_goals_endings_and_keys():
    actions = np.array([[5, 5, 12, NO_ACTION]] * 4)
    found = summary(episodes(1, 4, actions=actions), ROSTER)
    assert (found["goals"], found["episodes"], found["median_length"]) == (1, 4, 4.0)
    assert found["endings"]["scored"] == 0.25 and found["endings"]["out of play"] == 0.75
    assert found["actions"][5] == pytest.approx(2 / 3) and sum(found["actions"]) == pytest.approx(1)


def test_the_ratio_of_one_run_is_over_its_episodes_and_of_several_over_runs():
    one = result(80, 40)
    ratio = rate_ratio([one])
    assert ratio.estimate == pytest.approx(0.5)
    assert 0.35 < ratio.low < 0.45 and 0.55 < ratio.high < 0.65
    assert not rate_ratio([one, result(90, 90), result(85, 10)]).known  # too few runs
    several = rate_ratio([one, result(90, 90), result(85, 10), one, result(85, 10)])
    assert several.estimate == pytest.approx(190 / 420)
    assert several.low < 0.2 and several.high > 0.8  # runs differ more than the luck of one of them


def test_where_nothing_is_scored_here_there_is_no_ratio_and_where_nothing_is_there_it_is_about_none():
    assert np.isnan(rate_ratio([result(0, 40)]).estimate)
    ratio = rate_ratio([result(90, 0)])
    assert ratio.estimate == 0 and 0 <= ratio.low < ratio.high < 0.1


def test_runs_of_a_game_that_see_the_same_are_told_of_together():
    runs = [result(80, 60, "a-0"), result(90, 90, "a-1"), result(0, 0, game="b"), result(80, 8, policy="greedy")]
    assert [len(each.results) for each in groups(runs)] == [2, 1, 1]
    head, *rows = by_game(runs)
    assert [dict(zip(head, row, strict=True))["runs"] for row in rows] == ["2", "1", "1"]
    assert rows[0][5] == "0.85" and rows[0][7] == "0.88" and rows[1][7] == "no goal in ours"
    assert "sampled: 1 of 2 ratios at 0.8 or more, 0 below 0.5" in verdict(runs)
    assert "greedy: 0 of 1 ratios at 0.8 or more, 1 below 0.5" in verdict(runs)


def test_the_first_step_outside_counts_and_names_the_feature():
    outside = np.zeros((4, 6, 3), bool)
    outside[0, 2:, 1] = outside[1, 4, 1] = outside[1, 5, 2] = True
    found = leaving(outside, ("a", "b", "c"))
    assert (found.share, found.step, found.first) == (0.5, 3.0, ("b",)) and "at step 3: b" in found.line()
    assert "never" in leaving(outside[2:], ("a", "b", "c")).line()


def test_features_leave_ours_by_more_than_a_tenth_of_their_unit():
    seen = np.zeros((2, STEPS, 2), np.float32)
    seen[0, 1, 0], seen[1, 3, 0] = 0.05, 0.2
    seen[1, 0, 1] = 7.0
    seen[0, 3] = np.nan  # after the end
    found = played(episodes(1, 2), episodes(1, 2, observations=seen))
    assert found.leaves_ours() == leaving(np.abs(np.nan_to_num(seen)) > 0.1, ("a", "b"))
    assert found.leaves_training().first == ("b",)
    assert replace(found, ours=found.grf).leaves_training().step is None  # ours shows as much


def test_goals_come_from_where_the_left_team_had_the_ball_last():
    ball, places = np.zeros((3, STEPS + 1, 3)), np.zeros((3, STEPS + 1, 3, 2))
    owner = np.tile([-1, 1, 1, 2, -1], (3, 1))  # the keeper has touched it, too
    ball[:, 2:, 0] = np.array([[44.0], [20.0], [44.0]])
    places[:, 2, 2, 0] = 54.0, 30.0, 54.0
    found = goals_of(episodes(2, 3, ball=ball, places=places, owner=owner), ROSTER)
    np.testing.assert_allclose(found.distance, [11, 35])
    np.testing.assert_allclose(found.keeper_out, [1, 25])
    assert found.summary()["distance_shares"] == {"<11": 0.5, "11 to 20": 0.0, "20 to 30": 0.0, ">30": 0.5}
    assert goals.line(found.summary()).startswith("2 goals from 23 m (50% <11, 50% >30)")
    alone = goals_of(episodes(2, 3, ball=ball, places=places, owner=owner), Roster([0, 0, 1], [GK, CB, CB]))
    assert "no keeper" in goals.line(alone.summary())
    assert goals.line(goals_of(episodes(0, 3), ROSTER).summary()) == "no goal"


def test_a_goal_comes_from_who_has_kicked_first_time_and_not_from_who_has_passed():
    ball, places = np.zeros((2, STEPS + 1, 3)), np.full((2, STEPS + 1, 3, 2), -40.0)
    owner = np.tile([1, -1, -1, -1, -1], (2, 1))
    ball[:, :, 0], ball[:, :, 1] = (30.0, 32.0, 34.0, 36.5, 39.0), (20.0, 15.0, 10.0, 10.0, 10.0)
    places[0, 2, 0], places[1, 2, 2] = (34.5, 10.0), (34.5, 10.0)  # a mate beside the ball; an opponent
    scored = goals_of(episodes(2, 2, ball=ball, places=places, owner=owner), ROSTER)
    np.testing.assert_allclose(scored.distance, [np.hypot(55 - 34, 10), np.hypot(55 - 30, 20)])


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
    """Return a run that has learned nothing yet."""
    out = tmp_path_factory.mktemp("runs") / "short"
    words = ["train", "academy/pass_and_shoot_with_keeper", "--method=dr", "--representation=simple115"]
    short = ["--total-env-steps=64", "--num-envs=4", "--num-steps=8", "--eval-every=0", "--no-record"]
    assert main([*words, *short, "--out", str(out)]) == 0
    return out


@pytest.mark.long
def test_the_command_tells_of_both_engines(run, engine, capsys, tmp_path):
    files = ["--csv", str(tmp_path / "t.csv"), "--traces", str(tmp_path / "t.rrd"), "--trace-episodes", "2"]
    words = ["transfer", str(run), "--episodes", "6", "--grf-episodes", "4", *engine, *files]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [each["policy"] for each in found["runs"]] == ["sampled", "greedy"]
    assert [found["runs"][0][name]["episodes"] for name in ("ours", "grf")] == [6, 4]
    assert [each["runs"] for each in found["groups"]] == [1, 1]
    with open(tmp_path / "t.csv") as file:
        rows = list(csv.DictReader(file))
    assert [(row["policy"], row["engine"]) for row in rows] == [
        (policy, engine) for policy in ("sampled", "greedy") for engine in ("ours", "grf")
    ]
    ended = [float(value) for name, value in rows[0].items() if name.startswith("ended/")]
    assert sum(ended) == pytest.approx(1) and "nan" not in rows[0].values()
    assert (tmp_path / "t.rrd").stat().st_size > 1000


def test_the_tables_can_be_read_and_what_was_played_is_kept(run, capsys, tmp_path):
    twice = ["--episodes", "4", "--grf-episodes", "4", "--engine", "regista", "--markdown", str(tmp_path / "t.md")]
    assert main(["transfer", str(run), str(run), *twice]) == 0
    shown = capsys.readouterr()
    assert "pass_and_shoot_with_keeper  simple115     dr      sampled  2 " in shown.out
    assert (
        "features outside the range of our episodes" in shown.out
        and "goals, grf:" in shown.out
        and "nan" not in shown.out
    )
    assert (tmp_path / "t.md").read_text().count("| academy/pass_and_shoot_with_keeper | simple115 |") == 2
    assert main(["transfer", str(run), str(run), *twice, "--kept"]) == 0
    again = capsys.readouterr()
    assert again.out == shown.out and again.err.count("saved results") == 2
    assert main(["transfer", str(run), "--kept", "--policies", "greedy", "--no-details", *twice]) == 0
    other = capsys.readouterr()
    assert "saved" not in other.err and "sampled" not in other.out and "features" not in other.out


def test_a_run_of_a_simulator_that_kept_its_matches_otherwise_can_still_be_played(run, capsys, tmp_path):
    old = tmp_path / "old"
    shutil.copytree(run, old)
    state = checkpoint.load(old / "checkpoint.pt")
    (learner,) = state["method"]["learners"]
    matches = learner["worker"]["upomdp"]["matches"]
    learner["worker"]["upomdp"]["matches"] = matches[[name for name in matches.dtype.names if name != "step"]].copy()
    checkpoint.save(old / "checkpoint.pt", state)
    episodes = ["--episodes", "4", "--grf-episodes", "4", "--engine", "regista"]
    assert main(["transfer", str(run), str(old), *episodes, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["runs"]
    assert [each | {"run": ""} for each in found[:2]] == [each | {"run": ""} for each in found[2:]]
    assert main(["train", "--resume", str(old), "--total-env-steps", "128"]) == 1
    assert "can be evaluated, but no longer resumed" in capsys.readouterr().err


def test_a_student_of_other_observations_is_refused_in_a_sentence(run, capsys, tmp_path):
    other = tmp_path / "other"
    shutil.copytree(run, other)
    config = (other / "config.json").read_text()
    (other / "config.json").write_text(config.replace('"simple115"', '"features"'))
    assert main(["transfer", str(other), "--engine", "regista"]) == 1
    assert "a student with observations other" in capsys.readouterr().err


def test_without_runs_or_without_the_engine_it_says_so(run, capsys, tmp_path):
    assert main(["transfer"]) == 2
    assert main(["transfer", str(run), "--episodes", "1", "--grf-python", str(tmp_path / "none")]) == 1
    assert "make grf" in capsys.readouterr().err
