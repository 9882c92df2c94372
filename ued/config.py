"""What can be set about learning: frozen dataclasses whose fields carry their own help text.

The command line is derived from such fields (`experiments.arguments`). No torch is needed here, so `--help` is quick.
Read next: `ppo` and `methods.dr`, which are configured by them.
"""

from __future__ import annotations

import typing
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal


def setting(default: Any, help: str) -> Any:
    """Give a dataclass field with this default and one line of help, as the command line shows it."""
    return field(default=default, metadata={"help": help})


@dataclass(frozen=True)
class PPOConfig:
    """Settings of a student and its learning, under CleanRL's names."""

    num_steps: int = setting(64, "steps of each environment between two updates")
    learning_rate: float = setting(5e-4, "step size of Adam")
    anneal_env_steps: int = setting(0, "env_steps over which the learning rate falls linearly to 0; 0: constant")
    gamma: float = setting(0.993, "discount per step")
    gae_lambda: float = setting(0.95, "lambda of generalised advantage estimation")
    num_minibatches: int = setting(8, "minibatches per epoch")
    update_epochs: int = setting(4, "passes over each rollout")
    clip_coef: float = setting(0.2, "how far the ratio of new to old probability may move from 1")
    clip_vloss: bool = setting(False, "clip the change of the value by clip_coef, too")
    norm_adv: bool = setting(True, "normalise the advantages of each minibatch")
    ent_coef: float = setting(0.01, "weight of the entropy bonus")
    vf_coef: float = setting(0.5, "weight of the value loss")
    max_grad_norm: float = setting(0.5, "the gradient is scaled down to this norm")
    target_kl: float = setting(0.0, "stop an update beyond this divergence of old and new policy; 0: never")
    adam_eps: float = setting(1e-5, "Adam's epsilon")
    hidden_size: int = setting(128, "units in each hidden layer")
    hidden_layers: int = setting(2, "hidden layers of each torso")
    shared_torso: bool = setting(False, "actor and critic share their hidden layers")

    def __post_init__(self) -> None:
        check_at_least_1(self, "num_steps", "num_minibatches", "update_epochs", "hidden_size", "hidden_layers")
        check_positive(self, "learning_rate", "clip_coef", "max_grad_norm", "adam_eps")
        check_share(self, "gamma", "gae_lambda")
        check_not_negative(self, "ent_coef", "vf_coef", "target_kl", "anneal_env_steps")

    @classmethod
    def thesis(cls) -> PPOConfig:
        """Give the settings of the thesis (Table 4.2); `PairedConfig.thesis` has the adversary's."""
        return cls(
            num_steps=128,
            learning_rate=8e-5,
            gamma=0.993,
            gae_lambda=0.95,
            num_minibatches=8,
            update_epochs=4,
            clip_coef=0.27,
            clip_vloss=True,
            ent_coef=0.01,
            vf_coef=0.5,
            max_grad_norm=0.5,
            adam_eps=1e-5,
            shared_torso=True,
        )


@dataclass(frozen=True)
class DRConfig:
    """Settings of domain randomisation."""

    new_level: Literal["episode", "rollout"] = setting(
        "episode", "each environment draws a new level every: episode, or rollout"
    )

    def __post_init__(self) -> None:
        check_choices(self, "new_level")


@dataclass(frozen=True)
class AdversaryConfig:
    """Settings of the adversary and its learning."""

    learning_rate: float = setting(3e-3, "step size of Adam")
    ent_coef: float = setting(0.1, "weight of the entropy of theta (nats, all dimensions) against normalised regret")
    update_epochs: int = setting(5, "gradient steps for each batch of levels")
    clip_coef: float = setting(0.2, "how far the ratio of new to old density may move from 1")
    vf_coef: float = setting(0.5, "weight of the baseline's loss")
    max_grad_norm: float = setting(0.5, "the gradient is scaled down to this norm")
    adam_eps: float = setting(1e-5, "Adam's epsilon")
    context_size: int = setting(16, "length of the random vector z that each proposal starts from")
    hidden_size: int = setting(64, "units in each of the two hidden layers")
    min_batch: int = setting(32, "levels with known regret that the adversary waits for before it learns")

    def __post_init__(self) -> None:
        check_at_least_1(self, "update_epochs", "context_size", "hidden_size", "min_batch")
        check_positive(self, "learning_rate", "clip_coef", "max_grad_norm", "adam_eps")
        check_not_negative(self, "ent_coef", "vf_coef")

    @classmethod
    def thesis(cls) -> AdversaryConfig:
        """Give the settings of the thesis (Table 4.2)."""
        return cls(learning_rate=8e-5, ent_coef=0.01, update_epochs=5, clip_coef=0.27, max_grad_norm=0.5)


@dataclass(frozen=True)
class PairedConfig:
    """Settings of PAIRED."""

    episodes_per_level: int = setting(2, "whole episodes that each student plays on a level")
    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "antagonist's max or mean minus protagonist's mean: max_mean or mean_mean"
    )
    flexible: bool = setting(False, "on each level the better student plays the antagonist's part")
    clip_regret: bool = setting(False, "count a negative regret as 0")
    student_reward: Literal["environment", "regret"] = setting(
        "environment", "what students learn from: the environment's rewards, or -regret and regret when an episode ends"
    )
    dr_fraction: float = setting(0.0, "share of levels drawn at random instead, so that easy ones are not forgotten")
    invalid_penalty: float = setting(
        0.0, "regret of a proposal that describes no valid level, negated; 0: the adversary does not learn from it"
    )
    adversary: AdversaryConfig = field(default_factory=AdversaryConfig, metadata={"help": "the adversary"})

    def __post_init__(self) -> None:
        check_at_least_1(self, "episodes_per_level")
        check_choices(self, "regret", "student_reward")
        check_share(self, "dr_fraction")
        check_not_negative(self, "invalid_penalty")

    @classmethod
    def thesis(cls) -> PairedConfig:
        """Give the settings of the thesis (Table 4.2)."""
        return cls(adversary=AdversaryConfig.thesis())


# ---------------------------------------------------------------- checks: `ValueError` for the first setting that fails


def check_at_least_1(config: Any, *names: str) -> None:
    """Check that these settings are 1 or more."""
    _check(config, names, lambda value: value >= 1, "must be at least 1")


def check_positive(config: Any, *names: str) -> None:
    """Check that these settings are above 0."""
    _check(config, names, lambda value: value > 0, "must be positive")


def check_not_negative(config: Any, *names: str) -> None:
    """Check that these settings are 0 or more."""
    _check(config, names, lambda value: value >= 0, "must not be negative")


def check_share(config: Any, *names: str) -> None:
    """Check that these settings lie in [0, 1]."""
    _check(config, names, lambda value: 0 <= value <= 1, "must be between 0 and 1")


def check_choices(config: Any, *names: str) -> None:
    """Check that these settings are among the values that their `Literal` annotations allow."""
    hints = typing.get_type_hints(type(config))
    for name in names:
        allowed = typing.get_args(hints[name])
        _check(config, (name,), allowed.__contains__, "must be " + " or ".join(allowed))


def _check(config: Any, names: tuple[str, ...], holds: Callable[[Any], bool], wanted: str) -> None:
    for name in names:
        value = getattr(config, name)
        if not holds(value):  # nor does any of these hold for nan
            raise ValueError(f"{name} {wanted}, got {value!r}")
