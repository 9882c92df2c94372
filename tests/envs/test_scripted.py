"""Behaviors, monitors and endings of a program in its matches: who moves whom, what pays, what ends, what fails."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import warnings
from pathlib import Path

import numba
import numpy as np
import pytest

from regista.envs.football.batch import step_batch
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import BUILTIN_AI, DURATION, METRES_PER_X, REJECTED, TERMINATED
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.vector_env import FootballVectorEnv
from scenic_lite import ScenicError

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = """
from football.behaviors import *
param game_duration = 60
param end_episode_on_score = False
param end_episode_on_out_of_play = False
param end_episode_on_possession_change = False
"""
SCENE = """
ego = LeftCM at -50 @ 0
right = RightCM at 60 @ 30, with behavior {behavior}
ball = Ball at -50 @ 2
"""
IDLE = 0


def program(definitions: str = "", behavior: str = "IdleBehavior()", more: str = "") -> str:
    return SETTINGS + definitions + SCENE.format(behavior=behavior) + more


def started(text: str, count: int = 1, **config: object) -> FootballVectorEnv:
    env = FootballVectorEnv(text, count, config=FootballConfig(**config))
    env.reset(seed=0)
    return env


def steps(env: FootballVectorEnv, count: int, action: int = IDLE) -> list[tuple]:
    return [env.step(np.full(env.num_envs, action)) for _ in range(count)]


def actions_of(env: FootballVectorEnv, player: int, count: int) -> list[int]:
    """Return the actions that a player of match 0 takes."""
    found = []
    for _ in range(count):
        env.step(np.full(env.num_envs, IDLE))
        found.append(int(env.matches["players"]["action"][0, player]))
    return found


# ---------------------------------------------------------------- who moves whom


def test_a_behavior_moves_its_player_and_the_ai_the_rest() -> None:
    text = program(behavior="HoldPosition()", more="LeftGK at -99 @ 0\n")
    env = started(text)
    steps(env, 1)
    assert env.matches["players"]["action"][0, :3].tolist() == [BUILTIN_AI, IDLE, 15]


def test_a_behavior_that_ends_leaves_its_player_to_the_ai() -> None:
    assert actions_of(started(program(behavior="MoveToPosition(59 @ 30)")), 1, 3) == [14, BUILTIN_AI, BUILTIN_AI]


def test_a_player_who_waits_is_the_ais_for_that_step() -> None:
    waiting = "behavior Wait():\n    while True:\n        take Shoot()\n        wait\n"
    assert actions_of(started(program(waiting, "Wait()")), 1, 4) == [12, BUILTIN_AI, 12, BUILTIN_AI]


def test_directions_of_the_right_team_are_as_its_players_see_them() -> None:
    env = started(program(behavior="RunRight()"))
    before = env.matches["players"]["x"][0, 1]
    steps(env, 20)
    assert env.matches["players"]["x"][0, 1] < before - 5  # towards the left goal


KEYS = ("direction", "sprint", "dribble", "kick")


@pytest.mark.parametrize(
    ("actions", "keys"),
    [
        ("Sprint(), SetDirection(5)", (1, True, False, 0)),  # right for him is left on the pitch
        ("SetDirection(3), Dribble(), Shoot()", (7, False, True, 12)),
        ("SetDirection(3), SetDirection(5), Sprint(), ReleaseSprint()", (7, True, False, 0)),
        ("Pass('long'), Shoot(), NoAction()", (0, False, False, 9)),
        ("[NoAction(), SetDirection(1)]", (5, False, False, 0)),
        ("Sprint(), BuiltinAIAction()", (0, False, False, 0)),
    ],
)
def test_all_actions_of_a_take_count_that_can_hold_together(actions, keys) -> None:
    text = program(f"behavior Both():\n    while True:\n        take {actions}\n", "Both()")
    env = started(text.replace("Ball at -50 @ 2", "Ball at 59 @ 30"))  # who is far from it cannot ask for a kick
    steps(env, 1)
    player = env.matches["players"][0, 1]
    assert tuple(player[key].item() for key in KEYS) == keys


def test_a_direction_drawn_in_the_match_holds_together_with_others() -> None:
    several = "behavior Both():\n    while True:\n        take Uniform(3, 7), Sprint()\n"
    env = started(program(several, "Both()"), 8)
    steps(env, 1)
    assert set(env.matches["players"]["direction"][:, 1].tolist()) == {3, 7}
    assert env.matches["players"]["sprint"][:, 1].all()


def test_the_learner_moves_whom_it_controls_whatever_his_behavior_wants() -> None:
    text = SETTINGS + (
        "ego = LeftCM at -50 @ 0, with behavior HoldPosition()\n"
        "LeftCM at 0 @ 0, with behavior HoldPosition()\n"
        "RightGK at 99 @ 0\nball = Ball at -50 @ 3\n"
    )
    env = started(text)
    assert env.matches["agents"][0, 0] == 0
    steps(env, 1, action=7)
    assert env.matches["players"]["action"][0, :2].tolist() == [7, 15]


def test_behaviors_act_on_the_world_of_this_step() -> None:
    """It presses 12 for the first time in the step after the one in which the ball has passed the line."""
    look = "behavior Look():\n    while True:\n        take 12 if ball.x > -48 else 0\n"
    env = started(program(look, "Look()"))
    seen = -50.0
    for _ in range(40):
        env.step(np.array([5]))
        assert env.matches["players"]["action"][0, 1] == (12 if seen > -48 else 0)
        seen = env.matches["ball"]["x"][0] / METRES_PER_X
    assert seen > -48


# ---------------------------------------------------------------- rewards and endings

PAYING = """
monitor Pay:
    sim = simulation()
    while True:
        if sim.currentTime % 3 == 0:
            sim.scenic_reward = 0.25
        wait
"""


def test_a_monitor_pays_for_a_step_and_not_for_the_next() -> None:
    rewards = [float(step[1][0]) for step in steps(started(program(PAYING)), 9)]
    assert rewards == [0, 0, 0.25, 0, 0, 0.25, 0, 0, 0.25]  # a monitor sees what the step has led to


@pytest.mark.parametrize(
    ("more", "live"),
    [
        ("", False),
        ("terminate after 3 seconds\n", True),
        ("terminate when ego.x > 0\n", True),
        ("require always ego.y < 40\n", True),
        ("record ego.x as x\n", True),
        ("monitor M():\n    while True:\n        wait\nrequire monitor M()\n", True),
    ],
)
def test_a_program_in_which_nothing_happens_takes_no_time(more: str, live: bool) -> None:
    scene = "ego = LeftCM at -50 @ 0\nball = Ball at -50 @ 2\n"
    assert FootballVectorEnv(SETTINGS + scene + more).behaviors.is_live is live


def test_the_single_environment_pays_and_ends_the_same() -> None:
    env = FootballEnv(program(PAYING, more="terminate simulation when simulation().currentTime >= 6\n"))
    env.reset(seed=0)
    seen = [env.step(IDLE)[1:] for _ in range(6)]
    assert [reward for reward, *_ in seen] == [0, 0, 0.25, 0, 0, 0.25]
    assert [(terminated, truncated) for _, terminated, truncated, _ in seen] == [(False, False)] * 5 + [(True, False)]
    assert seen[-1][3] == {"ended": "terminated by the program"}


ENDINGS = [
    (
        "monitor End:\n    while simulation().currentTime != 4:\n        wait\n    terminate\n",
        "",
        4,
    ),
    ("", "terminate when simulation().currentTime > 3\n", 4),
    ("", "terminate simulation when simulation().currentTime == 4\n", 4),
    ("", "terminate after 0.4 seconds\n", 4),
    ("", "terminate after 4 steps\n", 4),
]


@pytest.mark.parametrize(("definitions", "more", "length"), ENDINGS)
def test_a_program_ends_its_episodes(definitions: str, more: str, length: int) -> None:
    env = started(program(definitions, more=more))
    for episode in range(3):
        seen = steps(env, length)
        assert [bool(step[2][0]) for step in seen] == [False] * (length - 1) + [True], episode
        assert not any(step[3][0] for step in seen)
        assert seen[-1][4]["ended"][0] == TERMINATED


def test_a_behavior_that_terminates_ends_the_episode_before_its_players_move() -> None:
    ending = "behavior Leave():\n    take NoAction()\n    take NoAction()\n    terminate\n"
    env = started(program(ending, "Leave()"))
    seen = steps(env, 3, action=5)
    assert [bool(step[2][0]) for step in seen] == [False, False, True]
    assert (seen[2][4]["final_obs"] == seen[1][0]).all()


def test_an_episode_that_breaks_a_requirement_is_truncated_and_says_so() -> None:
    text = program(behavior="RunRight()", more="require always right.x > 55\n")
    env, single = started(text), FootballEnv(text)
    single.reset(seed=0)
    for _ in range(40):
        _, _, terminated, truncated, info = env.step(np.array([IDLE]))
        last = single.step(IDLE)[1:]
        assert not terminated[0]
        if truncated[0]:
            break
        assert env.matches["players"]["x"][0, 1] > 55 * METRES_PER_X
    assert truncated[0] and info["ended"][0] == REJECTED
    assert last[1:] == (False, True, {"ended": "rejected by the program"})


def test_what_never_came_about_is_found_at_the_end() -> None:
    env = started(program(more="require eventually ball.x > 90\n"))
    seen = steps(env, 60)
    assert seen[-1][3][0] and seen[-1][4]["ended"][0] == REJECTED
    assert steps(started(program()), 60)[-1][4]["ended"][0] == DURATION


# ---------------------------------------------------------------- faults

FAILING = """
behavior Divide(x):
    for i in range(5):
        take NoAction()
    take 0 / (x * simulation().currentTime)
"""


def test_a_fault_says_where_and_in_which_match_and_step() -> None:
    env = FootballVectorEnv(program(FAILING, "Divide(Range(-1, 1))"), 3)
    env.reset(options={"theta": [[0.5], [0.0], [-0.5]]})
    text = program(FAILING, "Divide(2)")
    steps(env, 5)
    with pytest.raises(ScenicError) as error:
        env.step(np.zeros(3, int))
    lines = str(error.value).splitlines()
    line = text[: text.index("take 0 /")].count("\n") + 1
    assert lines[0].startswith(f"<program>:{line}:") and lines[0].endswith(": division by zero")
    assert lines[1] == "        take 0 / (x * simulation().currentTime)"
    assert lines[3].startswith("    in match 1 of 3, step 5; its level: ")


def test_the_other_matches_are_unharmed_by_a_fault() -> None:
    text = program(FAILING, "Divide(Range(-1, 1))")
    theta = np.array([[0.5], [0.0], [-0.5]])
    env, healthy = FootballVectorEnv(text, 3), FootballVectorEnv(text, 3)
    for each, rows in ((env, theta), (healthy, theta + np.array([[0], [0.3], [0]]))):
        each.reset(seed=4, options={"theta": rows})
        steps(each, 5)
    with pytest.raises(ScenicError):
        env.step(np.zeros(3, int))
    healthy.step(np.zeros(3, int))
    for _ in range(5):
        seen, expected = env.step(np.full(3, 5)), healthy.step(np.full(3, 5))
        for row in (0, 2):
            assert all((a[row] == b[row]).all() for a, b in zip(seen[:4], expected[:4], strict=True))
    assert env.matches["step"].tolist() == [11, 5, 11]  # it began anew


WRONG = """
behavior Wrong(first):
    take first
    while True:
        take Sprint(), {action}
"""


@pytest.mark.parametrize(
    ("action", "step", "words"),
    [
        ("simulation().currentTime + 18.5", 1, "there is no action 19.5; actions are 0 to 19"),
        ("simulation().currentTime + 17", 3, "there is no action 20; actions are 0 to 19"),
        ("2 - simulation().currentTime", 3, "there is no action -1; actions are 0 to 19"),
        ("Shoot", 1, "an action of football is a number, not a function (write its brackets, as in take Shoot())"),
        ("Shoot() if simulation().currentTime < 3 else None", 3, "an action of football is a number, not None"),
        ("self.owns_ball", 1, "an action of football is a number, not a truth value"),
    ],
)
def test_an_action_that_does_not_exist_is_told_at_its_take(action, step, words) -> None:
    text = program(WRONG.format(action=action), "Wrong(5)")
    env = started(text, 2)
    with pytest.raises(ScenicError) as error:
        steps(env, 9)
    line = text[: text.index("take Sprint")].count("\n") + 1
    first, *_, last = str(error.value).splitlines()
    assert first.startswith(f"<program>:{line}:") and words in first
    assert last.startswith(f"    in match 0 of 2, step {step};")


def test_a_loop_that_never_acts_is_a_fault() -> None:
    endless = "behavior Endless():\n    while True:\n        if ball.x > 1000:\n            take NoAction()\n"
    with pytest.raises(ScenicError, match="rounds of loops without an action"):
        steps(started(program(endless, "Endless()")), 1)


def test_the_ball_takes_no_actions() -> None:
    text = SETTINGS + "ego = LeftCM at 0 @ 0\nBall at 5 @ 5, with behavior RunRight()\n"
    with pytest.raises(ScenicError, match="only players take actions"):
        started(text).step(np.zeros(1, int))


# ---------------------------------------------------------------- the same numbers, the same kernels


def test_a_new_program_compiles_no_kernel() -> None:
    steps(started(program(PAYING)), 1)
    if not hasattr(step_batch, "signatures"):
        pytest.skip("kernels run uncompiled")
    before = len(step_batch.signatures)
    steps(started(program(FAILING, "Divide(3)", more=PAYING)), 1)
    steps(started(program()), 1)
    assert len(step_batch.signatures) == before == 1


DRAWING = """
behavior Wander():
    while True:
        for i in range(DiscreteRange(1, 4)):
            take SetDirection(DiscreteRange(1, 8))
        take Uniform(13, 15)
"""


def wandering(count: int) -> FootballVectorEnv:
    return started(program(DRAWING, "Wander()", "LeftGK with behavior Wander()\n" + PAYING), count)


def course(env: FootballVectorEnv, count: int = 80) -> list[np.ndarray]:
    seen = [step[:4] for step in steps(env, count, action=5)]
    return [np.stack([step[i] for step in seen]) for i in range(4)]


def equal(first: list[np.ndarray], second: list[np.ndarray]) -> bool:
    return all((a == b).all() for a, b in zip(first, second, strict=True))


@pytest.mark.slow
def test_runs_repeat_themselves_and_threads_change_nothing() -> None:
    courses = [course(wandering(16)) for _ in range(2)]
    assert equal(*courses)
    if numba.config.NUMBA_NUM_THREADS > 1:
        threads = numba.get_num_threads()
        try:
            numba.set_num_threads(1)
            assert equal(courses[0], course(wandering(16)))
        finally:
            numba.set_num_threads(threads)


@pytest.mark.slow
def test_a_batch_of_one_is_a_row_of_a_batch() -> None:
    many = wandering(4)
    ones = [wandering(1) for _ in range(4)]
    for row, one in enumerate(ones):
        one.reset_to_levels(many.levels[row : row + 1])
    whole = course(many)
    for row, one in enumerate(ones):
        assert equal([part[:, row : row + 1] for part in whole], course(one))


def test_a_copy_goes_on_in_the_middle_of_its_behaviors() -> None:
    env = wandering(6)
    course(env, 33)
    twin = env.copy()
    assert equal(course(env), course(twin))


def test_each_episode_of_a_deterministic_match_is_the_same() -> None:
    text = program(DRAWING, "Wander()") + "param deterministic = True\nparam game_duration = 20\n"
    seen = [step[0] for step in steps(started(text), 60)]
    for t in range(20):
        assert (seen[t] == seen[t + 20]).all() and (seen[t] == seen[t + 40]).all()


def test_a_line_that_would_fail_is_warned_of_when_the_environment_is_made() -> None:
    text = program("behavior Late():\n    do HoldPosition() for 50 steps\n    take Shot()\n", "Late()")
    with pytest.warns(UserWarning, match=r"comes to this line stops: .*:9:10: name 'Shot' is not defined"):
        env = FootballVectorEnv(text, 2)
    env.reset(seed=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env.copy()


@pytest.mark.parametrize(
    "line, warning",
    [
        ("RunRight()", r':8:5: the behavior "RunRight" is named here, but not run \(write do RunRight'),
        ("take Pass('medium')", r":8:10: key 'medium' is not in the dictionary"),
    ],
)
def test_slips_of_behaviors_are_warned_of(line: str, warning: str) -> None:
    with pytest.warns(UserWarning) as found:
        FootballVectorEnv(program(f"behavior Slip():\n    {line}\n    take Shoot()\n", "Slip()"), 1)
    assert len(found) == 1
    assert re.search(warning, str(found[0].message))


def test_a_misspelt_reward_is_refused_with_the_right_name() -> None:
    text = program("behavior Slip():\n    simulation().scenic_rewards = 1\n    take Shoot()\n", "Slip()")
    with pytest.raises(ScenicError, match=r":8:5: .* 'scenic_rewards' .*\(did you mean 'scenic_reward'"):
        FootballVectorEnv(text, 1)


UNCOMPILED = """
import sys
import numpy as np
from regista.envs.football.vector_env import FootballVectorEnv
env = FootballVectorEnv(sys.argv[1], 2)
env.reset(seed=5)
seen = [np.column_stack([*env.step(np.full(2, 5))[:2]]) for _ in range(40)]
np.save(sys.argv[2], np.stack(seen))
"""


@pytest.mark.slow
def test_compiled_and_uncompiled_agree(tmp_path: Path) -> None:
    file = tmp_path / "wander.scenic"
    file.write_text(program(DRAWING, "Wander()", "LeftGK with behavior Wander()\n" + PAYING))
    results = []
    for disable in "01":
        saved = tmp_path / f"{disable}.npy"
        command = [sys.executable, "-c", UNCOMPILED, str(file), str(saved)]
        subprocess.run(command, check=True, cwd=ROOT, env={**os.environ, "NUMBA_DISABLE_JIT": disable})
        results.append(np.load(saved))
    np.testing.assert_allclose(results[0], results[1], atol=1e-6)
