"""The vector environment on another engine: a stand-in shows what is ours, which behaviors command, what is resumed."""

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import DURATION, GK, SHOT
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.limits import StateError
from regista.envs.football.replay import Recorder, load_record, replay, same
from regista.envs.football.scenic.lineup import NotAMatchError
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.grf.observed_match import follow_kicks
from regista.experiments.__main__ import main
from tests.envs.grf.fixtures import fake_python
from ued.core.level_space import check_theta

PROGRAM = """
param game_duration = 9
LeftGK at -98 @ 0
ego = LeftCM at Range(20, 40) @ 5
RightGK at 98 @ 0
RightCB at 60 @ Range(-5, 5)
Ball ahead of ego by 2
"""
CHASER = """
behavior Run():
    while True:
        take SetDirection(1)

"""


@pytest.fixture(name="python")
def _python(tmp_path):
    return str(fake_python(tmp_path))


def make(python: str, program: str = PROGRAM, count: int = 2, **settings: object) -> FootballVectorEnv:
    config = FootballConfig(**{"control": "all", "engine": "grf", "grf_python": python, "grf_workers": 1} | settings)
    return FootballVectorEnv(program, count, config=config)


def keys(env: FootballVectorEnv, seed: int, steps: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.integers(0, 19, env.action_space.shape) for _ in range(steps)]


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("representation", ["features", "simple115", "smm", "smm_stacked"])
def test_observations_are_those_of_our_own_simulator(python, representation):
    real, ours = (
        make(python, representation=representation),
        make(python, representation=representation, engine="regista"),
    )
    assert real.observation_space == ours.observation_space and real.action_space == ours.action_space
    theta = [[0.5, -0.5], [-1.0, 0.25]]
    seen, expected = (env.reset(seed=1, options={"theta": theta})[0] for env in (real, ours))
    np.testing.assert_allclose(seen.astype(float), expected.astype(float), atol=2e-5)
    for actions in keys(real, 0, 4):
        seen = real.step(actions)[0]
        assert real.observation_space.contains(seen)


@pytest.mark.slow
def test_places_teams_and_roles_are_those_of_the_program(python):
    real, ours = make(python), make(python, engine="regista")
    theta = real.sample_theta(2)
    for env in (real, ours):
        env.reset(options={"theta": theta})
    for name in ("x", "y", "team", "role", "shirt", "order", "agent"):
        np.testing.assert_allclose(real.matches["players"][name], ours.matches["players"][name], atol=1e-9)
    for name in ("x", "y", "z"):
        np.testing.assert_allclose(real.matches["ball"][name], ours.matches["ball"][name], atol=1e-9)


@pytest.mark.slow
def test_an_episode_has_as_many_steps_as_the_program_says(python):
    env = make(python)
    env.reset(seed=0)
    for step, actions in enumerate(keys(env, 0, 9), start=1):
        _, _, terminated, truncated, info = env.step(actions)
        assert not terminated.any() and (truncated == (step == 9)).all()
    assert (info["ended"] == DURATION).all() and (env.matches["step"] == 0).all()
    assert not np.array_equal(info["final_obs"], env.observe())


@pytest.mark.slow
def test_a_copy_and_a_resumed_state_play_on_bit_for_bit(python):
    env = make(python)
    env.reset(seed=0)
    for actions in keys(env, 0, 5):
        env.step(actions)
    state = env.get_state()
    twin, resumed = env.copy(), make(python)
    resumed.set_state(state)
    for actions in keys(env, 1, 12):  # over the end of an episode
        results = [each.step(actions) for each in (env, twin, resumed)]
        for other in results[1:]:
            for ours, theirs in zip(results[0][:4], other[:4], strict=True):
                np.testing.assert_array_equal(ours, theirs)
        assert same(env.matches, twin.matches) and same(env.matches, resumed.matches)


@pytest.mark.slow
def test_episodes_of_a_level_differ_but_for_the_same_seed(python):
    env = make(python)
    ends = []
    for seed in (3, 3, 4):
        env.reset(seed=seed, options={"theta": [[0.0, 0.0]] * 2})
        for actions in keys(env, 0, 5):
            env.step(actions)
        ends.append(env.matches["players"]["x"].copy())
    np.testing.assert_array_equal(ends[0], ends[1])
    assert (ends[0][0] != ends[0][1]).any() and (ends[0] != ends[2]).any()


@pytest.mark.slow
def test_a_state_of_the_simulator_is_refused(python):
    ours, real = make(python, engine="regista"), make(python)
    ours.reset(seed=0)
    real.reset(seed=1)
    before = real.matches
    with pytest.raises(StateError, match="saved by our simulator, not by"):
        real.set_state(ours.get_state())
    assert same(real.matches, before)


@pytest.mark.slow
@pytest.mark.sample(5)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"grf_matches": np.array([0, 2])}, "grf_matches of a state must be different numbers below 2"),
        ({"grf_matches": np.array([0, 0])}, "grf_matches of a state must be different numbers below 2"),
        ({"grf_matches": np.array([0, -1])}, r"grf_matches of a state must be \[2\] integers from 0"),
        ({"grf_seeds": None}, r"grf_seeds of a state must be \[2\] integers from 0, got None"),
        ({"grf_lengths": np.array([3, 2])}, "grf_lengths of a state give 5 steps, and grf_actions has 6"),
        ({"grf_actions": np.zeros((6, 3), int)}, r"grf_actions of a state must be \[6, 22\] integers"),
        ({"grf_actions": np.full((6, 22), -1)}, r"grf_actions of a state must be \[6, 22\] integers from 0"),
    ],
)
def test_episodes_that_do_not_fit_are_refused(python, change, message):
    env = make(python)
    env.reset(seed=0)
    for actions in keys(env, 0, 3):
        env.step(actions)
    state = env.get_state()
    with pytest.raises(StateError, match=message):
        env.set_state(state | change)
    env.set_state(state)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("control", "behavior", "agents"),
    [
        ("active", "", [1, 0]),
        ("closest1", "", [2, 0]),
        ("all", "", [2, 0]),
        ("active", ", with behavior Run()", [1, 2]),
    ],
)
def test_the_engine_is_asked_for_the_agents_that_are_needed(python, control, behavior, agents):
    env = make(python, CHASER + PROGRAM.replace("Range(-5, 5)", f"0{behavior}"), control=control)
    env.reset(seed=0)
    assert env._engine._controllers.tolist() == [agents] * 2


@pytest.mark.parametrize(("only", "agents"), [(False, [2, 0]), (True, [1, 0])])
def test_an_only_agent_stays_one_where_behaviors_move_nobody_else(python, only, agents):
    program = PROGRAM.replace("20, 40) @ 5", "20, 40) @ 5, with behavior Run()") + f"param agents_only = {only}\n"
    env = make(python, CHASER + program, control="active")
    env.reset(seed=0)
    assert env._engine._controllers.tolist() == [agents] * 2


def test_behaviors_command_the_players_of_their_team_as_they_see_the_pitch(python):
    env = make(python, CHASER + PROGRAM.replace("Range(-5, 5)", "0, with behavior Run()"), control="active")
    env.reset(seed=0)
    before = env.matches["players"]["x"].copy()
    for _ in range(5):
        env.step(np.zeros(2, int))
    moved = env.matches["players"]["x"] - before
    assert (moved[:, 3] > 2.0).all() and (abs(moved[:, [0, 1, 2]]) < 1.0).all()  # his left is towards +x


def test_monitors_pay_and_end_matches(python):
    monitor = """
monitor Clock():
    while True:
        simulation().scenic_reward = 0.5
        wait

terminate when simulation().currentTime >= 4
require monitor Clock()
"""
    env = make(python, PROGRAM + monitor)
    env.reset(seed=0)
    rewards, ended = zip(*[env.step(actions)[1::3] for actions in keys(env, 0, 5)], strict=True)
    assert (rewards[0] == 0.5).all()
    assert any(np.asarray(each).any() for each in ended)


def test_the_program_alone_plays_the_agents_players(python):
    env = make(python, CHASER + PROGRAM.replace("at Range(20, 40) @ 5", "at Range(20, 40) @ 5, with behavior Run()"))
    env.reset(seed=0)
    twin = env.with_scripted_policy()
    before = twin.matches["players"]["x"].copy()
    for _ in range(5):
        twin.step(np.full(twin.action_space.shape, 5))
    assert (twin.matches["players"]["x"][:, 1] - before[:, 1] < -2.0).all()


def test_a_team_without_a_keeper_has_one_whom_nobody_sees(python):
    env = make(python, "ego = LeftCM at 70 @ 0\nRightCB at 80 @ 9\nBall at 72 @ 0", control="1")
    env.reset(seed=0)
    env.step(np.array([5, 5]))
    match = env.matches[0]
    assert match["num_players"] == 2 and (match["players"]["role"][:2] != GK).all()
    assert match["agents"][0] == 0 and match["reported_owner"] == 0
    assert match["players"]["direction"][0] == 5


def test_eleven_players_without_a_keeper_are_refused(python):
    people = "\n".join(f"LeftCM at {5 * number} @ 0" for number in range(11))
    with pytest.raises(NotAMatchError, match="11 players and no keeper"):
        make(python, f"ego = RightGK at 98 @ 0\n{people}\nBall at 70 @ 0")


def test_theta_sets_the_scene_of_a_single_match(python):
    env = FootballEnv(PROGRAM, "raw", control="active", engine="grf", grf_python=python)
    seen, info = env.reset(seed=0, options={"theta": [1.0, -1.0]})
    check_theta(info["theta"], 2)
    np.testing.assert_allclose(seen["left_team"][1], [0.4, -0.05], atol=1e-9)
    np.testing.assert_allclose(seen["right_team"][1], [0.6, 0.05], atol=1e-9)
    seen = env.step(5)[0]
    assert (seen["steps_left"], seen["designated"]) == (8, 1)  # the stand-in designates the last player
    env.close()


@pytest.mark.slow
def test_a_record_is_replayed_by_the_engine_of_this_machine(python, tmp_path, monkeypatch):
    env = make(python)
    env.reset(seed=0)
    recorder = Recorder(env)
    for actions in keys(env, 0, 12):
        recorder.step(actions)
    recorder.save(tmp_path / "match.npz")
    assert load_record(tmp_path / "match.npz").config.engine == "grf"
    assert load_record(tmp_path / "match.npz").config.grf_python is None  # a file does not say what is run
    monkeypatch.setenv("REGISTA_GRF_PYTHON", python)
    assert len(list(replay(tmp_path / "match.npz"))) == 13


@pytest.mark.slow
def test_the_command_line_plays_on_the_other_engine(python, tmp_path, capsys):
    (tmp_path / "scene.scenic").write_text(PROGRAM)
    words = ["play", str(tmp_path / "scene.scenic"), "--engine", "grf", "--grf-python", python, "--grf-workers", "1"]
    assert main(words) == 0
    assert "9 steps, 0 : 0, then duration" in capsys.readouterr().out
    assert main([*words[:5], "/nowhere"]) == 1
    assert "make grf" in capsys.readouterr().err


def test_closing_gives_the_engines_up(python):
    env = make(python)
    env.reset(seed=0)
    held = env._engine._workers.processes[0].held
    assert len(held) == 2
    env.close()
    assert not held


def test_a_kick_asked_for_is_remembered_until_the_ball_flies(python):
    env = make(python, count=1)
    env.reset(seed=0)
    owner = int(env.matches["designated"][0, 0])
    me = int(env.matches["players"]["agent"][0, owner])
    press = np.zeros(env.action_space.shape, np.int64)
    env.step(press)
    press[0, me] = SHOT
    env.step(press)
    assert env.matches["players"]["kick"][0, owner] == SHOT
    env.step(np.zeros_like(press))  # the button is released: what was asked for still is
    match = env.matches[0]
    assert match["players"]["kick"][owner] == SHOT and match["players"]["kick_ready"][owner]
    match["ball"]["x"], match["ball"]["y"] = match["players"]["x"][owner] + 3.0, match["players"]["y"][owner]
    match["ball"]["vx"] = 25.0
    follow_kicks(match)
    assert match["players"]["kick"][owner] == 0


def test_processes_end_with_the_last_environment_that_has_them(python):
    env = make(python)
    env.reset(seed=0)
    workers = env._engine._workers
    process = workers.processes[0].process
    twin, smaller = env.copy(), env.resized(1)
    env.close()
    env.close()
    twin.close()
    assert process.poll() is None  # one of them may still play
    smaller.reset(seed=0)
    del smaller  # nobody has closed it
    assert process.poll() is not None and workers.processes[0].process is None


def test_an_environment_that_cannot_be_made_leaves_no_process(python):
    env = make(python)
    env.reset(seed=0)
    process = env._engine._workers.processes[0].process
    with pytest.raises(ValueError):
        env.resized(-1)
    with pytest.raises(ValueError):
        env.set_state({})
    env.close()
    assert process.poll() is not None


DRAWN = """param game_duration = DiscreteRange(5, 9), second_half = DiscreteRange(3, 4)
param deterministic = Uniform(True, False)
param left_team_difficulty = Range(0.2, 0.4), right_team_difficulty = Range(0, 1), offsides = Uniform(False, True)
"""


@pytest.mark.slow
def test_random_settings_are_those_of_the_own_match(python):
    env = make(python, DRAWN + PROGRAM.replace("param game_duration = 9\n", ""))
    theta = np.zeros((2, env.theta_dim))
    theta[0], theta[1] = -1, 1
    env.reset(options={"theta": theta})
    first, second = (env._engine._scene(start, 0)["settings"] for start in env._batch.starts)
    shared = {"use_magnet": True, "end_episode_on_score": False, "end_episode_on_out_of_play": False}
    shared |= {"end_episode_on_possession_change": False}
    low = {"game_duration": 4, "second_half": 3, "deterministic": True, "offsides": False}
    high = {"game_duration": 8, "second_half": 4, "deterministic": False, "offsides": True}
    assert first == shared | low | {"left_team_difficulty": 0.2, "right_team_difficulty": 0.0}
    assert second == shared | high | {"left_team_difficulty": 0.4, "right_team_difficulty": 1.0}
    ends = []
    for actions in keys(env, 0, 9):
        ends.append(env.step(actions)[3].tolist())
    assert [row[0] for row in ends].index(True) == 4 and [row[1] for row in ends].index(True) == 8


def test_a_random_setting_that_decides_who_has_an_agent_is_refused(python):
    with pytest.raises(NotAMatchError, match="agents_only must be fixed for Google Research Football"):
        make(python, "param agents_only = Uniform(True, False)\n" + PROGRAM)


def test_factors_of_our_simulator_are_warned_of(python):
    with pytest.warns(UserWarning) as warned:
        make(python, "param keeper_speed = Range(0.9, 1.1), sticky_noise = 0.1, engine_spread = 0.1\n" + PROGRAM)
    assert [str(one.message).split(" of ")[0] for one in warned] == ["param engine_spread", "param keeper_speed"]
