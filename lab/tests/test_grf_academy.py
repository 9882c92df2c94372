"""The family `academy`: drawing scenes, policies by name, and counts of their episodes."""

import json

import numpy as np
import pytest

from lab.benchmarks.__main__ import main
from lab.grf import academy
from lab.grf.academy import BUILT_IN, DRAWN, JITTER, ROWS
from lab.grf.drawn_scenes import program_text
from lab.grf.policies import policy_named
from lab.grf.report import read_data
from lab.grf.scenes import SCENES, stage_scene
from regista.envs.football.constants import DIRECTION_RIGHT, SHOT, SPRINT
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.vector_env import FootballVectorEnv

PASSING = "pass_and_shoot_with_keeper"


def starts(scene, count=DRAWN):
    """Return players' positions [N, P, 2] and balls [N, 2] at the start of drawn levels, in m, and the levels."""
    env = FootballVectorEnv(program_text(SCENES[scene], JITTER), count, config=academy.OURS)
    levels = academy.drawn_levels(env, count)
    env.reset_to_levels(levels)
    matches, there = env.matches, env.num_players
    places = np.stack([matches["players"][axis][:, :there] for axis in "xy"], -1)
    return places, np.stack([matches["ball"][axis] for axis in "xy"], -1), levels


@pytest.mark.parametrize("scene", sorted({scene for scene, _ in ROWS}))
def test_every_player_is_displaced_by_himself_and_the_ball_goes_with_its_carrier(scene):
    places, balls, _ = starts(scene)
    fixed = stage_scene(scene, MatchConfig(control="active"), 1).matches[0]
    middle = np.stack([fixed["players"][axis][: places.shape[1]] for axis in "xy"], -1)
    off = places - middle
    assert np.abs(off).max() <= JITTER + 1e-2 and (np.abs(off).max(0) > 0.9 * JITTER).all()
    each = np.corrcoef(off.reshape(len(off), -1).T) - np.eye(off[0].size)
    assert np.abs(each).max() < 0.35  # 200 independent draws have a standard error of 0.07
    ball = np.array([fixed["ball"][axis] for axis in "xy"])
    left = middle[: len(SCENES[scene].left)]
    carrier = np.linalg.norm(left - ball, axis=1).argmin()
    np.testing.assert_allclose(balls - places[:, carrier], np.tile(ball - left[carrier], (len(balls), 1)), atol=1e-2)


def test_a_scene_drawn_again_has_other_luck():
    _, _, levels = starts(PASSING, 2 * DRAWN)
    assert (levels["theta"][:DRAWN] == levels["theta"][DRAWN:]).all()
    assert len(np.unique(levels["theta"], axis=0)) == DRAWN and len(np.unique(levels["seed"])) == 2 * DRAWN


def test_a_program_without_jitter_draws_nothing():
    assert "Range" not in program_text(SCENES[PASSING])
    assert FootballVectorEnv(program_text(SCENES[PASSING]), 1, config=academy.OURS).theta_dim == 0


def test_the_table_has_the_rows_that_are_measured():
    assert tuple((target["scene"], target["policy"]) for target in read_data("academy")) == ROWS
    for scene, policy in ROWS:
        assert scene in SCENES
        assert policy == BUILT_IN or policy_named(policy)


def test_an_unknown_policy_is_named():
    with pytest.raises(ValueError, match="'sprint_left'"):
        policy_named("sprint_left")


def test_a_policy_sprints_right_and_then_shoots():
    stage = stage_scene("empty_goal_close", MatchConfig(control="active"), 2)
    policy = policy_named("sprint_right_shot_0.85")
    policy.begin(2)
    keys = []
    for step in range(18):
        now = policy(stage.matches, step)
        keys.append(int(now[0]))
        actions = np.full((2, stage.num_players), -1)
        actions[:, 1] = now
        stage.step(actions)
    assert keys[:3] == [DIRECTION_RIGHT, SPRINT, DIRECTION_RIGHT] and keys[-1] == SHOT


@pytest.mark.parametrize("policy", ["sprint_right_shot_0.85", BUILT_IN])
def test_an_empty_goal_from_near_is_scored_and_counted(policy):
    found = academy.numbers(academy.play_policy("empty_goal_close", policy, 20))
    ended = {what: found[what] for what in ("goals", "conceded", "out_of_play", "possession", "time")}
    assert found["episodes"] == 20 and ended == {
        "goals": 20,
        "conceded": 0,
        "out_of_play": 0,
        "possession": 0,
        "time": 0,
    }


@pytest.mark.slow
def test_the_command_plays_both_engines(engine, capsys, monkeypatch):
    monkeypatch.setattr(academy, "ROWS", ROWS[:1])
    words = ["--suite", "grf", "--measure", "--family", "academy", "--effort", "0.02", *engine]
    assert main([*words, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["results"]["academy"]
    assert (row["scene"], row["policy"]) == ROWS[0] and row["episodes"] == 4 and row["ours_episodes"] == 8
    assert set(read_data("academy")[0]) <= set(row)
