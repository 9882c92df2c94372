"""PPO on probe environments whose answers are known."""

import dataclasses

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Text
from probes import Choice, Constant, Endless, Follow, Reach, TwoStep

from ued.config import PPOConfig
from ued.core.seeding import torch_generator
from ued.learning.networks import Categorical, Gaussian
from ued.learning.ppo import explained_variance
from ued.learning.student import Normaliser, Student
from ued.methods.dr import DR

QUICK = PPOConfig(num_steps=16, learning_rate=3e-3, num_minibatches=4, hidden_size=32, gamma=0.9, ent_coef=0.0)


def train(env, updates=40, config=QUICK):
    method = DR(env, config, seed=1)
    for _ in range(updates):
        metrics = method.update()
    return method.student, metrics


def value(student, *observation):
    return float(student.value(torch.tensor([observation], dtype=torch.float32)))


def probability(student, *observation):
    with torch.no_grad():
        policy, _ = student(torch.tensor([observation], dtype=torch.float32))
    return float(policy.log_probs.exp()[0, 1])


@pytest.mark.slow
def test_a_constant_reward_is_the_value():
    student, metrics = train(Constant())
    assert value(student, 0.0) == pytest.approx(1.0, abs=0.02)
    assert metrics["return/student"] == 1.0


@pytest.mark.slow
def test_reward_is_credited_to_the_step_before():
    student, _ = train(TwoStep(), updates=60)
    assert value(student, 1.0) == pytest.approx(1.0, abs=0.03)
    assert value(student, 0.0) == pytest.approx(0.9, abs=0.03)


@pytest.mark.slow
def test_the_better_action_is_taken():
    student, metrics = train(Choice())
    assert probability(student, 0.0) > 0.97
    assert metrics["return/student"] > 0.9


@pytest.mark.slow
def test_the_action_follows_the_observation():
    student, _ = train(Follow())
    assert probability(student, 1.0) > 0.95
    assert probability(student, -1.0) < 0.05


@pytest.mark.slow
def test_continuous_actions_reach_their_target():
    student, metrics = train(Reach(), updates=25, config=dataclasses.replace(QUICK, learning_rate=1e-2))
    actions = student.play(np.zeros((1, 1)), torch_generator(0), greedy=True)
    assert actions[0] == pytest.approx([7, 2], abs=0.5)
    assert metrics["return/student"] > -2.5  # 5 at the start


@pytest.mark.slow
def test_a_time_limit_is_no_ending():
    student, _ = train(Endless(), updates=25, config=dataclasses.replace(QUICK, gamma=0.8))
    assert value(student, 0.0) == pytest.approx(5.0, abs=0.25)  # as a termination it would be worth about 2.3


@pytest.mark.long
def test_the_value_can_be_clipped_torsos_shared_and_updates_stopped():
    config = dataclasses.replace(QUICK, clip_vloss=True, shared_torso=True, target_kl=0.02)
    student, _ = train(Follow(), config=config)
    assert probability(student, 1.0) > 0.9


@pytest.mark.slow
def test_the_learning_rate_falls_to_nothing():
    env = Constant(8)
    method = DR(env, dataclasses.replace(QUICK, anneal_env_steps=16 * 8 * 4))
    rates = [method.update()["student/learning_rate"] for _ in range(5)]
    assert rates == pytest.approx([3e-3 * share for share in (0.75, 0.5, 0.25, 0.0, 0.0)])


def test_the_same_seed_gives_the_same_numbers_whatever_the_global_streams():
    torch.manual_seed(1)
    np.random.seed(1)
    one = [DR(Follow(), QUICK, seed=7).update() for _ in range(2)]
    torch.manual_seed(2)
    two = DR(Follow(), QUICK, seed=7).update()
    other = DR(Follow(), QUICK, seed=8).update()
    for metrics in (*one, two, other):
        for name in [name for name in metrics if name.startswith("time/")]:
            del metrics[name]
    assert one[0] == one[1] == two != other


def test_all_metrics_are_plain_numbers():
    metrics = DR(Follow(), QUICK).update()
    assert all(type(number) is float for number in metrics.values())
    assert metrics["env_steps"] == 16 * 16 and metrics["updates"] == 1


def test_numbers_that_are_none_stop_the_training():
    env = Choice()
    env.outcome = lambda actions: (np.full(16, np.nan), env.everyone, ~env.everyone)
    with pytest.raises(FloatingPointError, match=r"the gradient is not finite \(loss nan\): check for rewards"):
        DR(env, QUICK).update()


def test_the_thesis_settings():
    config = PPOConfig.thesis()
    table = (config.learning_rate, config.gamma, config.gae_lambda, config.clip_coef, config.ent_coef, config.vf_coef)
    assert table == (8e-5, 0.993, 0.95, 0.27, 0.01, 0.5)
    assert (config.num_steps, config.num_minibatches, config.update_epochs) == (128, 8, 4)
    assert (config.max_grad_norm, config.adam_eps) == (0.5, 1e-5)


def test_categorical_agrees_with_torch():
    logits = torch.randn(200, 5, generator=torch_generator(0))
    ours, theirs = Categorical(logits), torch.distributions.Categorical(logits=logits)
    action = ours.sample(torch_generator(1))
    torch.testing.assert_close(ours.log_prob(action), theirs.log_prob(action))
    torch.testing.assert_close(ours.entropy(), theirs.entropy())
    many = Categorical(logits[:1].expand(200_000, 5)).sample(torch_generator(2))
    share = torch.bincount(many, minlength=5) / len(many)
    torch.testing.assert_close(share, theirs.probs[0], atol=0.005, rtol=0)


def test_gaussian_agrees_with_torch():
    mean, log_std = torch.randn(50, 3, generator=torch_generator(0)), torch.tensor([-1.0, 0.0, 0.5])
    ours = Gaussian(mean, log_std)
    theirs = torch.distributions.Independent(torch.distributions.Normal(mean, log_std.exp()), 1)
    action = ours.sample(torch_generator(1))
    torch.testing.assert_close(ours.log_prob(action), theirs.log_prob(action))
    torch.testing.assert_close(ours.entropy(), theirs.entropy())


@pytest.mark.parametrize("kind", [torch.float32, torch.uint8])
def test_running_statistics_are_exact_far_from_zero(kind):
    data = (100 + 3 * torch.randn(4000, 3, generator=torch_generator(0))).to(kind)
    data = data + 1e5 * torch.tensor([0.0, 1.0, -1.0]) if kind == torch.float32 else data
    normaliser = Normaliser(torch.zeros(3))
    for rows in (data[:1500], data[1500:]):
        normaliser.track(rows)
    torch.testing.assert_close(normaliser.mean.double(), data.double().mean(0), rtol=1e-6, atol=1e-6)
    torch.testing.assert_close(normaliser.variance.double(), data.double().var(0, correction=0), rtol=1e-5, atol=1e-5)


def test_running_statistics_are_those_of_everything_seen():
    data = torch.randn(1000, 4, generator=torch_generator(0)) * torch.tensor([1.0, 10.0, 0.1, 0.0]) + 3
    normaliser = Normaliser(torch.zeros(4))
    for rows in (data[:1], data[1:300], data[300:]):
        normaliser.track(rows)
    torch.testing.assert_close(normaliser.mean, data.mean(0))
    torch.testing.assert_close(normaliser.variance, data.var(0, correction=0), atol=1e-5, rtol=1e-4)
    assert normaliser(data).abs().max() <= 10


def test_a_feature_that_hardly_moved_cannot_blow_up_by_moving_a_little():
    """Its standard deviation is a hundredth of its unit: 0.2 of the unit would be 20 of them, and is 2 floors."""
    data = torch.tensor([[1.0], [0.01]]).T * torch.randn(2000, 2, generator=torch_generator(0))
    student = Student(Box(-6, 6, (2,)), Discrete(3), PPOConfig(), torch_generator(0), np.ones(2))
    student.normaliser.track(data)
    moved = student.normaliser(torch.tensor([[0.2, 0.2]]))[0]
    assert moved[1] == pytest.approx(2.0, abs=0.02) and moved[0] == pytest.approx(0.2, abs=0.1)
    bare = Normaliser(torch.zeros(2))
    bare.track(data)
    assert bare(torch.tensor([[0.2, 0.2]]))[0, 1] == 10


def test_the_floor_is_in_the_features_units_and_travels_with_the_student():
    config = PPOConfig(obs_std_floor=0.2)
    student = Student(Box(-1, 1, (2,)), Discrete(3), config, torch_generator(0), np.array([1.0, 0.05]))
    torch.testing.assert_close(student.normaliser.floor, torch.tensor([0.2, 0.01]))
    other = Student(Box(-1, 1, (2,)), Discrete(3), PPOConfig(), torch_generator(1))
    other.load_state_dict(student.state_dict())
    torch.testing.assert_close(other.normaliser.floor, torch.tensor([0.2, 0.01]))


def test_explained_variance():
    target = torch.arange(10.0)
    assert explained_variance(target, target) == 1.0
    assert explained_variance(torch.zeros(10), target) == 0.0
    assert np.isnan(explained_variance(target, torch.ones(10)))


def test_images_are_seen_by_convolutions():
    """Of the sizes of the thesis (Fig. 4.10): 32 planes of 5 x 8 before the last layer; where a pixel is, matters."""
    space = Box(0, 255, (72, 96, 16), np.uint8)
    student = Student(space, Discrete(19), PPOConfig(hidden_size=32, shared_torso=True), torch_generator(0))
    flat = [layer.in_features for layer in student.actor_torso if hasattr(layer, "in_features")]
    assert flat == [1280]
    images = torch.zeros(3, 72, 96, 16, dtype=torch.uint8)
    images[1, 10, 10, 3], images[2, 60, 80, 3] = 255, 255
    policy, value = student(images)
    assert policy.log_probs.shape == (3, 19) and len(torch.unique(value)) == 3


@pytest.mark.parametrize(
    "space",
    [
        Box(0, 255, (20, 30, 3), np.uint8),
        Box(0, 255, (3, 64, 64), np.uint8),
        Box(0.0, 1.0, (4, 40, 40), np.float32),
        Box(-np.inf, np.inf, (48, 48, 2), np.float32),
        Box(0, 10, (3, 3, 2), np.uint8),
    ],
    ids=str,
)
def test_images_small_and_large_bytes_and_floats_channels_first_and_last(space):
    student = Student(space, Discrete(3), PPOConfig(hidden_size=16), torch_generator(0))
    dark = torch.as_tensor(np.zeros((2, *space.shape), space.dtype))
    bright = dark.clone()
    bright[1] = 1
    assert (student(dark)[1][0] == student(dark)[1][1]).all()
    value = student(bright)[1]
    assert value.shape == (2,) and value[0] != value[1]


@pytest.mark.parametrize(
    ("space", "shape"),
    [(MultiDiscrete([3, 2], start=[1, 5]), (2,)), (MultiBinary((2, 2)), (4,)), (Box(-2.0, 4.0, (2, 3)), (6,))],
    ids=str,
)
def test_actions_of_several_entries_have_the_shape_of_their_space(space, shape):
    student = Student(Box(0, 1, (5,)), space, PPOConfig(), torch_generator(0))
    seen = np.zeros((400, 5), np.float32)
    sent = student.play(seen, torch_generator(1))
    assert sent.shape == (400, *space.shape) and all(space.contains(row) for row in sent)
    policy, _ = student(torch.zeros(400, 5))
    action = policy.sample(torch_generator(2))
    assert action.shape == (400, *shape) and policy.log_prob(action).shape == (400,)
    if isinstance(space, MultiDiscrete):
        assert np.unique(sent[:, 0]).tolist() == [1, 2, 3] and np.unique(sent[:, 1]).tolist() == [5, 6]
        assert policy.entropy()[0].item() == pytest.approx(np.log(6), abs=0.01)
        assert policy.kl(policy).abs().max() < 1e-6


@pytest.mark.parametrize(
    ("observations", "actions", "message"),
    [
        (
            Discrete(3),
            Discrete(2),
            "observations must be a Box, got Discrete(3); wrap the environment with "
            "gymnasium.wrappers.FlattenObservation",
        ),
        (
            Box(0, 1, (3, 4)),
            Discrete(2),
            "observations must be flat vectors, got shape (3, 4); wrap the environment with "
            "gymnasium.wrappers.FlattenObservation",
        ),
        (
            Box(0, 1, (3,)),
            Text(4),
            f"actions must be Discrete, MultiDiscrete, MultiBinary or a Box, got {Text(4)}",
        ),
        (Dict({}), Discrete(2), None),
    ],
)
def test_spaces_that_do_not_fit_are_refused(observations, actions, message):
    with pytest.raises(ValueError) as error:
        Student(observations, actions, PPOConfig(), torch_generator(0))
    assert message is None or str(error.value) == message


@pytest.mark.parametrize(
    ("setting", "number", "message"),
    [
        ("num_steps", 0, "num_steps must be at least 1, got 0"),
        ("learning_rate", 0.0, "learning_rate must be positive, got 0.0"),
        ("learning_rate", float("nan"), "learning_rate must be positive, got nan"),
        ("gamma", 1.5, "gamma must be between 0 and 1, got 1.5"),
        ("ent_coef", -0.1, "ent_coef must not be negative, got -0.1"),
    ],
)
def test_settings_out_of_range_are_refused(setting, number, message):
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(PPOConfig(), **{setting: number})


def test_discrete_actions_count_from_where_the_space_starts():
    student = Student(Box(-1, 1, (2,)), Discrete(3, start=5), PPOConfig(), torch_generator(0))
    actions = student.play(np.zeros((100, 2)), torch_generator(1))
    assert set(actions) == {5, 6, 7}


def test_continuous_actions_keep_to_their_bounds():
    space = Box(np.array([0.0, -np.inf], np.float32), np.array([10.0, np.inf], np.float32))
    student = Student(Box(-1, 1, (2,)), space, PPOConfig(), torch_generator(0))
    actions = student.play(np.zeros((500, 2)), torch_generator(1))
    assert actions.dtype == np.float32 and actions[:, 0].min() == 0 and actions[:, 0].max() == 10
    assert actions[:, 0].mean() == pytest.approx(5, abs=0.7) and actions[:, 1].std() == pytest.approx(1, abs=0.1)
