"""Hyperparameters: frozen dataclasses whose fields carry their own help text.

`settings` defines how fields are declared; this module re-exports its public names. Read next: `learning.ppo` and
`methods.dr`, which use these settings.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from ued.lesson_config import LessonsConfig as LessonsConfig
from ued.settings import LARGEST_SEED as LARGEST_SEED
from ued.settings import Checked as Checked
from ued.settings import bounds_of as bounds_of
from ued.settings import complaint as complaint
from ued.settings import hints_of as hints_of
from ued.settings import most_threads as most_threads
from ued.settings import named as named
from ued.settings import own_names as own_names
from ued.settings import setting as setting
from ued.student_config import CloningConfig as CloningConfig
from ued.student_config import FineTuningConfig as FineTuningConfig
from ued.student_config import PPOConfig as PPOConfig


@dataclass(frozen=True)
class DRConfig(Checked):
    """Settings of domain randomization."""

    resample_level_every: Literal["episode", "rollout"] = setting(
        "episode", "how often each environment samples a new level: every episode, or once per rollout"
    )


@dataclass(frozen=True)
class BuilderConfig(Checked):
    """Settings of PPO for an adversary that builds levels step by step."""

    learning_rate: float = setting(1e-3, "step size of Adam", ">0", most=10)
    ent_coef: float = setting(
        0.01, "weight of the entropy of each step's action (in nats); the regret is normalized", ">=0", most=1e6
    )
    gamma: float = setting(0.995, "discount per step", "0-1")
    gae_lambda: float = setting(0.95, "lambda of generalized advantage estimation", "0-1")
    num_minibatches: int = setting(1, "minibatches per epoch", ">=1", most=65_536)
    update_epochs: int = setting(5, "passes over each batch of levels", ">=1", most=10_000)
    memory: Literal["none", "gru"] = setting(
        "none", "memory within a level: none, since the level so far is observed, or a GRU"
    )


@dataclass(frozen=True)
class AdversaryConfig(Checked):
    """Settings of the adversary and its learning.

    An adversary that builds levels step by step uses the settings in `steps`, and of the other fields only `clip_coef`,
    `vf_coef`, `max_grad_norm`, `adam_eps`, `context_size`, `hidden_size` and `min_batch`.
    """

    learning_rate: float = setting(1e-2, "step size of Adam", ">0", most=10)
    ent_coef: float = setting(
        0.03,
        "weight of the entropy of theta (in nats, relative to random levels); the regret is normalized",
        ">=0",
        most=1e6,
    )
    update_epochs: int = setting(8, "gradient steps per batch of levels", ">=1", most=10_000)
    clip_coef: float = setting(0.2, "clipping range of the ratio of new to old density around 1", ">0", most=1e6)
    vf_coef: float = setting(0.5, "weight of the baseline's loss", ">=0", most=1e6)
    max_grad_norm: float = setting(0.5, "clip the gradient to this norm", ">0", most=1e12)
    adam_eps: float = setting(1e-5, "Adam's epsilon", ">0", most=1)
    distribution: Literal["program", "tanh_gaussian", "beta"] = setting(
        "program",
        "distribution of theta: program starts as the program's own distribution and can take any shape; "
        "tanh_gaussian (the thesis) and beta are unimodal per column and seldom find options in the middle of a list",
    )
    context: Literal["random", "observation"] = setting(
        "random", "input of the adversary: a random vector z, or the first observation of a random level"
    )
    context_size: int = setting(1, "dimension of the latent z; large values learn slowly", ">=1", most=16_384)
    hidden_size: int = setting(64, "units in each of the two hidden layers", ">=1", most=16_384)
    min_batch: int | None = setting(
        None,
        "minimum number of scored levels in an update of the adversary (default 32; 4 once a tenth of total_env_steps "
        "has passed since its last update; without a budget, one level per environment, at most 32)",
        ">=1",
        most=1_000_000,
    )

    builder: Literal["auto", "direct", "steps"] = setting(
        "auto",
        "how the adversary makes a level: direct, all of theta at once; steps, step by step, for a level family with a "
        "builder; auto, in steps where that is possible",
    )
    steps: BuilderConfig = field(
        default_factory=BuilderConfig, metadata={"help": "an adversary that builds levels step by step"}
    )

    @classmethod
    def thesis(cls) -> AdversaryConfig:
        """Return the settings of the thesis (Table 4.2, Fig. 4.10).

        The adversary of the thesis observes an image. This one takes a random vector, as in PAIRED, and has no
        convolutions.
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

    episodes_per_level: int = setting(2, "episodes of each student on a level", ">=1", most=10_000)
    dr_fraction: float = setting(0.0, "share of random levels, so that students do not forget easy ones", "0-1")
    invalid_penalty: float = setting(
        0.0,
        "penalty for an invalid proposal; 0: the adversary ignores invalid proposals",
        ">=0",
        most=1e6,
    )
    adversary: AdversaryConfig = field(default_factory=AdversaryConfig, metadata={"help": "the adversary"})


@dataclass(frozen=True)
class MinimaxConfig(TeacherConfig):
    """Settings of the minimax adversary."""


@dataclass(frozen=True)
class SelfRegretConfig(TeacherConfig):
    """Settings of self-regret. The student plays 2 × `episodes_per_level` episodes on each level."""

    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "maximum (max_mean) or mean (mean_mean) of the later episodes, minus the mean of the earlier ones"
    )


@dataclass(frozen=True)
class PairedConfig(TeacherConfig):
    """Settings of PAIRED."""

    dr_fraction: float = setting(0.25, "share of random levels, so that students do not forget easy ones", "0-1")
    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "maximum (max_mean) or mean (mean_mean) return of the antagonist, minus the protagonist's mean"
    )
    roles: Literal["population", "flexible", "dennis2020"] = setting(
        "population",
        "definition of regret: population (default), the best student's return minus the mean of all students; "
        "flexible, the better student's minus the other's; dennis2020, as in the paper, the antagonist's minus the "
        "protagonist's (the only one with a scripted antagonist)",
    )
    students: int = setting(
        2, "number of students; more than two are a population without an antagonist", most=64, least=2
    )
    clip_regret: bool = setting(False, "count a negative regret as 0")
    antagonist: Literal["student", "scripted"] = setting(
        "student", "the antagonist: a second student, or the scripted policy of the environment"
    )
    kl: Literal["none", "one_way", "both_ways"] = setting(
        "none",
        "KL regularizer (behavior cloning): of the protagonist to the antagonist (one_way), or of each to the other",
    )
    kl_coef: float = setting(0.1, "weight of the KL divergence from the other student's policy", ">=0", most=1e6)
    kl_every: int = setting(5, "apply the KL regularizer every N updates", ">=1", most=10**9)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.students < 2:
            raise ValueError(f"students must be at least 2, got {self.students}")
        if self.students > 2 and (self.antagonist == "scripted" or self.roles != "population"):
            raise ValueError(
                "more than two students have no antagonist: use roles='population' and antagonist='student' (flags "
                "--paired.roles population --paired.antagonist student, or those of repaired)"
            )
        if self.antagonist == "scripted" and self.kl != "none":
            raise ValueError(
                "a scripted antagonist cannot be regularized: use kl='none' (--paired.kl none or --repaired.kl none)"
            )

    @classmethod
    def thesis(cls) -> PairedConfig:
        """Return the settings of the thesis (Table 4.2)."""
        return cls(roles="dennis2020", dr_fraction=0.0, adversary=AdversaryConfig.thesis())


@dataclass(frozen=True)
class PairedLiteralConfig(TeacherConfig):
    """Settings of literal PAIRED, as usually published: no random levels, no entropy bonus, no negative regret."""

    adversary: AdversaryConfig = field(
        default_factory=lambda: AdversaryConfig(learning_rate=3e-3, ent_coef=0.0, update_epochs=5, context_size=16),
        metadata={"help": "the adversary"},
    )
    regret: Literal["max_mean", "mean_mean"] = setting(
        "max_mean", "maximum (max_mean) or mean (mean_mean) return of the antagonist, minus the protagonist's mean"
    )
    clip_regret: bool = setting(True, "count a negative regret as 0")


def min_fill() -> Any:
    """Return the settings field that determines the start of replay."""
    return setting(
        None,
        "replay starts after this many scored levels, as a share of the buffer (default 0.5, or sooner: after a tenth "
        "of total_env_steps, or without a budget after 4 levels per environment)",
        "0-1",
    )


@dataclass(frozen=True)
class BufferConfig(Checked):
    """Settings of a level buffer."""

    capacity: int = setting(1000, "capacity of the buffer, in levels", ">=1", most=1_000_000)
    priority: Literal["rank", "power"] = setting(
        "rank", "replay weight: by the rank of the score, or by a power of the score"
    )
    temperature: float = setting(
        0.3,
        "temperature T of the weight (1 / rank or score) ^ (1 / T); a lower one prefers the best levels",
        ">0",
        most=1e6,
    )
    staleness_coef: float = setting(0.3, "share of the replay probability given to stale levels", "0-1")
    no_duplicates: bool = setting(True, "do not store a level that is already in the buffer")


SCORES = ("max_mc", "positive_value_loss", "l1_value_loss", "learnability", "generalized_learnability", "mna")
SCORE_HELP = (
    "score of a level: best return ever minus value (max_mc), mean positive (positive_value_loss) or absolute "
    "(l1_value_loss) advantage, p (1 - p) with success rate p (learnability), deviation of returns where their mean is "
    "usual (generalized_learnability), or sum of negative advantages if ever solved (mna)"
)


def check_episodes(score: str, episodes: int) -> None:
    """Raise `ValueError` if a score needs more episodes on each level."""
    if score in ("learnability", "generalized_learnability") and episodes < 2:
        raise ValueError(f"the score {score} needs episodes_per_level of at least 2, got {episodes}")


@dataclass(frozen=True)
class PLRConfig(Checked):
    """Settings of prioritized level replay, robust or not."""

    replay_prob: float = setting(0.5, "probability of replaying a level from the buffer", "0-1")
    min_fill: float | None = min_fill()
    score: str = named("max_mc", SCORE_HELP, SCORES, "function")
    episodes_per_level: int = setting(1, "episodes on a level", ">=1", most=10_000)
    buffer: BufferConfig = field(default_factory=BufferConfig, metadata={"help": "the buffer"})

    def __post_init__(self) -> None:
        super().__post_init__()
        check_episodes(self.score, self.episodes_per_level)


@dataclass(frozen=True)
class ACCELConfig(PLRConfig):
    """Settings of ACCEL."""

    replay_prob: float = setting(0.8, "probability of replaying a level from the buffer", "0-1")
    num_edits: int = setting(3, "edits per child: parameters to change, drawn with replacement", ">=1", most=10_000)
    edit_size: float = setting(0.2, "maximum change by an edit, on the scale [-1, 1] of theta", ">0", most=2)
    parents: Literal["all", "easy"] = setting("all", "replayed levels to edit: all, or the easier half")
    new_levels: Literal["random", "simplest"] = setting(
        "random", "new levels (not edited): random, or the simplest of a level family, such as empty mazes"
    )


@dataclass(frozen=True)
class CoverageConfig(Checked):
    """Settings of the Gaussian mixture over past state-action pairs."""

    window: int = setting(2048, "number of latest state-action pairs to fit the mixture to", most=16_384, least=16)
    pairs_per_update: int = setting(64, "pairs that enter the window per update", ">=1", most=16_384)
    fit_every: int = setting(16, "updates between two fits; fewer at first", ">=1", most=10**9)
    max_components: int = setting(
        8, "maximum number of Gaussians; the silhouette score selects a power of two", most=64, least=2
    )


@dataclass(frozen=True)
class CENIEConfig(ACCELConfig):
    """Settings of CENIE."""

    base: Literal["accel", "plr"] = setting(
        "accel", "edit replayed levels (accel: ACCEL-CENIE), or not (plr: PLR-CENIE, robust)"
    )
    novelty_coef: float = setting(0.5, "share of novelty in the replay priority; the rest is that of the score", "0-1")
    coverage: CoverageConfig = field(
        default_factory=CoverageConfig, metadata={"help": "the model of past state-action pairs"}
    )


@dataclass(frozen=True)
class RepairedConfig(PairedConfig):
    """Settings of REPAIRED."""

    replay_prob: float = setting(0.5, "probability of replaying a level from the buffer", "0-1")
    min_fill: float | None = min_fill()
    buffer: BufferConfig = field(default_factory=BufferConfig, metadata={"help": "the buffer"})


@dataclass(frozen=True)
class SFLConfig(Checked):
    """Settings of sampling for learnability (SFL), on a step budget."""

    candidates: int = setting(256, "random levels to evaluate for each selection", ">=1", most=1_000_000)
    candidate_episodes: int = setting(4, "episodes on each candidate", most=10_000, least=2)
    chosen: int = setting(64, "number of most learnable candidates to select", ">=1", most=1_000_000)
    choose_every: int = setting(25, "select new levels every N updates", ">=1", most=10**9)
    chosen_share: float = setting(0.5, "share of selected levels among training levels; the others are random", "0-1")
    score: str = named(
        "learnability",
        "score of a candidate: p (1 - p) with success rate p (learnability), or for returns that are not binary their "
        "deviation, where their mean is usual (generalized_learnability)",
        ("learnability", "generalized_learnability"),
        "function",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.candidate_episodes < 2:
            raise ValueError(f"candidate_episodes must be at least 2, got {self.candidate_episodes}")
        if self.chosen > self.candidates:
            raise ValueError(f"chosen must be at most candidates ({self.candidates}), got {self.chosen}")


@dataclass(frozen=True)
class NCCConfig(Checked):
    """Settings of NCC, on a step budget."""

    capacity: int = setting(256, "capacity of the buffer, in levels", ">=1", most=1_000_000)
    min_fill: float | None = min_fill()
    score: str = named("learnability", SCORE_HELP, SCORES, "function")
    episodes_per_level: int = setting(4, "episodes on a level", ">=1", most=10_000)
    candidate_share: float = setting(
        0.25, "share of random levels that are only evaluated, as candidates for the buffer", "0-1"
    )
    rescore_share: float = setting(
        0.25, "share of buffer levels that are only evaluated, starting with the oldest scores", "0-1"
    )
    learning_rate: float = setting(
        28.0, "step size of the ascent of the level distribution, relative to 1 / capacity", ">0", most=1e6
    )
    ent_coef: float = setting(0.032, "weight of the entropy of the level distribution (in nats)", ">=0", most=1e6)
    floor: float = setting(0.04, "share of the probability that is uniform over the levels of the buffer", "0-1")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_episodes(self.score, self.episodes_per_level)
        if self.candidate_share + self.rescore_share >= 1:
            shares = self.candidate_share, self.rescore_share
            raise ValueError(f"candidate_share and rescore_share must be less than 1 together, got {shares}")


@dataclass(frozen=True)
class ALPGMMConfig(Checked):
    """Settings of ALP-GMM."""

    fit_every: int = setting(250, "refit every N episodes, on the latest N episodes", most=1_000_000, least=2)
    random_share: float = setting(0.2, "share of random levels", "0-1")
    max_components: int = setting(
        10, "maximum number of Gaussians; Akaike's criterion selects how many", ">=1", most=1_000
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.fit_every <= self.max_components:
            raise ValueError(f"fit_every must be above max_components ({self.max_components}), got {self.fit_every}")
