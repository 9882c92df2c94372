"""FootballVectorEnv and FootballEnv: contracts, levels, determinism, what is refused."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import gymnasium
import numba
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regista import minigames
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import METRES_PER_X, METRES_PER_Y, SHOT
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.observation.features import features_names
from regista.envs.football.vector_env import FootballVectorEnv
from regista.envs.football.version import SIMULATOR_VERSION
from scenic_lite import ScenicError
from ued.core.level_space import ThetaError

ROOT = Path(__file__).parent.parent.parent
FREE = minigames.MINIGAMES["1v1Free"].program
RESTRICTED = minigames.MINIGAMES["1v1Restricted"].program


def rollout(env, steps=120, seed=7):
    """Return observations, rewards and ends of random play, each stacked over steps."""
    actions = np.random.default_rng(seed).integers(0, 19, (steps, env.num_envs))
    seen = [env.step(row) for row in actions]
    return [np.stack([step[i] for step in seen]) for i in range(4)]


# ---------------------------------------------------------------- contracts


@pytest.mark.slow
@pytest.mark.parametrize("name", minigames.MINIGAMES)
@pytest.mark.parametrize("representation", ["features", "raw"])
def test_the_single_environment_passes_gymnasiums_check(name, representation):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # about wide boxes and unwrapped environments
        check_env(gymnasium.make(f"regista/{name}-v1", representation=representation).unwrapped, skip_render_check=True)


def test_ids_end_in_the_version_and_old_ones_name_it():
    ours = [spec for name, spec in gymnasium.registry.items() if name.startswith("regista/") and spec.name != "Maze"]
    assert len(ours) == len(minigames.suites.NAMED) and {spec.version for spec in ours} == {SIMULATOR_VERSION}
    present = f"Please use `regista/1v1Free-v{SIMULATOR_VERSION}` instead"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Gymnasium's, who says it twice
        with pytest.raises(gymnasium.error.DeprecatedEnv, match=present):
            gymnasium.make("regista/1v1Free-v0")


def test_the_single_environment_passes_stable_baselines_check():
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make("regista/1v1Free-v1").unwrapped, warn=False)


@pytest.mark.slow
def test_a_stock_trainer_learns_on_it_unchanged():
    sb3 = pytest.importorskip("stable_baselines3")
    model = sb3.PPO("MlpPolicy", gymnasium.make("regista/1v1Restricted-v1"), n_steps=256, seed=0, device="cpu")
    before = [parameter.detach().clone() for parameter in model.policy.parameters()]
    model.learn(1024)
    assert any((a != b).any() for a, b in zip(before, model.policy.parameters(), strict=True))


def test_make_vec_gives_the_native_batch_with_a_new_level_every_episode():
    env = gymnasium.make_vec("regista/1v1Restricted-v1", num_envs=16)
    assert isinstance(env, FootballVectorEnv)
    env.reset(seed=0)
    before = env.levels.copy()
    ended = np.zeros(16, bool)
    for _ in range(400):
        _, _, terminated, truncated, _ = env.step(np.full(16, SHOT))
        ended |= terminated | truncated
        if ended.any():
            break
    assert (env.levels["theta"][ended] != before["theta"][ended]).any(axis=1).all()
    assert (env.levels[~ended] == before[~ended]).all()


def test_a_match_can_be_drawn():
    env = gymnasium.make("regista/1v1Free-v1", render_mode="rgb_array")
    env.reset(seed=0)
    before = env.render()
    for _ in range(10):
        env.step(5)
    assert before.dtype == np.uint8 and before.ndim == 3 and before.std() > 5
    assert (env.render() != before).any()


def test_the_last_picture_of_an_episode_shows_its_end():
    """Not the start of the next one, which begins when it is reset."""
    env = FootballEnv(FREE, render_mode="rgb_array")
    env.reset(seed=0)
    start, over = env.render(), False
    while not over:
        *_, terminated, truncated, _ = env.step(SHOT)
        over = terminated or truncated
    end = env.render()
    assert (end != start).any() and env.batch.matches["ended"][0] > 0
    assert env.batch.matches["step"][0] > 0
    env.reset_agent()
    assert (env.render() != end).any()


# ---------------------------------------------------------------- levels


def test_theta_puts_the_players_where_the_program_says():
    env = FootballVectorEnv(FREE, 2)
    env.reset(options={"theta": [[0, 0, 1, -1, 0, 0], [-1, 1, 0.5, 0.5, 0, 0]]})
    values = env.describe(env.levels["theta"])
    match = env.matches[0]
    left_keeper, striker, keeper = match["players"][:3]
    assert (striker["x"], striker["y"]) == pytest.approx((40 * METRES_PER_X, 0))
    assert (keeper["x"], keeper["y"]) == pytest.approx((80 * METRES_PER_X, -25 * METRES_PER_Y))
    assert (left_keeper["x"], left_keeper["y"]) == pytest.approx((-98.75 * METRES_PER_X, 0))
    assert (match["ball"]["x"], match["ball"]["y"]) == pytest.approx((40 * METRES_PER_X, 2.1 * METRES_PER_Y))
    assert list(values[1].values()) == pytest.approx([0, 25, 60, 12.5, -98.75, 0])


def test_an_overlapping_level_is_invalid_and_replaced():
    env = FootballVectorEnv(FREE, 2)
    theta = np.array([[0.5, 0.5, 0.5, 0.5, 0, 0], [0.5, 0.5, -0.5, 0.5, 0, 0]])
    assert env.valid(theta).tolist() == [False, True]
    env.reset(seed=0)
    _, info = env.step_adversary(theta)
    assert info["replaced"].tolist() == [True, False]
    assert env.valid(env.levels["theta"]).all()


NARROW = """
last = Range(50, 99)
behavior RunTo(x):
    while self.position.x < x:
        take SetDirection(5)
ego = LeftCM at Range(40, 44) @ 0
RightCB at Range(40, 44) @ 0, with behavior RunTo(last)
ball = Ball ahead of ego by Range(2, 3)
"""


@pytest.mark.slow
def test_starts_made_ahead_in_a_block_are_those_made_one_by_one():
    """Two players may stand in each other; one of two environments prefetches the levels."""
    ahead, alone = (FootballVectorEnv(NARROW, 4) for _ in range(2))
    rng, made = np.random.default_rng(0), []
    levels = ahead.make_levels(rng.uniform(-1, 1, (60, ahead.theta_dim)))
    invalid = ~alone.valid(levels["theta"])
    assert 5 < invalid.sum() < 55
    levels["seed"] = np.arange(60)
    starts_of = ahead.lineup.starts_of
    ahead.lineup.starts_of = lambda scenes, rows, seeds: made.append(len(rows)) or starts_of(scenes, rows, seeds)
    for env in (ahead, alone):
        env.reset(seed=0)
    made.clear()
    for first in range(0, 60, 2):
        ahead.prefetch(levels[first + 2 :])
        where = np.arange(4) < 2
        seen, known = zip(
            *(env.reset_to_levels(levels[first : first + 2], where) for env in (ahead, alone)), strict=True
        )
        assert (seen[0] == seen[1]).all()
        assert known[0]["replaced"].tolist() == known[1]["replaced"].tolist() == invalid[first : first + 2].tolist()
        states = [env.get_state() for env in (ahead, alone)]
        assert all((states[0][name] == states[1][name]).all() for name in ("matches", "start_registers"))
    assert made[0] == np.count_nonzero(~invalid)


def test_the_next_episode_on_a_level_has_the_same_start_and_another_course():
    env = FootballVectorEnv(minigames.MINIGAMES["1v1Restricted"].tests[0][1], 1)
    first, _ = env.reset(seed=1)
    lengths, count = [], 0
    while len(lengths) < 6:
        observations, _, terminated, truncated, _ = env.step(np.array([SHOT]))
        count += 1
        if terminated[0] or truncated[0]:
            assert (observations == first).all()
            lengths.append(count)
            count = 0
    assert env.levels["theta"].shape == (1, 0)


def test_deterministic_programs_repeat_themselves():
    text = RESTRICTED.read_text().replace("deterministic = False", "deterministic = True")
    env = FootballVectorEnv(text, 1)
    env.reset(seed=0)
    courses, course = [], []
    while len(courses) < 3:
        _, _, terminated, truncated, info = env.step(np.array([SHOT]))
        course.append(info["final_obs"][0].tolist() if terminated[0] or truncated[0] else 0)
        if terminated[0] or truncated[0]:
            courses.append(course)
            course = []
    assert courses[0] == courses[1] == courses[2]


def test_features_have_a_name_each_and_stay_within_the_space():
    env = FootballVectorEnv(minigames.MINIGAMES["ChoosePassing"].program, 8)
    observations, _ = env.reset(seed=0)
    assert observations.shape == (8, len(features_names(env.num_players))) == (8, *env.single_observation_space.shape)
    seen, _, _, _ = rollout(env)
    assert np.isfinite(seen).all()
    low, high = env.single_observation_space.low[0], env.single_observation_space.high[0]
    assert seen.min() >= low and seen.max() <= high


def test_raw_agrees_with_the_record():
    env = FootballVectorEnv(FREE, 3, config=FootballConfig(representation="raw"))
    observations, _ = env.reset(seed=2)
    matches = env.matches
    assert observations["ball"][:, 0] == pytest.approx(matches["ball"]["x"] / 54.4)
    assert observations["ball"][:, 1] == pytest.approx(-matches["ball"]["y"] / 83.6)
    assert observations["left_team"].shape == (3, 2, 2) and observations["right_team"].shape == (3, 1, 2)
    assert observations["steps_left"].tolist() == [400] * 3
    assert (observations["ball_owned_team"] == -1).all()
    for _ in range(60):
        observations, _, terminated, truncated, info = env.step(np.full(3, SHOT))
        ended = terminated | truncated
        if ended.any():
            assert (info["final_obs"]["steps_left"][ended] < 399).all()
            assert (observations["steps_left"][ended] == 400).all()
            break


# ---------------------------------------------------------------- the same numbers


def test_the_same_seed_gives_the_same_numbers_and_another_seed_others():
    def play(seed):
        env = FootballVectorEnv(RESTRICTED, 8)
        env.reset(seed=seed)
        return rollout(env)

    one, two, other = play(3), play(3), play(4)
    assert all((a == b).all() for a, b in zip(one, two, strict=True))
    assert (one[0] != other[0]).any()


def test_one_thread_and_two_give_the_same_numbers():
    def play(threads):
        numba.set_num_threads(threads)
        env = FootballVectorEnv(RESTRICTED, 64)
        env.reset(seed=0)
        return rollout(env)

    available = numba.config.NUMBA_NUM_THREADS
    if available < 2:
        pytest.skip("one thread only")
    try:
        assert all((a == b).all() for a, b in zip(play(1), play(2), strict=True))
    finally:
        numba.set_num_threads(available)


@pytest.mark.slow
def test_a_batch_of_one_is_a_row_of_a_batch():
    many = FootballVectorEnv(RESTRICTED, 5)
    many.reset(seed=11)
    actions = np.random.default_rng(0).integers(0, 19, (150, 5))
    for row in range(5):
        twin = FootballVectorEnv(RESTRICTED, 5)
        one = FootballVectorEnv(RESTRICTED, 1)
        twin.reset(seed=11)
        one.reset(seed=0)
        one.reset_to_levels(twin.levels[row : row + 1])
        for step in actions:
            a, b = twin.step(step), one.step(step[row : row + 1])
            assert all((x[row] == y[0]).all() for x, y in zip(a[:4], b[:4], strict=True))


def test_a_copy_resumes_bit_for_bit():
    env = FootballVectorEnv(RESTRICTED, 6)
    env.reset(seed=1)
    rollout(env, 17)
    twin = env.copy()
    assert all((a == b).all() for a, b in zip(rollout(env), rollout(twin), strict=True))
    assert env.np_random.integers(2**60) == twin.np_random.integers(2**60)


UNCOMPILED = """
import sys
import numpy as np
from regista.envs.football.vector_env import FootballVectorEnv
env = FootballVectorEnv(sys.argv[1], 3)
env.reset(seed=5)
actions = np.random.default_rng(0).integers(0, 19, (40, 3))
np.save(sys.argv[2], np.stack([np.column_stack([*env.step(row)[:2]]) for row in actions]))
"""


@pytest.mark.slow
def test_compiled_and_uncompiled_agree(tmp_path):
    """The simulator is its own reference: to 1e-6 in observations that are float32, over 40 steps."""
    results = []
    for disable in "01":
        file = tmp_path / f"{disable}.npy"
        command = [sys.executable, "-c", UNCOMPILED, str(RESTRICTED), str(file)]
        subprocess.run(command, check=True, cwd=ROOT, env={**os.environ, "NUMBA_DISABLE_JIT": disable})
        results.append(np.load(file))
    np.testing.assert_allclose(results[0], results[1], atol=1e-6)


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("theta", "message"),
    [
        ([0.0] * 5, "theta must have shape [1, 6], got [1, 5]"),
        ([0.0] * 5 + [float("nan")], "theta[0, 5] is nan; every entry must be a number in [-1, 1]"),
        ([0.0, -1.01, 0, 0, 0, 0], "theta[0, 1] is -1.01; every entry must be a number in [-1, 1]"),
        ("easy", "theta must be an array of numbers of shape [N, 6], got ['easy']"),
    ],
)
def test_a_theta_that_is_none_is_refused(theta, message):
    env = FootballEnv(FREE)
    with pytest.raises(ThetaError) as error:
        env.reset(options={"theta": theta})
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        ([1, 2, 3], "actions must be 2 whole numbers, got shape (3,) of int64"),
        ([0.5, 1.0], "actions must be 2 whole numbers, got shape (2,) of float64"),
        ([19, 0], "action 19 does not exist; actions are 0 to 18"),
        ([0, -1], "action -1 does not exist; actions are 0 to 18"),
    ],
)
def test_actions_that_are_none_are_refused(actions, message):
    env = FootballVectorEnv(FREE, 2)
    env.reset(seed=0)
    with pytest.raises(ValueError) as error:
        env.step(np.array(actions))
    assert str(error.value) == message


def test_a_broken_program_points_at_the_line():
    with pytest.raises(ScenicError) as error:
        FootballVectorEnv("ego = LeftCM at 0 @\n")
    assert error.value.line == 1


def test_a_step_before_the_first_reset_is_refused():
    with pytest.raises(RuntimeError, match="call reset"):
        FootballVectorEnv(FREE).step(np.zeros(1, int))


def test_matches_that_were_never_reset_are_not_played():
    never = FootballVectorEnv(FREE, 2)
    for env in (never, never.copy()):
        with pytest.raises(RuntimeError, match=r"^call reset\(\) before step\(\)$"):
            env.step(np.zeros(2, int))
        with pytest.raises(RuntimeError, match=r"^call reset\(\) before starting another episode$"):
            env.reset_agent()
    never.reset(seed=0, options={"reset_mask": np.array([True, False])})
    with pytest.raises(RuntimeError, match="1 of 2 environments were never reset"):
        never.step(np.zeros(2, int))
    never.idle[1] = True
    never.step(np.zeros(2, int))


@pytest.mark.parametrize("action", [2.9, np.float32(3), True, [1]])
def test_the_single_environment_takes_whole_numbers_only(action):
    env = FootballEnv(FREE)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="actions must be 1 whole numbers"):
        env.step(action)


def test_the_single_environment_refuses_other_options():
    env = FootballEnv(FREE)
    with pytest.raises(ValueError, match="reset has no option 'Theta'; its options are 'theta' and 'reset_mask'"):
        env.reset(options={"Theta": np.zeros(env.theta_space.shape)})


@pytest.mark.parametrize(
    ("config", "message"),
    [
        (
            {"representation": "pixels"},
            "representation must be one of 'features', 'simple115', 'smm', 'smm_stacked', 'raw', not 'pixels'",
        ),
        ({"rewards": "goals"}, "rewards must be one of 'scoring', 'scoring,checkpoints', not 'goals'"),
    ],
)
def test_unknown_settings_are_refused(config, message):
    with pytest.raises(ValueError) as error:
        FootballConfig(**config)
    assert str(error.value) == message


@pytest.mark.slow
@pytest.mark.parametrize("make", [lambda text: FootballVectorEnv(text, 2), FootballEnv], ids=["vector", "one"])
def test_slips_that_loading_finds_are_warned_of_once_each(make):
    text = "param game_durration = 30\nego = LeftCM at 0 @ 0, with behaviour HoldPosition()\nLeftGK\nRightGK\n"
    text += "behavior Slip():\n    HoldPosition()\n    take Shoot()\n"
    text += "RightCB at 30 @ 0, with behavior Slip\nball = Ball ahead of ego by 1\n"
    with pytest.warns(UserWarning) as found:
        make(text)
    heads = [str(each.message).split(" (")[0] for each in found]
    assert heads == [
        "<program>:1:7: nothing reads the parameter 'game_durration'",
        "<program>:2:24: LeftCM has no property 'behaviour'",
        "<program>:8:20: the behavior Slip is written without brackets",
        '<program>:6:5: the behavior "HoldPosition" is named here, but not run',
    ]
    assert {each.category for each in found} == {UserWarning}
