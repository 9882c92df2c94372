"""A learned teacher: an adversary that proposes levels, with a share of random ones, and learns from their scores.

PAIRED, minimax and self-regret differ in what they call a score, and in nothing else. Read next: `levels.adversary`,
the policy; `methods.minimax`, the shortest use.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ued.config import TeacherConfig
from ued.curriculum import LevelSpace
from ued.levels.adversary import Adversary, Proposals
from ued.levels.record import Origin, make_trials, trial_dtype
from ued.seeding import split_seed, torch_stream
from ued.upomdp import UPOMDP, level_dtype


class Teacher:
    """Proposes trials and learns from the scores of its own proposals among them.

    Args:
        space: what levels there are.
        config: the adversary; how many levels are random; what an invalid proposal costs.
        students, episodes: S and n of the trials.
        seed: of its random streams.

    Raises `ValueError` where the environment has no free parameters.
    """

    def __init__(self, space: LevelSpace, config: TeacherConfig, students: int, episodes: int, seed: int) -> None:
        self.space, self.config = space, config
        adversary, mix = split_seed(seed, 2)
        self.view = self._view()
        size = None if self.view is None else int(np.prod(self.view.single_observation_space.shape or ()))
        self.adversary = Adversary(space.theta_dim, config.adversary, torch_stream(adversary), size)
        self.mix = np.random.default_rng(mix)
        own = [
            ("z", np.float32, (self.adversary.context_size,)),
            ("raw", np.float32, (space.theta_dim,)),
            ("log_prob", np.float32),
        ]
        self.dtype = trial_dtype(level_dtype(space.theta_dim), students, episodes, own)
        self.lessons = np.zeros(0, self.dtype)  # settled proposals that the adversary has yet to learn from

    def propose(self, count: int) -> np.ndarray:
        """Give `count` trials: the adversary's proposals, some random levels among them."""
        proposals = self.adversary.propose(count, self._context(count))
        theta = self.adversary.theta(proposals)
        trials = make_trials(self.dtype, self.space.make_levels(theta), Origin.PROPOSED)
        trials["z"], trials["raw"], trials["log_prob"] = proposals
        trials["origin"][~self.space.valid(theta)] = Origin.REPLACED
        trials["origin"][self.mix.random(count) < self.config.dr_fraction] = Origin.RANDOM
        random = trials["origin"] != Origin.PROPOSED
        trials["level"][random] = self.space.sample_levels(int(random.sum()))
        return trials

    def _view(self) -> UPOMDP | None:
        """Give environments of the adversary's own, if it is to see what students see."""
        if self.config.adversary.context == "random":
            return None
        if not isinstance(self.space, UPOMDP):
            raise ValueError("the context 'observation' needs a UPOMDP to look at; use 'random'")
        return self.space.copy()

    def _context(self, count: int) -> np.ndarray | None:
        """Give what is seen of `count` random levels as they begin (thesis, section 4.3): `[count, size]`."""
        if self.view is None:
            return None
        seen: list[np.ndarray] = []
        while sum(len(each) for each in seen) < count:  # no step is simulated
            levels = self.space.sample_levels(self.view.num_envs)
            seen.append(self.view.reset_to_levels(levels)[0].reshape(len(levels), -1))
        return np.concatenate(seen)[:count]

    def learn(self, trials: np.ndarray) -> dict[str, float]:
        """Let the adversary learn from its own among these scored trials, once enough of them are there."""
        lessons = trials[trials["origin"] == Origin.PROPOSED]
        if self.config.invalid_penalty:
            refused = trials[trials["origin"] == Origin.REPLACED]  # what was played in their place is not theirs
            refused["score"] = -self.config.invalid_penalty
            lessons = np.concatenate([lessons, refused])
        self.lessons = np.concatenate([self.lessons, lessons])
        if len(self.lessons) < self.config.adversary.min_batch:
            return {}
        proposals = Proposals(*(np.ascontiguousarray(self.lessons[name]) for name in ("z", "raw", "log_prob")))
        losses = self.adversary.learn(proposals, self.lessons["score"])
        self.lessons = self.lessons[:0]
        return {f"adversary/{name}": value for name, value in losses.items()}

    def state_dict(self) -> dict[str, Any]:
        """Give everything that changes."""
        return {
            "adversary": self.adversary.state_dict(),
            "lessons": self.lessons.copy(),
            "mix": self.mix.bit_generator.state,
        }

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` gave."""
        self.adversary.load_state_dict(state["adversary"])
        self.lessons = state["lessons"].copy()
        self.mix.bit_generator.state = state["mix"]
