"""The families `academy` and `matches`: policies by name, episodes that must end one way, and what is counted."""

import numpy as np
import pytest

from regista.envs.football.constants import DIRECTION_RIGHT, SHOT, SPRINT
from regista.experiments.grf import academy, matches
from regista.experiments.grf.policies import policy_named
from regista.experiments.grf.report import read_data
from regista.experiments.grf.scenes import ACADEMY, SCENES, stage_scene
from regista.experiments.grf.stage import Trace


def test_every_policy_and_scene_of_the_table_exists():
    for target in read_data("academy"):
        assert target["scene"] in SCENES
        if target["policy"] != "builtin_ai":
            policy_named(target["policy"])


def test_an_unknown_policy_is_named():
    with pytest.raises(ValueError, match="'sprint_left'"):
        policy_named("sprint_left")


def test_a_policy_sprints_right_and_then_shoots():
    stage = stage_scene("empty_goal_close", ACADEMY, 2)
    policy = policy_named("sprint_right_shot_0.85")
    policy.begin(2, 0)
    keys = []
    for step in range(18):
        now = policy(stage.matches, step)
        keys.append(int(now[0]))
        actions = np.full((2, stage.num_players), -1)
        actions[:, 1] = now
        stage.step(actions)
    assert keys[:3] == [DIRECTION_RIGHT, SPRINT, DIRECTION_RIGHT] and keys[-1] == SHOT


def test_sprinting_into_an_empty_goal_scores_and_standing_still_does_not():
    found = academy.play_policy("empty_goal_close", "sprint_right_only", 0.05)
    assert found.scored.all() and academy.ends(found) == {"score": len(found.scored)}
    assert not academy.play_policy("pass_and_shoot_with_keeper", "idle", 0.05).scored.any()


def test_passes_turnovers_and_restarts_are_counted():
    steps = 40
    owner = np.full((steps, 1), -1)
    owner[5:10], owner[15:20], owner[30:35] = 3, 4, 14
    ball = np.zeros((steps, 1, 3))
    ball[12:, 0, 0] = 20.0
    mode = np.zeros((steps, 1), int)
    mode[36:39] = 5
    blank = np.zeros((steps, 1, 22, 2))
    trace = Trace(ball, ball, blank, blank, owner, mode, np.zeros((steps, 1, 2)), np.zeros((steps, 1)))
    found = matches.events(trace)
    assert found["passes left"] == 1 and found["turnovers won right"] == 1
    assert found["pass length median"] == pytest.approx(20.0)
    assert matches.restarts(trace)["throw-ins"] == 1
    assert matches.possession(trace)["possession left"] == pytest.approx(10 / 15)


@pytest.mark.slow
def test_whole_matches_give_every_quantity_and_players_run_as_far_as_measured():
    rows = matches.measure(0.1)
    assert {row.name.split(": ")[1] for row in rows} == {row["quantity"] for row in read_data("matches")}
    ways = [row for row in rows if "run by an outfield player" in row.name]
    assert len(ways) == 2 and all(row.ok for row in ways), ways
