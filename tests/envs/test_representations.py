"""The observations in the formats of Google Research Football, against its layout written out anew in NumPy."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from regista import minigames
from regista.envs.football.config import REPRESENTATIONS, FootballConfig
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.observation.raw import row
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.vector_env import FootballVectorEnv
from scenic_lite import load
from scenic_lite.scene.program import Program
from ued.core.sparse_image import SparseImage

MORE_CONTROLS = ("closest3", "active", "2", "all", "allNonGK")
CONTROLS = ("closest1", *(pytest.param(name, marks=pytest.mark.slow) for name in MORE_CONTROLS))


@cache
def program() -> Program:
    """Return the game that is seen in all ways; read once."""
    return load(minigames.MINIGAMES["3v2FourBehaviors"].program, FOOTBALL)


def make(representation: str, control: str = "closest1", right_control: str = "none", count: int = 3):
    settings = FootballConfig(representation=representation, control=control, right_control=right_control)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return FootballVectorEnv(program(), count, config=settings)


def side_by_side(representation: str, steps: int = 60, control: str = "closest1"):
    """Yield steps of the same matches seen in two ways: (raw dict, observation, whether it just began) of match 0."""
    raw, other = make("raw", control), make(representation, control)
    first, _ = raw.reset(seed=4)
    seen, _ = other.reset(seed=4)
    rng = np.random.default_rng(0)
    yield row(first, 0), seen[0], True
    for _ in range(steps):
        actions = rng.integers(0, 19, raw.action_space.shape)
        first, _, terminated, truncated, _ = raw.step(actions)
        seen, *_ = other.step(actions)
        yield row(first, 0), seen[0], bool(terminated[0] or truncated[0])


# ---------------------------------------------------------------- raw

TYPES = {
    "ball": (np.float64, (3,)),
    "ball_direction": (np.float64, (3,)),
    "ball_rotation": (np.float64, (3,)),
    "sticky_actions": (np.uint8, (10,)),
} | {
    f"{team}{field}": (kind, (count, *more))
    for team, count in (("left_team", 4), ("right_team", 2))
    for field, kind, more in (
        ("", np.float64, (2,)),
        ("_direction", np.float64, (2,)),
        ("_tired_factor", np.float64, ()),
        ("_yellow_card", np.bool_, ()),
        ("_active", np.bool_, ()),
        ("_roles", np.int64, ()),
    )
}
WHOLE = ("ball_owned_team", "ball_owned_player", "active", "designated", "steps_left", "game_mode")


def check_raw(observation):
    assert set(observation) == {*TYPES, *WHOLE, "score"}
    for name, (kind, shape) in TYPES.items():
        assert (observation[name].dtype, observation[name].shape) == (kind, shape), name
    assert all(type(observation[name]) is int for name in WHOLE)
    assert type(observation["score"]) is list and [type(goals) for goals in observation["score"]] == [int, int]


@pytest.mark.slow
def test_raw_has_the_keys_shapes_and_types_of_the_original():
    env = FootballEnv(program(), representation="raw")
    first, _ = env.reset(seed=0)
    check_raw(first)
    for _ in range(10):
        check_raw(env.step(5)[0])


@pytest.mark.slow
def test_raw_of_several_agents_is_a_dict_for_each():
    env = FootballEnv(program(), representation="raw", control="closest3")
    seen, _ = env.reset(seed=0)
    assert isinstance(seen, tuple) and len(seen) == 3
    for each in seen:
        check_raw(each)
    assert len({each["active"] for each in seen}) == 3
    assert env.step([5, 0, 13])[0][0]["sticky_actions"].sum() <= 1


@pytest.mark.slow
def test_raw_of_a_right_agent_is_turned():
    env = FootballEnv(program(), representation="raw", right_control="closest1")
    (left, right), _ = env.reset(seed=0)
    for _ in range(15):
        (left, right), *_ = env.step([5, 13])
        for name in ("ball", "ball_direction"):
            np.testing.assert_allclose(left[name] * (-1, -1, 1), right[name])
        for ours, theirs in (("left_team", "right_team"), ("right_team", "left_team")):
            for field in ("", "_direction"):
                np.testing.assert_allclose(left[ours + field], -right[theirs + field])
        assert left["ball_owned_player"] == right["ball_owned_player"]
        assert {left["ball_owned_team"], right["ball_owned_team"]} in ({-1}, {0, 1})
        assert left["score"] == right["score"][::-1]


@pytest.mark.slow
def test_sticky_actions_are_those_of_the_player_and_as_he_sees_them():
    env = FootballEnv(program(), representation="raw", control="all", right_control="2")
    env.reset(seed=0)
    for actions in ([4, 4, 4, 4, 4, 4], [13] * 6, [17] * 6):
        seen, *_ = env.step(actions)
    wanted = [0, 0, 0, 1, 0, 0, 0, 0, 1, 1]
    assert all(each["sticky_actions"].tolist() == wanted for each in seen)


# ---------------------------------------------------------------- simple115


def simple115(raw):
    """Return the original's vector, version 2."""
    parts = []
    for name in ("left_team", "left_team_direction", "right_team", "right_team_direction"):
        flat = raw[name].ravel().tolist()
        parts += flat + [-1.0] * (22 - len(flat))
    parts += [*raw["ball"], *raw["ball_direction"]]
    parts += np.eye(3)[raw["ball_owned_team"] + 1].tolist()
    parts += np.eye(11)[raw["active"]].tolist() + np.eye(7)[raw["game_mode"]].tolist()
    return np.array(parts, np.float32)


@pytest.mark.slow
def test_simple115_is_made_of_raw_as_in_the_original():
    for raw, seen, _ in side_by_side("simple115"):
        assert seen.dtype == np.float32 and seen.shape == (115,)
        np.testing.assert_allclose(seen, simple115(raw), atol=1e-6)


@pytest.mark.slow
def test_simple115_in_its_units_has_the_sizes_of_features():
    """What the student's floor is measured in: places by half a pitch, speeds by 8 m/s, the ball's by 20."""
    envs = [make(name, "active", count=1) for name in ("simple115", "features")]
    assert envs[1].observation_scale.tolist() == [1.0] * envs[1].observation_space.shape[1]
    for env in envs:
        env.reset(seed=4)
    for action in (4, 13, 0, 0, 0, 12, 0, 0, 0):
        seen, features = (env.step([action])[0][0] for env in envs)
        scaled = seen / envs[0].observation_scale
        me = np.flatnonzero(seen[97:108])[0]
        assert scaled[2 * me : 2 * me + 2] == pytest.approx(features[:2] * [1, -1], abs=1e-4)
        assert scaled[22 + 2 * me : 24 + 2 * me] == pytest.approx(features[2:4] * [1, -1], abs=1e-4)
        assert scaled[90:94] == pytest.approx(features[[10, 11, 12, 13]] * [1, 1, -1, 1], abs=1e-4)


# ---------------------------------------------------------------- smm


def planes(raw):
    """Return the original's mini map."""
    scope = np.zeros((72, 96, 4), np.uint8)
    me = raw["left_team"][raw["active"]]
    for channel, points in enumerate((raw["left_team"], raw["right_team"], [raw["ball"]], [me])):
        for x, y, *_ in points:
            column = int((x + 1.0) / 2.0 * 96)
            line = int((y + 1.0 / 2.25) / (2.0 / 2.25) * 72)
            scope[min(max(line, 0), 71), min(max(column, 0), 95), channel] = 255
    return scope


@pytest.mark.slow
def test_smm_is_made_of_raw_as_in_the_original():
    for raw, seen, _ in side_by_side("smm"):
        assert seen.dtype == np.uint8
        np.testing.assert_array_equal(seen, planes(raw))


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("representation", ["smm", "smm_stacked"])
@pytest.mark.parametrize(("control", "right_control"), [("closest1", "none"), ("closest3", "closest2")])
def test_sparse_smm_is_the_same_planes_as_coordinates(representation, control, right_control):
    """Also where marks share a pixel, and in episodes that begin anew."""
    settings = FootballConfig(representation, control=control, right_control=right_control)
    dense, sparse = (
        FootballVectorEnv(program(), 3, config=replace(settings, pixels=pixels)) for pixels in ("dense", "sparse")
    )
    space = sparse.agent_observation_space
    assert isinstance(space, SparseImage) and space.image == dense.agent_observation_space
    (seen, _), (other, _) = dense.reset(seed=4), sparse.reset(seed=4)
    rng, most = np.random.default_rng(0), 0
    for _ in range(80):
        assert sparse.observation_space.contains(other)
        np.testing.assert_array_equal(space.dense(other), seen)
        np.testing.assert_array_equal(space.sparse(seen), other)
        most = max(most, int((seen > 0).reshape(-1, seen[0].size).sum(1).max()))
        actions = rng.integers(0, 19, dense.action_space.shape)
        (seen, *_), (other, *_) = dense.step(actions), sparse.step(actions)
    assert most > 6
    np.testing.assert_array_equal(sparse.copy().observe(), other)


@pytest.mark.slow
def test_sparse_pixels_change_nothing_but_planes():
    env = FootballVectorEnv(program(), 2, config=FootballConfig("features", pixels="sparse"))
    assert env.observation_space == make("features", count=2).observation_space and env.plays_rollouts
    with pytest.raises(ValueError, match="pixels must be one of 'dense', 'sparse', not 'few'"):
        FootballConfig(pixels="few")


@pytest.mark.slow
def test_stacked_smm_has_the_last_four_frames_oldest_first():
    """Also across the start of an episode, where the first frame counts four times."""
    frames, starts = [], 0
    for raw, seen, began in side_by_side("smm_stacked", 120):
        frames = [planes(raw)] * 4 if began else [*frames[1:], planes(raw)]
        starts += began
        assert seen.shape == (72, 96, 16)
        np.testing.assert_array_equal(seen, np.concatenate(frames, axis=-1))
    assert starts > 1


@pytest.mark.slow
def test_the_last_observation_of_an_episode_is_of_that_episode():
    env = make("smm_stacked", count=8)
    seen, _ = env.reset(seed=0)
    rng = np.random.default_rng(3)
    for _ in range(80):
        before = seen
        seen, _, terminated, truncated, info = env.step(rng.integers(0, 19, 8))
        for index in np.flatnonzero(terminated | truncated):
            final = info["final_obs"][index]
            np.testing.assert_array_equal(final[..., :12], before[index][..., 4:])
            assert (seen[index][..., :4] == seen[index][..., 12:]).all()
    kept = before.copy()
    env.step(rng.integers(0, 19, 8))
    np.testing.assert_array_equal(kept, before)  # what was handed out stays as it is


# ---------------------------------------------------------------- contracts


@pytest.mark.slow
@pytest.mark.sample(5)
@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("control", CONTROLS)
def test_gymnasium_accepts_every_representation_and_control(representation, control):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        env = FootballEnv(program(), representation=representation, control=control, render_mode="rgb_array")
        check_env(env)


@pytest.mark.slow
@pytest.mark.sample(5)
@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("control", ["closest1", "closest3", "all"])
def test_the_batch_keeps_the_contract_of_vector_environments(representation, control):
    env = make(representation, control)
    seen, info = env.reset(seed=1)
    assert env.observation_space.contains(seen)
    for _ in range(40):
        seen, rewards, terminated, truncated, info = env.step(env.action_space.sample())
        assert env.observation_space.contains(seen)
        assert "final_obs" not in info or env.observation_space.contains(info["final_obs"])
        assert rewards.shape == terminated.shape == truncated.shape == (3,)


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_a_state_resumes_bit_for_bit_in_another_environment(representation):
    env, twin = make(representation, "closest2"), make(representation, "closest2")
    env.reset(seed=2)
    rng = np.random.default_rng(0)
    actions = rng.integers(0, 19, (60, 3, 2))
    for step in actions[:7]:
        env.step(step)
    state = env.get_state()
    assert equal(twin.set_state(state), env.observe())
    for step in actions[7:]:
        one, two = env.step(step), twin.step(step)
        assert all(equal(a, b) for a, b in zip(one[:4], two[:4], strict=True))


@pytest.mark.slow
def test_the_single_environment_gives_and_takes_states():
    env = FootballEnv(program(), representation="smm_stacked")
    env.reset(seed=3)
    for action in (5, 13, 5):
        env.step(action)
    state = env.get_state()
    course = [env.step(action)[:4] for action in (3, 12, 0, 0)]
    env.set_state(state)
    again = [env.step(action)[:4] for action in (3, 12, 0, 0)]
    assert all(equal(a, b) for one, two in zip(course, again, strict=True) for a, b in zip(one, two, strict=True))


@pytest.mark.slow
def test_a_state_of_other_matches_is_refused():
    env, other = make("features"), make("features", count=2)
    env.reset(seed=0)
    other.reset(seed=0)
    with pytest.raises(ValueError, match=r"'matches' must have shape \[3\], got shape \[2\]; program, number"):
        env.set_state(other.get_state())
    with pytest.raises(ValueError, match="'matches' must have shape"):
        env.set_state({})


def equal(a, b):
    if isinstance(a, dict):
        return all(equal(a[name], b[name]) for name in a)
    if isinstance(a, tuple):
        return all(equal(x, y) for x, y in zip(a, b, strict=True))
    return np.array_equal(a, b)


def test_checkpoints_pay_each_agent_for_itself():
    """Measured: in empty_goal_close the first step with the ball pays 0.9, and the rest comes at the goal."""
    text = (
        "param end_episode_on_score = True\nparam game_duration = 100\n"
        "ego = LeftCM at 75 @ 0\nLeftGK at -99 @ 0\nball = Ball at 76.5 @ 0\n"
    )
    env = FootballVectorEnv(text, 1, config=FootballConfig(rewards="scoring,checkpoints", control="2"))
    env.reset(seed=0)
    paid = []
    for _ in range(60):
        _, rewards, terminated, _, info = env.step(np.array([[5, 0]]))
        paid.append(info["agent_rewards"][0].tolist())
        assert rewards[0] == pytest.approx(np.mean(paid[-1]))
        if terminated[0]:
            break
    striker, keeper = np.array(paid).T
    assert striker[np.flatnonzero(striker)[0]] == pytest.approx(0.9)
    assert striker.sum() == pytest.approx(2.0)
    assert keeper[:-1].sum() == 0.0 and keeper[-1] == pytest.approx(2.0)
