"""Tasks: their scenes, their levels in all spellings, their baselines."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest

from ued import GymUPOMDP, Range, Task
from ued.core.task import TRAINING_SCENE, theta_of_scene
from ued.probes import LONGEST, Frontier, frontier


def make(num_envs):
    return Frontier(num_envs, 5, 3)


def test_scenes_are_the_training_distribution_then_the_tests():
    task = Task(make, {"short": np.zeros(3)}, held_out={"long": np.ones((2, 3))})
    assert list(task.scenes()) == [TRAINING_SCENE, "short"]
    assert list(task.scenes(held_out=True)) == [TRAINING_SCENE, "long"]
    assert task.make_scene(task.scenes()["short"]) is make
    other = Task(make, {"other": Frontier})
    assert other.make_scene(other.scenes()["other"]) is Frontier


@pytest.mark.parametrize("levels", [[0.1, 0.2, 0.3], [[0.1, 0.2, 0.3]], np.array([[0.1, 0.2, 0.3]])])
def test_levels_may_be_one_theta_or_several(levels):
    assert np.allclose(theta_of_scene(levels, make(1)), [[0.1, 0.2, 0.3]])
    assert theta_of_scene(Frontier, make(1)) is None  # random levels


def test_levels_may_be_values_by_name():
    upomdp = GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), lambda env, values: None, {"length": Range(0, 4)}, 1)
    assert theta_of_scene({"length": 3.0}, upomdp).tolist() == [[0.5]]
    assert theta_of_scene([{"length": 1.0}, {"length": 2.0}], upomdp).tolist() == [[-0.5], [0.0]]
    upomdp.close()


@pytest.mark.parametrize("levels", [[0.1], [2.0, 0, 0], {"speed": 1}, 7, ["a", "b", "c"]])
def test_other_levels_are_refused(levels):
    with pytest.raises(ValueError, match=r"expected theta \[L, 3\] or values by name"):
        theta_of_scene(levels, make(1))


@pytest.mark.parametrize("name", ["tests", "held_out", "baselines", "defaults", "about"])
def test_whatever_has_names_is_a_mapping(name):
    with pytest.raises(ValueError, match=f"{name} must be a mapping by name"):
        Task(make, **{name: [1]})


@pytest.mark.parametrize("name", [3, "", " ", "two\nlines"])
@pytest.mark.parametrize("part", ["tests", "held_out", "baselines"])
def test_names_in_tables_are_lines_of_text(part, name):
    with pytest.raises(ValueError, match="the name of a test or a baseline must be a line of text"):
        Task(make, **{part: {name: make}})


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ({"baselines": {"mine": None}}, "mine must be a function of environments, got None"),
        ({"painter": 3}, "painter must be a function of environments, got 3"),
        ({"success_word": None}, "success_word must be a line of text, got None"),
    ],
)
def test_parts_of_other_types_are_refused(part, message):
    with pytest.raises(ValueError, match=message):
        Task(make, **part)


def test_levels_by_name_need_environments_that_read_them():
    with pytest.raises(ValueError, match="Frontier has no theta_of"):
        theta_of_scene({"length": 1.0}, make(1))
    with pytest.raises(ValueError, match="got None"):
        theta_of_scene(None, make(1))


def test_no_test_has_the_name_of_the_training_distribution():
    with pytest.raises(ValueError, match="the name of the training levels"):
        Task(make, {TRAINING_SCENE: np.zeros(3)})


def test_there_is_always_a_random_policy():
    upomdp = make(4)
    assert list(Task(make).make_baselines(upomdp)) == ["random"]
    mine = object()
    made = Task(make, baselines={"mine": lambda upomdp: mine}).make_baselines(upomdp)
    assert list(made) == ["mine", "random"] and made["mine"] is mine
    own = Task(make, baselines={"random": lambda upomdp: mine}).make_baselines(upomdp)
    assert own == {"random": mine}


def test_the_frontier_tests_every_length_once():
    upomdp = frontier.make(2)
    theta = theta_of_scene(frontier.tests["every length"], upomdp)
    assert upomdp.length(theta).tolist() == list(range(1, LONGEST + 1)) and not upomdp.blocked(theta).any()
