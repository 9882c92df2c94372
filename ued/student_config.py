"""Settings of students: PPO, behavior cloning and fine-tuning. No torch is needed.

Read next: `config`, the settings of methods; `learning.ppo`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ued.settings import Checked, named, setting


@dataclass(frozen=True)
class PPOConfig(Checked):
    """Settings of a student and its learning, under CleanRL's names."""

    num_steps: int = setting(64, "steps of each environment between two updates", ">=1", most=65_536)
    learning_rate: float = setting(5e-4, "step size of Adam", ">0", most=10)
    anneal_env_steps: int = setting(
        0, "env_steps over which the learning rate falls linearly to 0; 0: constant", ">=0", most=10**12
    )
    gamma: float = setting(0.993, "discount per step", "0-1")
    gae_lambda: float = setting(0.95, "lambda of generalized advantage estimation", "0-1")
    num_minibatches: int = setting(8, "minibatches per epoch", ">=1", most=65_536)
    update_epochs: int = setting(4, "passes over each rollout", ">=1", most=1_000)
    clip_coef: float = setting(0.2, "clipping range of the ratio of new to old probability around 1", ">0", most=1e6)
    clip_vloss: bool = setting(False, "also clip the change of the value by clip_coef")
    norm_adv: bool = setting(True, "normalize the advantages of each minibatch")
    norm_reward: bool = setting(
        False,
        "divide rewards by the running deviation of discounted returns; tables and scores of levels stay raw",
    )
    ent_coef: float = setting(0.01, "weight of the entropy bonus", ">=0", most=1e6)
    vf_coef: float = setting(0.5, "weight of the value loss", ">=0", most=1e6)
    max_grad_norm: float = setting(0.5, "clip the gradient to this norm", ">0", most=1e12)
    target_kl: float = setting(0.0, "stop an update once the KL divergence exceeds this; 0: never", ">=0", most=1e6)
    adam_eps: float = setting(1e-5, "Adam's epsilon", ">0", most=1)
    hidden_size: int = setting(128, "units in each hidden layer", ">=1", most=16_384)
    network: str = named(
        "auto",
        "first layers: convolutions for images (auto), also for images inside vectors, as in mazes (cnn), or none "
        "(mlp)",
        ("auto", "mlp", "cnn"),
        "class",
    )
    hidden_layers: int = setting(
        2, "hidden layers of each torso; 1 if the observation is a single image", ">=0", most=64
    )
    head_size: int = setting(0, "units of a hidden layer before the policy and the value; 0: none", ">=0", most=16_384)
    shared_torso: bool = setting(False, "share the hidden layers of actor and critic")
    memory: Literal["none", "gru"] = setting("none", "memory within an episode: none, or a GRU after the hidden layers")
    bptt_steps: int = setting(
        0, "steps of truncated backpropagation; a divisor of num_steps, 0: all", ">=0", most=65_536
    )
    team: Literal["independent", "shared"] = setting(
        "independent", "policies of several agents: one each, or a shared one that observes the index of the agent"
    )
    critic: Literal["own", "central"] = setting(
        "own", "critic of several agents: one each, or a central one on all observations (MAPPO)"
    )
    obs_std_floor: float = setting(
        0.1,
        "divide each observation by its standard deviation, but at least by this multiple of the scale that the "
        "environment specifies",
        ">=0",
        most=1e6,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.bptt_steps and self.num_steps % self.bptt_steps:
            raise ValueError(f"bptt_steps must divide num_steps, {self.num_steps}, got {self.bptt_steps}; 0: all")

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
    """Settings of behavior cloning."""

    epochs: int = setting(50, "maximum number of passes over the demonstrations", ">=1", most=1_000_000)
    patience: int = setting(
        5, "stop after this many epochs without a smaller loss on held-out episodes", ">=1", most=1_000_000
    )
    validation: float = setting(0.1, "share of the episodes held out for validation", "0-1")
    batch_size: int = setting(256, "steps in a minibatch", ">=1", most=1_000_000)
    learning_rate: float = setting(1e-3, "step size of Adam", ">0", most=10)
    class_weights: Literal["none", "sqrt", "balanced"] = setting(
        "none", "weight of an action in the loss: 1 (none), inverse frequency (balanced), or its root (sqrt)"
    )
    value_coef: float = setting(0.5, "weight of the value loss; 0: the critic is not trained", ">=0", most=1e6)
    gamma: float = setting(0.995, "discount per step of the critic's target returns", "0-1")
    max_grad_norm: float = setting(0.5, "clip the gradient to this norm", ">0", most=1e12)


@dataclass(frozen=True)
class FineTuningConfig(Checked):
    """Settings of a training run that starts from a trained student."""

    kl_to_clone: float = setting(
        0.0, "weight of the KL divergence from the initial policy, annealed to 0", ">=0", most=1e6
    )
    kl_share: float = setting(0.5, "share of the training over which that weight is annealed to 0", "0-1")
