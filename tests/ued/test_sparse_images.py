"""Binary images as coordinates: the same networks, outputs and gradients as of the images themselves."""

import copy
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete
from torch import nn

from ued.adapters.policy import space_from, spaces_of
from ued.config import PPOConfig
from ued.core.sparse_image import SparseImage, as_dense, dense_space
from ued.core.upomdp import of_one_agent
from ued.learning.memory import Past
from ued.learning.sparse_convolutions import Grid, convolve, images_of
from ued.learning.student import Student
from ued.methods.cenie import pair_columns

BYTES = Box(0, 255, (40, 52, 6), np.uint8)
SPACE = SparseImage(BYTES, 20)
CONFIG = PPOConfig(hidden_size=16, shared_torso=True)


def images(shape=BYTES.shape, count=30, most=20, seed=0):
    """Return images `[count, *shape]` of 0 to `most` pixels, in clusters and at all edges; the first has none."""
    rng = np.random.default_rng(seed)
    drawn = np.zeros((count, *shape), np.uint8)
    for image, pixels in zip(drawn[1:], rng.integers(0, most + 1, count - 1), strict=True):
        near = rng.integers(0, shape[:2]) + rng.integers(-2, 3, (pixels, 2)) * rng.integers(0, 12, (pixels, 1))
        row, column = np.clip(near, 0, np.array(shape[:2]) - 1).T
        image[row, column, rng.integers(0, shape[2], pixels)] = 255
    return drawn


def student(space, config=CONFIG, agents=1):
    made = Student(space, Discrete(5), config, torch.Generator().manual_seed(3), None, agents)
    for name, weights in made.named_parameters():
        if name.endswith("bias"):  # cells without a pixel differ from 0, and a ReLU clips some of them
            weights.data.normal_(0, 0.3, generator=torch.Generator().manual_seed(4))
    return made


# ---------------------------------------------------------------- the space


def test_coordinates_become_the_images_that_they_came_from():
    drawn = images()
    pixels = SPACE.sparse(drawn)
    assert pixels.shape == (30, 20, 3) and pixels.dtype == np.uint8 and all(map(SPACE.contains, pixels))
    np.testing.assert_array_equal(SPACE.dense(pixels), drawn)
    team = drawn.reshape(10, 3, *BYTES.shape)
    np.testing.assert_array_equal(SPACE.dense(SPACE.sparse(team)), team)
    np.testing.assert_array_equal(images_of(torch.as_tensor(pixels), BYTES.shape).numpy(), drawn / 255)
    for row in pixels:  # in the order of memory, unused ones last
        assert [tuple(pixel) for pixel in row.tolist()] == sorted(tuple(pixel) for pixel in row.tolist())


def test_large_images_have_coordinates_beyond_a_byte():
    wide = SparseImage(Box(0, 1, (8, 300, 2), np.float32), 4)
    drawn = np.zeros((1, 8, 300, 2), np.float32)
    drawn[0, 7, 299, 1] = drawn[0, 0, 256, 0] = 1.0
    assert wide.dtype == np.int32
    np.testing.assert_array_equal(wide.dense(wide.sparse(drawn)), drawn)


def test_a_team_has_an_axis_of_agents():
    team = SparseImage(BYTES, 20, agents=3)
    assert team.shape == (3, 20, 3) and of_one_agent(team, 3) == SPACE
    assert dense_space(team).shape == (3, *BYTES.shape) and dense_space(SPACE) is BYTES
    assert as_dense(BYTES, "an observation") == "an observation"


@pytest.mark.parametrize(
    ("space", "said"),
    [
        (Box(0, 255, (40, 52), np.uint8), "needs a Box of three axes"),
        (Box(-1, 1, (40, 52, 6), np.float32), "from 0 to one finite number"),
        (Box(0, np.inf, (40, 52, 6), np.float32), "from 0 to one finite number"),
        (Box(0, 255, (6, 40, 52), np.uint8), r"needs images \[height, width, channels\]"),
    ],
)
def test_spaces_that_are_no_binary_images_are_refused(space, said):
    with pytest.raises(ValueError, match=said):
        SparseImage(space, 3)


def test_images_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="at most 3 pixels that are not 0, got "):
        SparseImage(BYTES, 3).sparse(images())
    with pytest.raises(ValueError, match="must be 0 or 255, got other values"):
        SPACE.sparse(images() // 2)


# ---------------------------------------------------------------- convolutions


@pytest.mark.parametrize(
    ("shape", "first", "second"),
    [
        ((72, 96, 16), (8, 4), (4, 2)),  # the thesis's
        ((9, 7, 3), (3, 1), (3, 1)),  # of small images
        ((41, 53, 2), (5, 3), (4, 3)),  # kernels that are no multiple of the stride, rows that no window holds
        ((20, 20, 1), (2, 3), (2, 2)),  # gaps between windows
    ],
)
@pytest.mark.parametrize("most", [0, 1, 12])
def test_convolutions_and_their_gradients_are_those_of_dense_images(shape, first, second, most):
    torch.manual_seed(0)
    layers = [nn.Conv2d(shape[2], 6, *first).double(), nn.Conv2d(6, 5, *second).double()]
    drawn = images(shape, 12, most)
    found, expected = [], []
    for results, sparse in ((found, True), (expected, False)):
        for layer in layers:
            layer.zero_grad()
        if sparse:
            pixels = torch.as_tensor(SparseImage(Box(0, 255, shape, np.uint8), 14).sparse(drawn))
            features = convolve(pixels, Grid(*shape[:2]), *layers)
        else:
            features = torch.as_tensor(drawn / 255).movedim(-1, -3)
            for layer in layers:
                features = layer(features).relu()
        (features.square() * torch.linspace(-1, 1, features.shape[-1])).sum().backward()
        results += [features.detach(), *(weight.grad.clone() for layer in layers for weight in layer.parameters())]
    for ours, theirs in zip(found, expected, strict=True):
        torch.testing.assert_close(ours, theirs, rtol=1e-11, atol=1e-11)
    assert most == 0 or all(result.abs().sum() > 0 for result in found)


# ---------------------------------------------------------------- students


def test_a_student_has_the_weights_and_the_outputs_of_one_that_sees_images():
    ours, theirs = student(SPACE), student(BYTES)
    assert list(ours.state_dict()) == list(theirs.state_dict())
    assert all(torch.equal(a, b) for a, b in zip(ours.parameters(), theirs.parameters(), strict=True))
    drawn = torch.as_tensor(images())
    pixels = torch.as_tensor(SPACE.sparse(drawn.numpy()))
    for _ in range(2):  # before and after the scale is known
        (policy, value), (other, other_value) = ours(pixels), theirs(drawn)
        torch.testing.assert_close(policy.logits, other.logits, rtol=1e-5, atol=1e-6)
        torch.testing.assert_close(value, other_value, rtol=1e-5, atol=1e-6)
        assert torch.equal(ours(drawn)[1], other_value)  # it reads images, too, bit for bit
        ours.normaliser.track(pixels)
        theirs.normaliser.track(drawn)
    assert ours.normaliser.scale == theirs.normaliser.scale == 255.0
    twin = student(BYTES)
    twin.load_state_dict(copy.deepcopy(ours.state_dict()))
    assert torch.equal(twin(drawn)[1], other_value)


def test_blank_images_say_nothing_of_the_scale():
    ours = student(SPACE)
    ours.normaliser.track(torch.as_tensor(SPACE.sparse(images()[:1])))
    assert ours.normaliser.scale == 0.0


def test_the_convolutions_are_computed_from_coordinates(monkeypatch):
    """Coordinates do not become images on the way, which would give the same outputs slowly."""

    def refuse(*_):
        raise AssertionError("an image was made")

    for module in ("networks", "pixels"):
        monkeypatch.setattr(f"ued.learning.{module}.images_of", refuse)
    student(SPACE)(torch.as_tensor(SPACE.sparse(images())))
    with pytest.raises(AssertionError, match="an image was made"):
        student(SPACE, PPOConfig(hidden_size=16, network="mlp"))(torch.as_tensor(SPACE.sparse(images())))


@pytest.mark.parametrize(
    ("agents", "settings"),
    [
        (1, {"network": "mlp"}),
        (1, {"memory": "gru"}),
        (1, {"shared_torso": False, "head_size": 8}),
        (3, {}),
        (3, {"team": "shared"}),
        (3, {"critic": "central"}),
    ],
)
def test_all_networks_see_the_images(agents, settings):
    config = PPOConfig(**{"hidden_size": 16, "shared_torso": True} | settings)
    ours, theirs = student(SPACE, config, agents), student(BYTES, config, agents)
    drawn = images() if agents == 1 else images().reshape(10, 3, *BYTES.shape)
    pixels = torch.as_tensor(SPACE.sparse(drawn))
    (policy, value), (other, other_value) = (
        one(seen, Past(one.empty_memory(len(seen)))) for one, seen in ((ours, pixels), (theirs, torch.as_tensor(drawn)))
    )
    torch.testing.assert_close(policy.logits, other.logits, rtol=1e-5, atol=1e-6)
    torch.testing.assert_close(value, other_value, rtol=1e-5, atol=1e-6)


# ---------------------------------------------------------------- adapters


def test_a_deployed_policy_sees_images():
    upomdp = SimpleNamespace(agent_observation_space=SPACE, agent_action_space=Discrete(5), num_agents=1)
    assert space_from(spaces_of(upomdp)["observation"]) == BYTES


def test_cenie_refuses_images_as_coordinates():
    upomdp = SimpleNamespace(agent_observation_space=SPACE, agent_action_space=Discrete(5))
    with pytest.raises(ValueError, match=r"got 12,480 \(40 x 52 x 6\)"):
        pair_columns(upomdp)
