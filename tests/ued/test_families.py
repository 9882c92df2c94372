"""Every method on a family of levels does what the table of docs/methods.md says."""

import re
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

import ued
from tests.ued.words import DeclaredWords, TypedWords, Words
from ued.core.task import theta_of_scene
from ued.levels.builder import Builder
from ued.levels.proposer import CodeAdversary
from ued.methods import METHODS

PAGE = Path(__file__).parent.parent.parent / "docs" / "methods.md"
FAMILIES = {"plain": Words, "parameters": DeclaredWords, "builder": TypedWords}
ADVERSARIES = {"levels at once": CodeAdversary, "step by step": Builder}
PPO = ued.PPOConfig(num_steps=16, num_minibatches=1, update_epochs=1, hidden_size=8)


class Spelling(gymnasium.Env):
    """One letter is shown; saying whether it is an "a" is paid for."""

    observation_space, action_space = Box(0, 1, (4,), np.float32), Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return self.see(), {}

    def step(self, action):
        return self.see(), float((self.word[0] == "a") == action), True, False, {}

    def see(self):
        return np.eye(4, dtype=np.float32)["abcd".index(self.word[0])]


def make(family):
    return ued.GymUPOMDP(Spelling, lambda env, word: setattr(env, "word", word), family(), 4)


def promised():
    """Return what the page says of each method: `{method: {family: cell}}`."""
    section = PAGE.read_text().partition("## Level families")[2].partition("## ")[0]
    rows = re.findall(r"^\| (`.*?) \| (.*?) \| (.*?) \| (.*?) \|$", section, re.M)
    found = {}
    for names, *cells in rows:
        found |= {name: dict(zip(FAMILIES, cells, strict=True)) for name in re.findall(r"`(\w+)`", names)}
    return found


def test_the_table_has_every_method():
    assert promised().keys() == METHODS.keys()


@pytest.mark.slow
@pytest.mark.sample(7)
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", METHODS)
def test_a_method_trains_on_a_family_or_refuses_it_as_the_page_says(name, family):
    says, upomdp = promised()[name][family], make(FAMILIES[family])
    if says == "rejected":
        with pytest.raises(ValueError, match=r"levels of .*Words can be sampled and mutated.* use dr, plr"):
            METHODS[name].load()(upomdp, PPO, seed=0, env_steps=400)
        return
    method = METHODS[name].load()(upomdp, PPO, seed=0, env_steps=400)
    for _ in range(3):
        assert method.update()["levels"] > 0
    if says != "yes":
        assert type(method.curriculum.adversary) is ADVERSARIES[says]


def test_tests_of_a_family_are_lists_of_levels():
    upomdp = make(Words)
    assert theta_of_scene(["aaaa", "abcd"], upomdp).shape == (2, 4)
    with pytest.raises(ValueError, match=r"expected a list of levels of Words, as its `sample` returns"):
        theta_of_scene([7], upomdp)
