"""What can be set about learning: frozen dataclasses whose fields carry their own help text.

The command line is derived from such fields (`regista.experiments.run.arguments`). No torch is needed here, so
`--help` is quick. Read next: `learning.ppo` and `methods.dr`, which are configured by them.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import NoneType
from typing import Any, Literal

# What a setting may have to be, and how that is said; nan is none of it.
RULES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "": (lambda value: True, ""),
    ">=1": (lambda value: value >= 1, "must be at least 1"),
    ">0": (lambda value: value > 0, "must be positive"),
    ">=0": (lambda value: value >= 0, "must not be negative"),
    "0-1": (lambda value: 0 <= value <= 1, "must be between 0 and 1"),
}


LARGEST_SEED = 2**32 - 1
Bound = float | Callable[[], float]  # a number, or what computes it on this machine


def most_threads() -> int:
    """Return how many threads, or processes that hold a game engine, a command may have on this machine."""
    return 4 * (os.cpu_count() or 1)


def setting(
    default: Any,
    help: str,
    rule: Literal["", ">=1", ">0", ">=0", "0-1"] = "",
    most: Bound | None = None,
    least: float | None = None,
) -> Any:
    """Return a dataclass field: its default, one line of help, as the command line shows it, and a rule of `RULES`.

    A number has a maximum, `most`, and where no rule gives its minimum, `least`.
    """
    return field(default=default, metadata={"help": help, "rule": rule, "most": most, "least": least})


def bounds_of(about: Mapping[str, Any]) -> tuple[float, float]:
    """Return the least and the largest number that a field of this metadata allows; infinite where there is none."""
    rule, least, most = about.get("rule", ""), about.get("least"), about.get("most")
    if rule == "0-1":
        return 0, 1
    lowest: float = {">=1": 1, ">=0": 0, ">0": 0}.get(rule, -math.inf) if least is None else least
    highest: float = math.inf if most is None else most() if callable(most) else most
    return lowest, highest


def complaint(about: Mapping[str, Any], value: Any) -> str | None:
    """Return what is wrong with a value for a field of this metadata, None if nothing is."""
    holds, words = RULES[about.get("rule", "")]
    if not holds(value):
        return f"{words}, got {value!r}"
    for number in value if isinstance(value, tuple) else (value,):
        if isinstance(number, int | float) and not isinstance(number, bool):
            least, most = bounds_of(about)
            if not least <= number:
                return f"must be at least {spelled(least)}, got {number!r}"
            if not number <= most:
                here = " on this machine" if callable(about.get("most")) else ""
                return f"must be at most {spelled(most)}{here}, got {number!r}"
    return None


def spelled(number: float) -> str:
    """Return a bound as it is typed: 1_000_000, 0.5, 1e+12."""
    return f"{number:_}" if isinstance(number, int) else f"{number:g}"


@functools.cache
def hints_of(kind: Any) -> dict[str, Any]:
    """Return the types of a class's fields, which are text otherwise and evaluated anew each time."""
    return typing.get_type_hints(kind)


class Checked:
    """Settings that obey the rules and bounds of their fields, and are values that a `Literal` annotation allows.

    Raises `ValueError` for the first one that does not.
    """

    def __post_init__(self) -> None:
        kind: Any = type(self)
        hints = hints_of(kind)
        for entry in dataclasses.fields(self):  # type: ignore[arg-type]  # subclasses are dataclasses
            value = self.__dict__[entry.name]
            if value is None and NoneType in typing.get_args(hints[entry.name]):
                continue
            if typing.get_origin(hints[entry.name]) is Literal:
                allowed = typing.get_args(hints[entry.name])
                wrong = None if value in allowed else f"must be {' or '.join(map(str, allowed))}, got {value!r}"
            else:
                wrong = complaint(entry.metadata, value)
            if wrong:
                raise ValueError(f"{entry.name} {wrong}")


@dataclass(frozen=True)
class PPOConfig(Checked):
    """Settings of a student and its learning, under CleanRL's names."""

    num_steps: int = setting(64, "steps of each environment between two updates", ">=1", most=65_536)
    learning_rate: float = setting(5e-4, "step size of Adam", ">0", most=10)
    anneal_env_steps: int = setting(
        0, "env_steps over which the learning rate falls linearly to 0; 0: constant", ">=0", most=10**12
    )
    gamma: float = setting(0.993, "discount per step", "0-1")
    gae_lambda: float = setting(0.95, "lambda of generalised advantage estimation", "0-1")
    num_minibatches: int = setting(8, "minibatches per epoch", ">=1", most=65_536)
    update_epochs: int = setting(4, "passes over each rollout", ">=1", most=1_000)
    clip_coef: float = setting(0.2, "how far the ratio of new to old probability may move from 1", ">0", most=1e6)
    clip_vloss: bool = setting(False, "clip the change of the value by clip_coef, too")
    norm_adv: bool = setting(True, "normalise the advantages of each minibatch")
    ent_coef: float = setting(0.01, "weight of the entropy bonus", ">=0", most=1e6)
    vf_coef: float = setting(0.5, "weight of the value loss", ">=0", most=1e6)
    max_grad_norm: float = setting(0.5, "the gradient is scaled down to this norm", ">0", most=1e12)
    target_kl: float = setting(
        0.0, "stop an update beyond this divergence of old and new policy; 0: never", ">=0", most=1e6
    )
    adam_eps: float = setting(1e-5, "Adam's epsilon", ">0", most=1)
    hidden_size: int = setting(128, "units in each hidden layer", ">=1", most=16_384)
    hidden_layers: int = setting(2, "hidden layers of each torso", ">=1", most=64)
    shared_torso: bool = setting(False, "actor and critic share their hidden layers")
    memory: Literal["none", "gru"] = setting(
        "none", "what the student remembers within an episode: nothing, or the state of a GRU behind its hidden layers"
    )
    team: Literal["independent", "shared"] = setting(
        "independent", "several agents have a policy each, or one for all that is told the agent's number"
    )
    critic: Literal["own", "central"] = setting(
        "own", "their values come from what each agent sees, or (MAPPO) from what all see, in hidden layers of its own"
    )
    obs_std_floor: float = setting(
        0.1,
        "observations are divided by their standard deviation, or by this many of their units, where these are known "
        "and that is less",
        ">=0",
        most=1e6,
    )

    @classmethod
    def thesis(cls) -> PPOConfig:
        """Return the settings of the thesis (Table 4.2, Fig. 4.10); see `PairedConfig.thesis`.

        On stacked SMM images with 19 actions this is the network of the figure, 750,228 weights.
        """
        return cls(
            num_steps=128, learning_rate=8e-5, clip_coef=0.27, clip_vloss=True, shared_torso=True, hidden_size=512
        )


@dataclass(frozen=True)
class CloningConfig(Checked):
    """Settings of behaviour cloning."""

    epochs: int = setting(50, "passes over the demonstrations at most", ">=1", most=1_000_000)
    patience: int = setting(
        5, "stop after so many epochs without a smaller loss on held-out episodes", ">=1", most=1_000_000
    )
    validation: float = setting(0.1, "share of the episodes that are held out", "0-1")
    batch_size: int = setting(256, "steps of a minibatch", ">=1", most=1_000_000)
    learning_rate: float = setting(1e-3, "step size of Adam", ">0", most=10)
    class_weights: Literal["none", "sqrt", "balanced"] = setting(
        "none", "weight of an action: none, or by the inverse of how often it was done, or the root of that"
    )
    value_coef: float = setting(0.5, "weight of the value loss; 0: the critic stays as it is", ">=0", most=1e6)
    gamma: float = setting(0.995, "discount per step of the returns that the critic learns", "0-1")
    max_grad_norm: float = setting(0.5, "the gradient is scaled down to this norm", ">0", most=1e12)


@dataclass(frozen=True)
class FineTuningConfig(Checked):
    """Settings of a training that begins with a student."""

    kl_to_clone: float = setting(
        0.0,
        "weight of the divergence from the policy that training began with, at first; it fades to 0",
        ">=0",
        most=1e6,
    )
    kl_share: float = setting(0.5, "share of the training over which that weight falls to 0", "0-1")


@dataclass(frozen=True)
class DRConfig(Checked):
    """Settings of domain randomisation."""

    resample_level_every: Literal["episode", "rollout"] = setting(
        "episode", "each environment draws a new level every: episode, or rollout"
    )


@dataclass(frozen=True)
class AdversaryConfig(Checked):
    """Settings of the adversary and its learning."""

    learning_rate: float = setting(1e-2, "step size of Adam", ">0", most=10)
    ent_coef: float = setting(
        0.03,
        "weight of the entropy of theta (nats, relative to what the program draws) against normalized regret",
        ">=0",
        most=1e6,
    )
    update_epochs: int = setting(8, "gradient steps for each batch of levels", ">=1", most=10_000)
    clip_coef: float = setting(0.2, "how far the ratio of new to old density may move from 1", ">0", most=1e6)
    vf_coef: float = setting(0.5, "weight of the baseline's loss", ">=0", most=1e6)
    max_grad_norm: float = setting(0.5, "the gradient is scaled down to this norm", ">0", most=1e12)
    adam_eps: float = setting(1e-5, "Adam's epsilon", ">0", most=1)
    distribution: Literal["program", "tanh_gaussian", "beta"] = setting(
        "program",
        "of theta: program begins as what the program draws, choices at their weights, and takes any shape; "
        "tanh_gaussian (the thesis) and beta have one hump for each column, which seldom finds options amid a list",
    )
    context: Literal["random", "observation"] = setting(
        "random", "what each proposal starts from: a random vector z, or what a student sees of a random level"
    )
    context_size: int = setting(
        1, "length of z: a long one teaches slowly, for each z looks like a case of its own", ">=1", most=16_384
    )
    hidden_size: int = setting(64, "units in each of the two hidden layers", ">=1", most=16_384)
    min_batch: int | None = setting(
        None,
        "levels with known regret that the adversary waits for before it learns (default 32; at least 4 once a tenth "
        "of total_env_steps has passed since it last learned; without a budget, one level per environment, at most 32)",
        ">=1",
        most=1_000_000,
    )

    @classmethod
    def thesis(cls) -> AdversaryConfig:
        """Return the settings of the thesis (Table 4.2, Fig. 4.10).

        Its adversary sees an image; ours starts from a random vector, as PAIRED's does, and has no convolutions.
        """
        return cls(
            learning_rate=8e-5,
            ent_coef=0.01,
            update_epochs=5,
            clip_coef=0.27,
            max_grad_norm=0.5,
            context_size=16,
            hidden_size=512,
            distribution="tanh_gaussian",
        )


@dataclass(frozen=True)
class TeacherConfig(Checked):
    """Settings of every method with a learned teacher."""

    episodes_per_level: int = setting(2, "whole episodes that each student plays on a level", ">=1", most=10_000)
    dr_fraction: float = setting(
        0.0, "share of levels drawn at random instead, so that easy ones are not forgotten", "0-1"
    )
    invalid_penalty: float = setting(
        0.0,
        "score of a proposal that describes no valid level, negated; 0: the adversary does not learn from it",
        ">=0",
        most=1e6,
    )
    adversary: AdversaryConfig = field(default_factory=AdversaryConfig, metadata={"help": "the adversary"})


@dataclass(frozen=True)
class MinimaxConfig(TeacherConfig):
    """Settings of the minimax adversary."""


@dataclass(frozen=True)
class SelfRegretConfig(TeacherConfig):
    """Settings of self-regret: on a level, the student plays `episodes_per_level` episodes as each of the two."""

    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "the later episodes' max or mean minus the earlier ones' mean: max_mean or mean_mean"
    )


@dataclass(frozen=True)
class PairedConfig(TeacherConfig):
    """Settings of PAIRED."""

    dr_fraction: float = setting(
        0.25, "share of levels drawn at random instead, so that easy ones are not forgotten", "0-1"
    )
    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "antagonist's max or mean minus protagonist's mean: max_mean or mean_mean"
    )
    roles: Literal["population", "flexible", "dennis2020"] = setting(
        "population",
        "whose regret: population (the default) is the best student's return minus the mean of all students'; flexible "
        "the better student's minus the other's; dennis2020, as in the paper, the antagonist's minus the protagonist's "
        "(always so where the antagonist is scripted)",
    )
    students: int = setting(2, "how many; more than two make a population without an antagonist", most=64, least=2)
    clip_regret: bool = setting(False, "count a negative regret as 0")
    antagonist: Literal["student", "scripted"] = setting(
        "student", "who plays the antagonist: a second student, or what the environment itself does there"
    )
    kl: Literal["none", "one_way", "both_ways"] = setting(
        "none",
        "behavior cloning: the protagonist is drawn to the antagonist (one_way), or each to the other (both_ways)",
    )
    kl_coef: float = setting(0.1, "weight of the divergence of the other student's policy", ">=0", most=1e6)
    kl_every: int = setting(5, "updates between two in which students are drawn to each other", ">=1", most=10**9)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.students < 2:
            raise ValueError(f"students must be at least 2, got {self.students}")
        if self.students > 2 and (self.antagonist == "scripted" or self.roles != "population"):
            raise ValueError(
                "more than two students have no antagonist: roles must be population, and none is scripted"
            )
        if self.antagonist == "scripted" and self.kl != "none":
            raise ValueError("a scripted antagonist does not learn: it excludes kl")

    @classmethod
    def thesis(cls) -> PairedConfig:
        """Return the settings of the thesis (Table 4.2)."""
        return cls(roles="dennis2020", dr_fraction=0.0, adversary=AdversaryConfig.thesis())


@dataclass(frozen=True)
class PairedLiteralConfig(TeacherConfig):
    """Settings of PAIRED to the letter, as it is usually shipped: no random levels, entropy or negative regret."""

    adversary: AdversaryConfig = field(
        default_factory=lambda: AdversaryConfig(learning_rate=3e-3, ent_coef=0.0, update_epochs=5, context_size=16),
        metadata={"help": "the adversary"},
    )
    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "antagonist's max or mean minus protagonist's mean: max_mean or mean_mean"
    )
    clip_regret: bool = setting(True, "count a negative regret as 0")


def min_fill() -> Any:
    """Return the field that says when replay begins."""
    return setting(
        None,
        "levels offered before anything is replayed, as a share of the buffer (default 0.5, or as many as were played "
        "when a tenth of total_env_steps is spent; without a budget, at most 4 levels per environment)",
        "0-1",
    )


@dataclass(frozen=True)
class BufferConfig(Checked):
    """Settings of a buffer of levels."""

    capacity: int = setting(1000, "levels that are kept", ">=1", most=1_000_000)
    priority: Literal["rank", "power"] = setting("rank", "replay by rank of the score, or by a power of it")
    temperature: float = setting(
        0.3, "the lower, the more the best levels are preferred: rank or score ^ (1 / T)", ">0", most=1e6
    )
    staleness_coef: float = setting(0.3, "share of replays that go to levels not played for long", "0-1")
    no_duplicates: bool = setting(True, "a level that is in the buffer already is not put in again")


ScoreRule = Literal["max_mc", "positive_value_loss", "l1_value_loss", "learnability"]


@dataclass(frozen=True)
class PLRConfig(Checked):
    """Settings of prioritised level replay, robust or not."""

    replay_prob: float = setting(0.5, "probability of a level from the buffer instead of a new one", "0-1")
    min_fill: float | None = min_fill()
    score: ScoreRule = setting(
        "max_mc",
        "what makes a level worth replaying: its best return above what the critic expects (max_mc), mean advantages "
        "above 0 (positive_value_loss) or in size (l1_value_loss), or p (1 - p), p the share solved (learnability)",
    )
    episodes_per_level: int = setting(1, "whole episodes that the student plays on a level", ">=1", most=10_000)
    buffer: BufferConfig = field(default_factory=BufferConfig, metadata={"help": "the buffer"})

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.score == "learnability" and self.episodes_per_level < 2:
            raise ValueError("the score learnability needs episodes_per_level of at least 2, got 1")


@dataclass(frozen=True)
class ACCELConfig(PLRConfig):
    """Settings of ACCEL."""

    replay_prob: float = setting(0.8, "probability of a level from the buffer instead of a new one", "0-1")
    num_edits: int = setting(
        3, "columns of theta, drawn with replacement, that are changed in a child", ">=1", most=10_000
    )
    edit_size: float = setting(0.2, "by how much at most each is moved; theta lies between -1 and 1", ">0", most=2)
    parents: Literal["all", "easy"] = setting("all", "which replayed levels have children: all, or the easier half")


@dataclass(frozen=True)
class RepairedConfig(PairedConfig):
    """Settings of REPAIRED."""

    replay_prob: float = setting(0.5, "probability of a level from the buffer instead of the adversary's", "0-1")
    min_fill: float | None = min_fill()
    buffer: BufferConfig = field(default_factory=BufferConfig, metadata={"help": "the buffer"})


@dataclass(frozen=True)
class SFLConfig(Checked):
    """Settings of sampling for learnability, on a budget."""

    candidates: int = setting(256, "random levels that are looked at for each choice", ">=1", most=1_000_000)
    candidate_episodes: int = setting(4, "whole episodes on each of them", most=10_000, least=2)
    chosen: int = setting(64, "most learnable ones that are trained on", ">=1", most=1_000_000)
    choose_every: int = setting(25, "updates between two choices", ">=1", most=10**9)
    chosen_share: float = setting(0.5, "share of training levels that are chosen ones; the others are random", "0-1")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.candidate_episodes < 2:
            raise ValueError(f"candidate_episodes must be at least 2, got {self.candidate_episodes}")
        if self.chosen > self.candidates:
            raise ValueError(f"chosen must be at most candidates ({self.candidates}), got {self.chosen}")


@dataclass(frozen=True)
class ALPGMMConfig(Checked):
    """Settings of ALP-GMM."""

    fit_every: int = setting(250, "episodes between two fits, and the number each is made of", most=1_000_000, least=2)
    random_share: float = setting(0.2, "share of levels drawn uniformly", "0-1")
    max_components: int = setting(10, "Gaussians at most; how many is decided by Akaike's criterion", ">=1", most=1_000)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.fit_every <= self.max_components:
            raise ValueError(f"fit_every must be above max_components ({self.max_components}), got {self.fit_every}")
