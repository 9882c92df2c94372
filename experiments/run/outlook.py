"""What a budget gives, said before training: about how many levels, when the method begins with them, and if too few.

The estimate is from the environment's limit of steps, so it is the least that the budget gives: episodes that end
sooner give more levels. Read next: `ued.levels.budget`, the rules; `run.events`, what is said while a run trains.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from regista.experiments.run.notes import warn
from ued.config import ALPGMMConfig, PairedLiteralConfig, PLRConfig, RepairedConfig, SFLConfig, TeacherConfig
from ued.levels.budget import BATCH, FILL, LEAST_BATCH, SHARE
from ued.methods import METHODS

FEW = 2  # levels of each environment in a run: below this nothing is learned from most of them


@dataclass(frozen=True)
class Outlook:
    """What a run gives at least.

    Attributes:
        config: settings of the run.
        limit: steps of an episode at most.
        students: who play each level.
        episodes: that each of them plays on it.
    """

    config: Any
    limit: int
    students: int
    episodes: int

    @property
    def steps(self) -> int:
        """env_steps of a level at most."""
        return self.limit * self.students * self.episodes

    @property
    def levels(self) -> int:
        """Levels of the run, if all episodes last as long as they may."""
        return int(self.config.total_env_steps // self.steps)

    @property
    def method(self) -> Any:
        """The method's own settings."""
        return getattr(self.config, METHODS[self.config.method].group)

    def line(self) -> str:
        """Return the estimate as a line for the terminal."""
        title = METHODS[self.config.method].title
        begins = "".join(f"; {title} {what}" for what in self._begins())
        each = f", {self.steps:_} env_steps each" if self.steps > self.limit else ""
        return f"about {self.levels:_} levels of at most {self.limit:_} steps an episode{each}{begins}"

    def _begins(self) -> Iterator[str]:
        own = self.method
        if isinstance(own, PLRConfig | RepairedConfig):
            yield f"starts to replay after {self._or_sooner(self.replay_after(), own.min_fill is None)}"
        if isinstance(own, TeacherConfig):
            levels = own.adversary.min_batch or BATCH
            yield f"teaches its adversary every {self._or_sooner(levels, own.adversary.min_batch is None)}"

    def _or_sooner(self, levels: int, by_budget: bool) -> str:
        """Return so many levels in words, or the share of the budget that is spent sooner."""
        if not by_budget or levels * self.steps <= SHARE * self.config.total_env_steps:
            return f"{levels:_} levels"
        return f"{levels:_} levels or {round(SHARE * self.config.total_env_steps):_} env_steps, whichever comes first"

    def replay_after(self) -> int:
        """Return how many levels must be offered before anything is replayed, in a long run."""
        share = FILL if self.method.min_fill is None else self.method.min_fill
        return math.ceil(share * self.method.buffer.capacity)

    def shortcomings(self) -> Iterator[str]:
        """Yield in what the budget is too small for the method, if all episodes last as long as they may."""
        own, envs = self.method, self.config.num_envs
        if self.levels < FEW * envs:
            enough = FEW * envs * self.steps
            yield (
                f"each of {envs} environments plays fewer than {FEW} levels; "
                f"--total-env-steps {enough:_} would be enough, or fewer --num-envs"
            )
        if isinstance(own, PLRConfig | RepairedConfig) and own.min_fill is not None:
            yield from self._too_few(self.replay_after(), "replay starts", f"--{self._flag('min-fill')}")
        if isinstance(own, TeacherConfig):
            batch = LEAST_BATCH if own.adversary.min_batch is None else own.adversary.min_batch
            yield from self._too_few(batch, "the adversary learns", f"--{self._flag('adversary.min-batch')}")
        if isinstance(own, ALPGMMConfig):
            yield from self._too_few(own.fit_every, "the first mixture is fitted", "--alp-gmm.fit-every")
        if isinstance(own, SFLConfig):
            looked_at = own.candidates * own.candidate_episodes
            yield from self._too_few(looked_at, "levels are chosen", "--sfl.candidates")
        if isinstance(own, PairedLiteralConfig) and self.limit > self.config.ppo.num_steps:
            yield (
                f"episodes may be longer than a rollout of {self.config.ppo.num_steps} steps, and such levels teach "
                f"nothing; --num-steps {self.limit} holds them"
            )

    def _too_few(self, needed: int, what: str, flag: str) -> Iterator[str]:
        """Yield that half of the run has fewer levels than are needed, if it is so."""
        if needed > self.levels / 2:
            yield f"{what} only after {needed:_} levels; use a longer run or a smaller {flag}"

    def _flag(self, name: str) -> str:
        return f"{METHODS[self.config.method].group}.{name}".replace("_", "-")


def outlook(config: Any, method: Any) -> Outlook | None:
    """Return what a run gives that trains this method; None where the environment declares no limit of steps."""
    limit = method.upomdp.max_episode_steps
    if limit is None:
        return None
    own = getattr(config, METHODS[config.method].group)
    returns = method.curriculum.dtype["returns"].shape  # [S, n]
    return Outlook(config, limit, returns[0], 1 if isinstance(own, SFLConfig) else returns[1])


def tell(config: Any, method: Any, say: Any) -> None:
    """Say what the budget gives, and warn on stderr where that is too little for the method."""
    found = outlook(config, method)
    if found is None:
        say("the environment declares no limit of steps: how many levels this run plays is not known")
        return
    say(found.line())
    for shortcoming in found.shortcomings():
        name = METHODS[config.method].title
        warn(f"warning: the budget may be too small for {name}: about {found.levels:_} levels; {shortcoming}")
