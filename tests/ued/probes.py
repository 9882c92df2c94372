"""Tiny vectorized UPOMDPs with known answers; the docstring of each says what it should teach."""

import copy

import numpy as np
from gymnasium.spaces import Box, Discrete
from gymnasium.vector.utils import batch_space

from ued.core.level_space import check_theta
from ued.core.parameters import numbered
from ued.core.upomdp import UPOMDP


class Probe(UPOMDP):
    """N environments with a clock `t` and an observation each. Subclasses say what a step does.

    `outcome(actions)` gives reward, terminated, truncated `[N]`; `look()` gives observations `[N, size]`.
    """

    size, actions, dim = 1, 2, 0
    seed_is_luck = True

    def __init__(self, num_envs=16):
        space = Box(-np.inf, np.inf, (self.size,), np.float32)
        draws = numbered("theta", self.dim)
        super().__init__(num_envs, space, Discrete(self.actions), draws)
        self.t = np.zeros(num_envs, np.int64)
        self.sign = np.ones(num_envs)
        self.stream = np.random.default_rng(0)

    def look(self):
        return np.zeros((self.num_envs, self.size), np.float32)

    def outcome(self, actions):
        raise NotImplementedError

    def _start(self, levels, where):
        self.t[where] = 0
        self.sign[where] = self.stream.choice([-1.0, 1.0], len(where))
        return self.look()

    def _advance(self, actions):
        reward, terminated, truncated = self.outcome(np.asarray(actions))
        self.t += 1
        return self.look(), reward, terminated, truncated, {}

    def get_state(self):
        state = {name: getattr(self, name).copy() for name in ("t", "sign")}
        return {**self.level_state(), **state, "stream": self.stream.bit_generator.state}

    def set_state(self, state):
        self.set_level_state(state)
        for name in ("t", "sign"):
            getattr(self, name)[:] = state[name]
        self.stream.bit_generator.state = state["stream"]
        return self.look()

    def copy(self):
        return copy.deepcopy(self)

    @property
    def everyone(self):
        return np.ones(self.num_envs, bool)


class Constant(Probe):
    """One step, reward 1 whatever one does: the value of the start is 1."""

    def outcome(self, actions):
        return np.ones(self.num_envs), self.everyone, ~self.everyone


class TwoStep(Probe):
    """Two steps, reward 1 at the end; the clock is seen. Values are gamma and 1."""

    def look(self):
        return self.t[:, None].astype(np.float32)

    def outcome(self, actions):
        last = self.t == 1
        return last.astype(float), last, np.zeros_like(last)


class Choice(Probe):
    """One step, reward 1 for action 1 and -1 for action 0: the policy should take action 1."""

    def outcome(self, actions):
        return np.where(actions == 1, 1.0, -1.0), self.everyone, ~self.everyone


class Follow(Probe):
    """One step, a sign is seen; reward 1 for the action that agrees with it, else -1."""

    def look(self):
        return self.sign[:, None].astype(np.float32)

    def outcome(self, actions):
        agrees = (actions == 1) == (self.sign > 0)
        return np.where(agrees, 1.0, -1.0), self.everyone, ~self.everyone


class Endless(Probe):
    """Reward 1 for ever, cut off every 5 steps, clock unseen: the value is 1 / (1 - gamma), not what 5 steps pay."""

    def outcome(self, actions):
        cut = self.t == 4
        return np.ones(self.num_envs), np.zeros_like(cut), cut


class Reach(Probe):
    """One step, two continuous actions in [0, 10]; reward falls with the distance from (7, 2)."""

    def __init__(self, num_envs=16):
        super().__init__(num_envs)
        self.single_action_space = Box(0.0, 10.0, (2,), np.float32)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def outcome(self, actions):
        assert actions.shape == (self.num_envs, 2) and (actions >= 0).all() and (actions <= 10).all()
        return -np.linalg.norm(actions - np.array([7.0, 2.0]), axis=1), self.everyone, ~self.everyone


class Landscape(Probe):
    """θ alone decides: a level near `PEAK` takes skill that grows with what a student does right; see `outcome`.

    One step, two actions. Close to the peak the right action is 1, elsewhere every action pays 1. Episodes are one to
    three steps long, by θ[0], so that students do not march in step.
    """

    dim = 2
    size = 2
    PEAK = np.array([0.5, -0.5])
    WIDTH = 0.35

    def look(self):
        return self.levels["theta"].astype(np.float32)

    def outcome(self, actions):
        distance = np.linalg.norm(self.levels["theta"] - self.PEAK, axis=1)
        lucky = self.stream.random(self.num_envs) < 0.5
        pays = np.where(distance < self.WIDTH, lucky.astype(float), 1.0)  # near the peak luck, elsewhere certainty
        last = self.t >= np.round(self.levels["theta"][:, 0] + 1).astype(int)
        return np.where(last, pays, 0.0), last, np.zeros_like(last)


class HalfValid(Landscape):
    """As `Landscape`, but only θ with a positive first column can be played."""

    def valid(self, theta):
        return check_theta(theta, self.dim)[:, 0] > 0


class Free(Probe):
    """Costs nothing and looks like football: 60 features, 19 actions, episodes of about 50 steps. For measuring."""

    dim, size, actions = 6, 60, 19

    def __init__(self, num_envs=16):
        super().__init__(num_envs)
        self.seen = self.stream.normal(size=(num_envs, self.size)).astype(np.float32)

    def look(self):
        return self.seen

    def outcome(self, actions):
        last = self.stream.random(self.num_envs) < 0.02
        return last.astype(float), last, np.zeros_like(last)
