"""Images are scaled by their bounds, or by what is seen where that stays far below them (MiniGrid)."""

import copy
import warnings

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete

from ued.config import PPOConfig
from ued.learning.pixels import Pixels
from ued.learning.student import Student

BYTES = Box(0, 255, (7, 7, 3), np.uint8)


def grids(count=200, seed=0):
    """Return images `[count, 7, 7, 3]` of MiniGrid's kind: objects 0-10, colors 0-5, states 0-2."""
    rng = np.random.default_rng(seed)
    return torch.as_tensor(np.stack([rng.integers(0, top, (count, 7, 7)) for top in (11, 6, 3)], -1), dtype=torch.uint8)


def student(space=BYTES):
    return Student(space, Discrete(7), PPOConfig(), torch.Generator().manual_seed(0))


@pytest.mark.parametrize("tracked", [False, True])
def test_small_numbers_in_a_box_of_bytes_are_as_clear_as_in_their_own(tracked):
    """Without it, features differ 25 times less between observations."""
    spread = {}
    for high in (255, 10):
        made = student(Box(0, high, (7, 7, 3), np.uint8))
        if tracked:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                made.normaliser.track(grids())
        with torch.no_grad():
            spread[high] = float(made.actor_torso(made.normaliser(grids())).std(0).mean())
    assert spread[255] > spread[10] / 2


@pytest.mark.parametrize("bright", [26, 255])
def test_camera_images_are_scaled_by_their_bounds_bit_for_bit(bright):
    images = torch.randint(0, 25, (50, 84, 84, 4), generator=torch.Generator().manual_seed(0), dtype=torch.uint8)
    images[:, 3, 4, 1] = bright
    pixels = Pixels(Box(0, 255, (84, 84, 4), np.uint8))
    expected = images.float() / 255
    assert torch.equal(pixels(images), expected)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pixels.track(images)
    assert torch.equal(pixels(images), expected)
    pixels.track(torch.zeros_like(images))
    assert torch.equal(pixels(images[:, ::2]), expected[:, ::2]) and pixels.scale == 255.0


def test_planes_of_0_and_255_and_images_without_bounds_stay_as_they_are():
    planes = (grids() % 2 * 255).to(torch.uint8)
    assert torch.equal(Pixels(BYTES)(planes), planes.float() / 255)
    free = Pixels(Box(-np.inf, np.inf, (7, 7, 3), np.float32))
    free.track(grids() / 1000)
    assert torch.equal(free(grids()), grids().float())


def test_the_scale_follows_the_largest_value():
    pixels = Pixels(BYTES)
    with pytest.warns(UserWarning, match="reach 10 in the first rollout, their space 0 to 255"):
        pixels.track(grids())
    assert pixels.scale == 10.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # it is said once
        pixels.track(grids() * 2)
    assert pixels.scale == 20.0
    assert pixels(grids()).max() == 0.5


def test_black_images_decide_nothing():
    pixels = Pixels(BYTES)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pixels.track(torch.zeros(3, 7, 7, 3, dtype=torch.uint8))
        pixels.track(torch.full((3, 7, 7, 3), 200, dtype=torch.uint8))
    assert pixels.scale == 255.0


def test_what_is_seen_before_the_first_rollout_depends_on_each_image_alone():
    pixels, images = Pixels(BYTES), torch.cat([grids(4), grids(4) * 20])
    together = pixels(images)
    for row in range(8):
        assert torch.equal(pixels(images[row : row + 1])[0], together[row])
    assert torch.equal(together[4:], images[4:].float() / 255)


@pytest.mark.filterwarnings("ignore:image observations")
@pytest.mark.parametrize("shape", [(3, 7, 7), (7, 7, 3)])
def test_channels_may_be_anywhere_and_teams_share_a_scale(shape):
    pixels = Pixels(Box(0, 255, shape, np.uint8))
    images = grids() if shape[-1] == 3 else grids().movedim(-1, -3)
    pixels.track(images.view(100, 2, *shape))  # two agents
    assert pixels.scale == 10.0
    assert torch.equal(pixels(images.view(100, 2, *shape)).view(200, *shape), pixels(images))
    assert pixels(images).max() == 1.0


@pytest.mark.filterwarnings("ignore:image observations")
def test_the_scale_is_part_of_the_student():
    one, two = student(), student()
    one.normaliser.track(grids())
    two.load_state_dict(one.state_dict())
    assert torch.equal(two.normaliser(grids(seed=1)), one.normaliser(grids(seed=1)))
    assert torch.equal(copy.deepcopy(one).normaliser(grids(seed=1)), one.normaliser(grids(seed=1)))


def test_a_student_saved_without_a_scale_sees_as_it_was_trained():
    state = student().state_dict()
    del state["normaliser.scale"]
    again = student()
    again.load_state_dict(state)
    assert torch.equal(again.normaliser(grids()), grids().float() / 255)
