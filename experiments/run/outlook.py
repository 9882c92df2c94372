"""Estimate of a budget before training: the number of levels, and whether the curriculum will start in time.

The estimate assumes episodes of maximum length, so it is a lower bound: shorter episodes give more levels. Read next:
`ued.levels.budget`, the rules; `run.events`, warnings during training.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from regista.experiments.run.notes import warn
from regista.experiments.run.progress import counted
from ued.config import (
    ALPGMMConfig,
    NCCConfig,
    PairedLiteralConfig,
    PLRConfig,
    RepairedConfig,
    SFLConfig,
    TeacherConfig,
)
from ued.levels.budget import BATCH, FILL, LEAST_BATCH, SHARE
from ued.methods import METHODS

FEW = 2  # minimum levels per environment in a run
UNKNOWN = (
    "the environment declares no step limit, so the number of levels in this run is unknown; "
    "wrap it in gymnasium.wrappers.TimeLimit, or, in a UPOMDP class of your own, set self.max_episode_steps"
)


@dataclass(frozen=True)
class Outlook:
    """Lower bounds for a run.

    Attributes:
        config: settings of the run.
        limit: maximum length of an episode in steps.
        students: number of students that play each level.
        episodes: number of episodes of each student on a level.
    """

    config: Any
    limit: int
    students: int
    episodes: int

    @property
    def steps(self) -> int:
        """Maximum env_steps per level."""
        return self.limit * self.students * self.episodes

    @property
    def levels(self) -> int:
        """Number of levels in the run if all episodes have maximum length."""
        return int(self.config.total_env_steps // self.steps)

    @property
    def method(self) -> Any:
        """The settings of the method."""
        return getattr(self.config, METHODS[self.config.method].group)

    def line(self) -> str:
        """Return the estimate as a line for the terminal."""
        title = METHODS[self.config.method].title
        begins = "".join(f"; {title} {what}" for what in self._begins())
        each = f", {self.steps:_} env_steps each" if self.steps > self.limit else ""
        return (
            f"about {counted(self.levels, 'level')} of at most {counted(self.limit, 'step')} per episode{each}{begins}"
        )

    def _begins(self) -> Iterator[str]:
        own = self.method
        if isinstance(own, PLRConfig | RepairedConfig | NCCConfig):
            yield f"starts replay after {self._or_sooner(self.replay_after(), own.min_fill is None)}"
        if isinstance(own, TeacherConfig):
            levels = own.adversary.min_batch or BATCH
            yield f"updates its adversary every {self._or_sooner(levels, own.adversary.min_batch is None)}"

    def _or_sooner(self, levels: int, by_budget: bool) -> str:
        """Describe a number of levels, or the share of the budget if it is reached first."""
        if not by_budget or levels * self.steps <= SHARE * self.config.total_env_steps:
            return counted(levels, "level")
        steps = round(SHARE * self.config.total_env_steps)
        return f"{counted(levels, 'level')} or {steps:_} env_steps, whichever comes first"

    def replay_after(self) -> int:
        """Return the number of levels before replay starts, in a long run."""
        own = self.method
        capacity = own.capacity if isinstance(own, NCCConfig) else own.buffer.capacity
        return math.ceil((FILL if own.min_fill is None else own.min_fill) * capacity)

    def shortcomings(self) -> Iterator[str]:
        """Yield the shortcomings of the budget for the method if all episodes have maximum length."""
        own, envs = self.method, self.config.num_envs
        if self.levels < FEW * envs:
            enough = FEW * envs * self.steps
            yield (
                f"{f'each of {envs} environments' if envs > 1 else 'the environment'} plays fewer than {FEW} levels; "
                f"--total-env-steps {enough:_} would be enough, or fewer --num-envs"
            )
        if isinstance(own, PLRConfig | RepairedConfig | NCCConfig) and own.min_fill is not None:
            yield from self._too_few(self.replay_after(), "replay starts", f"--{self._flag('min-fill')}")
        if isinstance(own, TeacherConfig):
            batch = LEAST_BATCH if own.adversary.min_batch is None else own.adversary.min_batch
            yield from self._too_few(batch, "the adversary learns", f"--{self._flag('adversary.min-batch')}")
        if isinstance(own, ALPGMMConfig):
            yield from self._too_few(own.fit_every, "the first mixture is fitted", "--alp-gmm.fit-every")
        if isinstance(own, SFLConfig):
            looked_at = own.candidates * own.candidate_episodes
            yield from self._too_few(looked_at, "levels are selected", "--sfl.candidates")
        if isinstance(own, PairedLiteralConfig) and self.limit > self.config.ppo.num_steps:
            yield (
                f"episodes can be longer than a rollout of {counted(self.config.ppo.num_steps, 'step')}, and students "
                f"do not learn from such levels; use --num-steps {self.limit}"
            )

    def _too_few(self, needed: int, what: str, flag: str) -> Iterator[str]:
        """Yield a warning if half of the run has fewer levels than needed."""
        if needed > self.levels / 2:
            yield f"{what} only after {counted(needed, 'level')}; use a longer run or a smaller {flag}"

    def _flag(self, name: str) -> str:
        return f"{METHODS[self.config.method].group}.{name}".replace("_", "-")


def outlook(config: Any, method: Any) -> Outlook | None:
    """Return the estimate for a run of this method; None if the environment declares no step limit."""
    limit = method.upomdp.max_episode_steps
    if limit is None:
        return None
    own = getattr(config, METHODS[config.method].group)
    returns = method.curriculum.dtype["returns"].shape  # [S, n]
    return Outlook(config, limit, returns[0], 1 if isinstance(own, SFLConfig) else returns[1])


def tell(config: Any, method: Any, say: Any) -> None:
    """Print the estimate, and warn on stderr if the budget is too small for the method."""
    found = outlook(config, method)
    if found is None:
        say(UNKNOWN)
        return
    say(found.line())
    for shortcoming in found.shortcomings():
        name = METHODS[config.method].title
        warn(f"warning: the budget may be too small for {name}: about {counted(found.levels, 'level')}; {shortcoming}")


def warn_of_annealing(config: Any) -> None:
    """Warn if the learning rate reaches 0 before the end of the run, for example in a run whose budget was extended."""
    annealed, total = config.ppo.anneal_env_steps, config.total_env_steps
    if 0 < annealed < total:
        warn(
            f"warning: students do not learn from {annealed:_} of {total:_} env_steps on, where --anneal-env-steps "
            "ends with a learning rate of 0"
        )
