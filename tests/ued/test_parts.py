"""Observations that mix images and other parts: the images reach convolutions, right pixels in the right places."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Dict, Discrete, MultiBinary, MultiDiscrete, Sequence, Text, Tuple, flatten
from probes import Probe

import ued
from ued import GymUPOMDP, PPOConfig, load_policy
from ued.adapters.observations import as_array
from ued.adapters.policy import spaces_of
from ued.core import checkpoint
from ued.core.parts import Parts, has_images, image_shape
from ued.core.seeding import torch_generator
from ued.learning.student import Student
from ued.methods.dr import DR
from ued.methods.paired import Paired
from ued.methods.plr import PLR

BYTES = Box(0, 255, (5, 6, 3), np.uint8)
MINIGRID = Dict(image=Box(0, 255, (7, 7, 3), np.uint8), direction=Discrete(4))
SPACES = {
    "dict": Dict(image=BYTES, direction=Discrete(4)),
    "tuple": Tuple((BYTES, Box(-2, 3, (2,), np.float32))),
    "nested": Dict(eyes=Dict(left=BYTES, body=Tuple((MultiDiscrete([3, 2]), MultiBinary(3)))), at=Discrete(3, start=5)),
    "two images": Dict(a=BYTES, b=Discrete(2), c=Box(0, 255, (3, 8, 9), np.uint8)),
    "an image and nothing else": Dict(image=BYTES),
    "large and small": Dict(large=Box(0, 255, (40, 48, 1), np.uint8), small=BYTES),
    "floats": Dict(image=Box(-1, 1, (6, 5, 2), np.float32), direction=Box(-np.inf, np.inf, (), np.float32)),
    "grey": Dict(image=Box(0, 255, (9, 8), np.uint8), flags=Box(0, 1, (2, 3, 2), np.float32)),
}
SMALL = PPOConfig(hidden_size=8)
TINY = PPOConfig(num_steps=8, num_minibatches=2, update_epochs=1, hidden_size=8)
GRU = PPOConfig(num_steps=8, num_minibatches=2, update_epochs=1, hidden_size=8, memory="gru")


class Random(gymnasium.Env):
    """Random observations of a space; keeps those that it gave."""

    def __init__(self, space=MINIGRID):
        self.observation_space, self.action_space = copy.deepcopy(space), Discrete(3)  # with its own random stream
        self.given = []

    def look(self):
        self.given.append(self.observation_space.sample())
        return self.given[-1]

    def reset(self, *, seed=None, options=None):
        self.observation_space.seed(seed)
        self.t = 0
        return self.look(), {}

    def step(self, action):
        self.t += 1
        return self.look(), float(action), self.t == 5, False, {}


def upomdp(space=MINIGRID, num_envs=4, **settings):
    return GymUPOMDP(lambda: Random(space), None, ued.Seeds(50), num_envs=num_envs, **settings)


def student(space, config=SMALL, seed=0, **settings):
    return Student(space, Discrete(3), config, torch_generator(seed), **settings)


def of_convolutions(made, observations):
    """Return the images `[B, channels, height, width]` that the actor's first convolutions get."""
    found, hooks = [], []
    firsts = [next(m for m in read if isinstance(m, torch.nn.Conv2d)) for read in made.actor_torso[0].read]
    for layer in firsts:
        hooks.append(layer.register_forward_hook(lambda module, given, _: found.append(given[0])))
    made(torch.as_tensor(observations))
    for hook in hooks:
        hook.remove()
    return found


@pytest.mark.parametrize("space", SPACES.values(), ids=SPACES)
def test_a_vector_is_what_gymnasium_writes_one_by_one_and_in_batches(space):
    parts, drawn = Parts(space), []
    space.seed(0)
    for _ in range(5):
        drawn.append(space.sample())
        flat = parts.flatten(drawn[-1])
        np.testing.assert_array_equal(flat, flatten(space, drawn[-1]).astype(parts.dtype))
        assert parts.contains(flat) and not parts.is_batch(drawn[-1])
    batch = gymnasium.vector.utils.concatenate(space, drawn, gymnasium.vector.utils.create_empty_array(space, 5))
    assert parts.is_batch(batch)
    np.testing.assert_array_equal(parts.flatten_batch(batch), [parts.flatten(one) for one in drawn])
    for twin in (copy.deepcopy(parts), pickle.loads(pickle.dumps(parts))):
        assert twin == parts and twin.space == parts.space and twin.parts == parts.parts


def test_bytes_stay_bytes():
    assert [Parts(space).dtype == np.uint8 for space in SPACES.values()] == [True, False, True, True, True, True] + [
        False
    ] * 2
    made = upomdp()
    assert DR(made, TINY, seed=0).learners[0].rollout.observation.dtype == torch.uint8


def test_images_are_at_least_5_high_and_wide():
    assert image_shape(Box(0, 255, (4, 7, 3), np.uint8)) is None and image_shape(Box(0, 1, (5, 5, 5, 5))) is None
    assert image_shape(Box(0, 255, (7, 9), np.uint8)) == (7, 9, 1) and image_shape(Box(0, 1, (7, 9))) is None
    assert not has_images(Dict(image=Box(0, 255, (4, 4, 3), np.uint8))) and not has_images(BYTES)
    plain = upomdp(Dict(image=Box(0, 255, (4, 4, 3), np.uint8), direction=Discrete(2))).single_observation_space
    assert not isinstance(plain, Parts) and plain.shape == (50,)


@pytest.mark.slow
@pytest.mark.parametrize("vectorization", ["sync", "async"])
@pytest.mark.parametrize("name", ["dict", "tuple", "nested", "two images"])
def test_convolutions_get_the_pixels_of_the_environment(name, vectorization):
    """The image of environment 2, scaled to [0, 1], channels first; `given` is what the environment returned."""
    made = upomdp(SPACES[name], 3, vectorization=vectorization)
    seen, _ = made.reset(seed=4)
    twin = Random(SPACES[name])
    twin.reset(seed=int(made.levels["seed"][2]))
    seen = made.advance(np.array([1, 1, 1]))[0]
    twin.step(1)
    given = copy.deepcopy(twin.given[-1])
    made.close()
    images = {
        "dict": lambda: [given["image"]],
        "tuple": lambda: [given[0]],
        "nested": lambda: [given["eyes"]["left"]],
        "two images": lambda: [given["a"], given["c"].transpose(1, 2, 0)],
    }[name]()
    convolved = of_convolutions(student(made.single_observation_space), seen)
    assert len(convolved) == len(images)
    for got, image in zip(convolved, images, strict=True):
        assert image.max() > 200
        np.testing.assert_allclose(got[2], image.transpose(2, 0, 1) / np.float32(255), rtol=1e-6)


def test_other_parts_reach_the_layers_behind_the_convolutions():
    space = Parts(SPACES["nested"])
    made, drawn = student(space), SPACES["nested"].sample()
    flat = torch.as_tensor(space.flatten(drawn))[None]
    features = made.actor_torso[0](made.normaliser(flat)).detach()
    assert made.actor_torso[0].size == features.shape[1] == 16 * 3 * 4 + 3 + 5 + 3
    at, others = (
        flatten(Discrete(3, start=5), drawn["at"]),
        flatten(SPACES["nested"]["eyes"]["body"], drawn["eyes"]["body"]),
    )
    np.testing.assert_allclose(features[0, -11:], np.concatenate([others, at]), rtol=1e-6)


def test_a_direction_in_bytes_is_normalized_and_an_image_is_scaled_by_the_largest_code():
    space = Parts(MINIGRID)
    made, rng = student(space), np.random.default_rng(0)
    images, direction = rng.integers(0, 9, (300, 7, 7, 3), np.uint8), rng.integers(0, 4, 300)
    images[0, 0, 0, 0] = 8
    flat = torch.as_tensor(space.flatten_batch({"image": images, "direction": direction}))
    with pytest.warns(UserWarning, match="image observations reach 8 in the first rollout"):
        made.normaliser.track(flat)
    scaled = made.normaliser(flat)
    image, where = scaled[:, :-4], scaled[:, -4:]
    np.testing.assert_allclose(image.view(300, 7, 7, 3), images / np.float32(8), rtol=1e-6)
    assert where.mean(0).abs().max() < 1e-5 and (where.std(0) - 1).abs().max() < 0.01
    twin = student(space, seed=1)
    twin.load_state_dict(made.state_dict())
    assert torch.equal(twin.normaliser(flat), scaled) and torch.equal(twin(flat)[1], made(flat)[1])


@pytest.mark.parametrize("config", [TINY, GRU], ids=["feed-forward", "GRU"])
def test_gradients_reach_all_pixels_and_all_layers(config):
    space = Parts(SPACES["two images"])
    made = student(space, config)
    seen = torch.rand(6, space.shape[0], requires_grad=True)
    _, value = made.policy_and_value(seen)
    value.sum().backward()
    assert (seen.grad.abs().sum(0) > 0).float().mean() > 0.9  # a filter may be silent at some pixels
    for part in space.parts:
        assert seen.grad[:, part.first : part.last].abs().sum() > 0, part.name
    method = DR(upomdp(SPACES["two images"]), config, seed=0)
    before = {name: weight.clone() for name, weight in method.student.named_parameters()}
    method.update()
    moved = {name for name, weight in method.student.named_parameters() if not torch.equal(weight, before[name])}
    convolutions = {name for name in before if ".read." in name and "torso" in name}
    assert len(convolutions) == 8 and convolutions <= moved  # weight and bias, of two images, of actor and critic


def test_without_convolutions_the_vector_is_seen_as_any_other():
    space, flat = Parts(SPACES["tuple"]), Box(0, 1, Parts(SPACES["tuple"]).shape, np.float32)
    one, other = student(space, PPOConfig(hidden_size=8, network="mlp")), student(flat, PPOConfig(hidden_size=8))
    seen = torch.rand(5, space.shape[0])
    assert torch.equal(one(seen)[1], other(seen)[1]) and one.state_dict().keys() == other.state_dict().keys()


@pytest.mark.parametrize("network", ["auto", "mlp", "cnn"])
def test_network_decides_about_images_that_are_the_whole_observation(network):
    made = student(BYTES, PPOConfig(hidden_size=8, network=network))
    assert any(isinstance(layer, torch.nn.Conv2d) for layer in made.actor_torso) == (network != "mlp")
    assert made(torch.zeros(2, *BYTES.shape, dtype=torch.uint8))[1].shape == (2,)


class Arrow(Probe):
    """A dot in the left or right half of an image, and a sign: the dot's half pays 1, the other if the sign is up."""

    size, actions, dim = 5 * 6 * 3 + 2, 2, 1

    def __init__(self, num_envs=16):
        super().__init__(num_envs)
        self.single_observation_space = Parts(Dict([("image", BYTES), ("sign", Discrete(2))]))
        self.pick = np.random.default_rng(3)

    def look(self):
        images = np.zeros((self.num_envs, 5, 6, 3), np.uint8)
        self.half, self.up = self.pick.integers(0, 2, (2, self.num_envs))
        images[range(self.num_envs), self.pick.integers(0, 5, self.num_envs), 3 * self.half + 1, 1] = 200
        return self.single_observation_space.flatten_batch({"image": images, "sign": self.up})

    def outcome(self, actions):
        return (
            (actions == self.half ^ self.up).astype(float),
            np.ones(self.num_envs, bool),
            np.zeros(self.num_envs, bool),
        )


@pytest.mark.long
def test_ppo_learns_from_an_image_and_another_part():
    config = PPOConfig(num_steps=32, num_minibatches=4, learning_rate=5e-3, hidden_size=32, ent_coef=0.0)
    method = DR(Arrow(), config, seed=0)
    for _ in range(10):
        metrics = method.update()
    assert metrics["return_100/student"] > 0.95  # 0.5 without the image, or without the sign


@pytest.mark.parametrize("team", ["independent", "shared"])
@pytest.mark.parametrize("critic", ["own", "central"])
def test_teams_have_convolutions_too(team, critic):
    """Each agent's policy reads its own image alone; a central critic reads all."""
    space = Parts(SPACES["dict"])
    made = student(space, PPOConfig(hidden_size=8, team=team, critic=critic, memory="gru"), agents=2)
    seen = torch.as_tensor(np.stack([space.sample() for _ in range(6)])).view(3, 2, -1)
    changed = seen.clone()
    changed[:, 1, 4:50] = 255 - changed[:, 1, 4:50]
    (policy, value), (other, others) = made(seen), made(changed)
    same = [torch.equal(policy.log_probs[:, agent], other.log_probs[:, agent]) for agent in range(2)]
    assert same == [True, False]
    assert torch.equal(value[:, 0], others[:, 0]) == (critic == "own")
    made.normaliser.track(seen)
    made(seen)[1].sum().backward()


@pytest.mark.parametrize("config", [TINY, GRU], ids=["feed-forward", "GRU"])
def test_a_saved_policy_acts_on_dicts_and_batches_of_them(config, tmp_path):
    method = DR(upomdp(SPACES["nested"]), config, seed=0)
    method.update()
    state = {"method": method.state_dict(episodes=False), "spaces": spaces_of(method.upomdp)}
    checkpoint.save(tmp_path / "checkpoint.pt", state | {"config": {"ppo": vars(config)}})
    policy, space = load_policy(tmp_path), SPACES["nested"]
    drawn = [space.sample() for _ in range(20)]
    batch = gymnasium.vector.utils.concatenate(space, drawn, gymnasium.vector.utils.create_empty_array(space, 20))
    flat = method.upomdp.single_observation_space.flatten_batch(batch)
    expected = policy.act(flat, greedy=True)
    policy.begin()
    np.testing.assert_array_equal(policy.act(batch, greedy=True), expected)
    assert expected.shape == (20,)
    for one, action in zip(drawn[:5], expected, strict=False):
        policy.begin()
        assert policy.act(one, greedy=True) == action
    torch.testing.assert_close(policy.student(torch.as_tensor(flat))[1], method.student(torch.as_tensor(flat))[1])
    with pytest.raises(ValueError, match=r"observations\['eyes'\]\['left'\] is missing, got \['body'\]"):
        policy.act({"at": 5, "eyes": {"body": drawn[0]["eyes"]["body"]}})


@pytest.mark.slow
@pytest.mark.parametrize("make", [DR, PLR, Paired])
def test_runs_go_on_bit_for_bit(make):
    def method():
        return make(Arrow(4), TINY, seed=2)

    one, twin = method(), method()
    one.update()
    twin.load_state_dict(copy.deepcopy(one.state_dict()))
    for learner, other in zip(one.learners, twin.learners, strict=True):
        other.upomdp.pick = copy.deepcopy(learner.upomdp.pick)
        other.upomdp.half, other.upomdp.up = learner.upomdp.half, learner.upomdp.up
        other.worker.observation = learner.worker.observation
    for _ in range(2):
        metrics, others = one.update(), twin.update()
        for name, value in metrics.items():
            assert name.startswith("time/") or others[name] == pytest.approx(value, rel=0, abs=0, nan_ok=True), name
    for learner, other in zip(one.learners, twin.learners, strict=True):
        for name, weights in learner.student.state_dict().items():
            assert torch.equal(weights, other.student.state_dict()[name]), name


def test_a_mixture_of_equal_parts_knows_its_image():
    mixture = ued.Mixture([Arrow(4), Arrow(4)], ["one", "two"])
    space = mixture.single_observation_space
    assert isinstance(space, Parts) and space.shape == (94,) and len(space.images) == 1
    seen, _ = mixture.reset(seed=0)
    assert seen.dtype == np.uint8 and (seen[:, -2:].sum(1) == 1).all()
    image = of_convolutions(student(space), seen)[0]
    np.testing.assert_allclose(image.movedim(1, -1).flatten(1), seen[:, :90] / np.float32(255), rtol=1e-6)
    metrics = DR(mixture, TINY, seed=0).update()
    assert metrics["env_steps"] == 32
    other = Arrow(4)
    other.single_observation_space = Parts(Dict([("sign", Discrete(2)), ("image", BYTES)]))
    assert not isinstance(ued.Mixture([Arrow(4), other], ["one", "two"]).single_observation_space, Parts)


def test_evaluation_and_copies_of_environments_see_parts_too():
    method = Paired(upomdp(), TINY, seed=0)
    method.update()
    assert all(isinstance(one.upomdp.single_observation_space, Parts) for one in method.learners)
    assert ued.evaluate(method.student, upomdp(), episodes=4, seed=0).returns.shape == (4,)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"image": np.zeros((6, 5, 3), np.uint8)},
            r"observations\['image'\] has shape \(6, 5, 3\), its space has \(5, 6",
        ),
        ({"direction": 4}, r"observations\['direction'\] must be in Discrete\(4\), got 4"),
        ({"direction": -1}, r"observations\['direction'\] must be in Discrete\(4\), got -1"),
        ({"direction": 0.5}, r"observations\['direction'\] must be in Discrete\(4\), got 0.5"),
        ({"image": None}, r"observations\['image'\] is missing, got \['direction'\]"),
    ],
)
def test_observations_that_do_not_fit_are_refused_with_their_part(change, message):
    good = {"direction": 1, "image": np.zeros((5, 6, 3), np.uint8)}
    given = {name: value for name, value in (good | change).items() if value is not None}
    with pytest.raises(ValueError, match=message):
        Parts(SPACES["dict"]).flatten(given)


def test_batches_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match=r"the same number of environments, got \[2, 3\]"):
        Parts(SPACES["dict"]).flatten_batch({"direction": [0, 1], "image": np.zeros((3, 5, 6, 3))})


def test_spaces_and_networks_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"observations\['mission'\] must be a Box, Discrete, .* got Text"):
        Parts(Dict(image=BYTES, mission=Text(9)))
    with pytest.raises(ValueError, match="Parts needs a Dict or a Tuple, got Discrete"):
        Parts(Discrete(3))
    for space in (Box(0, 1, (9,)), Parts(Dict(image=Box(0, 1, (4, 4, 3)))), Box(0, 1, (4, 4, 3))):
        with pytest.raises(ValueError, match="network = cnn needs images of at least 5 x 5, got"):
            student(space, PPOConfig(network="cnn"))


def test_a_text_beside_an_image_is_refused_or_its_effect_is_said():
    """One of no fixed size is refused with the way out; others are flattened with the image."""
    space = Dict(image=BYTES, direction=Discrete(4), words=Sequence(Discrete(9)))
    way = r"observations\['words'\] must have a fixed size, .*FilterObservation\(env, \['image', 'direction'\]\)"
    with pytest.raises(ValueError, match=way):
        as_array(Random(space))
    filtered = gymnasium.wrappers.FilterObservation(Random(space), ["image", "direction"])
    assert isinstance(as_array(filtered).observation_space, Parts)
    said = r"images are flattened, so no convolutions read them: observations\['mission'\] must be a Box, .*, got Text"
    with pytest.warns(UserWarning, match=said):
        flat = as_array(Random(Dict(image=BYTES, mission=Text(9))))
    assert not isinstance(flat.observation_space, Parts) and flat.observation_space.shape == (99,)
