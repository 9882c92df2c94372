"""Unsupervised environment design: the seam between environments and methods, and the methods.

    from ued import DR, GymUPOMDP, Paired, PPOConfig, evaluate

Names are loaded when first used, so that `import ued` stays quick and environments need no torch.
Read next: `upomdp`, the seam; then `learning.rollout`, `learning.worker`, `learning.ppo` and `methods.dr`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ued.checkpoint import CheckpointError
    from ued.config import (
        ACCELConfig,
        AdversaryConfig,
        ALPGMMConfig,
        BufferConfig,
        DRConfig,
        MinimaxConfig,
        PairedConfig,
        PLRConfig,
        PPOConfig,
        RepairedConfig,
        SelfRegretConfig,
        SFLConfig,
    )
    from ued.curriculum import Curriculum, ThetaSpace
    from ued.evaluation import Evaluation, evaluate
    from ued.gym_upomdp import GymUPOMDP, UPOMDPWrapper
    from ued.learning.ppo import PPO
    from ued.learning.student import Student
    from ued.levels.adversary import Adversary
    from ued.levels.buffer import LevelBuffer
    from ued.levels.record import trial_dtype
    from ued.method import LevelBatch, Method
    from ued.methods.accel import ACCEL
    from ued.methods.alp_gmm import ALPGMM
    from ued.methods.dr import DR
    from ued.methods.minimax import Minimax
    from ued.methods.paired import Paired
    from ued.methods.plr import PLR, RobustPLR
    from ued.methods.repaired import Repaired
    from ued.methods.self_regret import SelfRegret
    from ued.methods.sfl import SFL
    from ued.mixture import Mixture
    from ued.training import Training
    from ued.upomdp import UPOMDP, ThetaError, level_dtype

_HOME = {
    "ACCEL": "ued.methods.accel",
    "ACCELConfig": "ued.config",
    "ALPGMM": "ued.methods.alp_gmm",
    "ALPGMMConfig": "ued.config",
    "Adversary": "ued.levels.adversary",
    "AdversaryConfig": "ued.config",
    "BufferConfig": "ued.config",
    "CheckpointError": "ued.checkpoint",
    "Curriculum": "ued.curriculum",
    "DR": "ued.methods.dr",
    "DRConfig": "ued.config",
    "Evaluation": "ued.evaluation",
    "GymUPOMDP": "ued.gym_upomdp",
    "LevelBatch": "ued.method",
    "LevelBuffer": "ued.levels.buffer",
    "Method": "ued.method",
    "Minimax": "ued.methods.minimax",
    "Mixture": "ued.mixture",
    "MinimaxConfig": "ued.config",
    "PLR": "ued.methods.plr",
    "PLRConfig": "ued.config",
    "PPO": "ued.learning.ppo",
    "PPOConfig": "ued.config",
    "Paired": "ued.methods.paired",
    "PairedConfig": "ued.config",
    "Repaired": "ued.methods.repaired",
    "RepairedConfig": "ued.config",
    "RobustPLR": "ued.methods.plr",
    "SFL": "ued.methods.sfl",
    "SFLConfig": "ued.config",
    "SelfRegret": "ued.methods.self_regret",
    "SelfRegretConfig": "ued.config",
    "Student": "ued.learning.student",
    "ThetaError": "ued.upomdp",
    "ThetaSpace": "ued.curriculum",
    "Training": "ued.training",
    "UPOMDP": "ued.upomdp",
    "UPOMDPWrapper": "ued.gym_upomdp",
    "evaluate": "ued.evaluation",
    "level_dtype": "ued.upomdp",
    "trial_dtype": "ued.levels.record",
}

__all__ = [
    "ACCEL",
    "ALPGMM",
    "DR",
    "PLR",
    "PPO",
    "SFL",
    "UPOMDP",
    "ACCELConfig",
    "ALPGMMConfig",
    "Adversary",
    "AdversaryConfig",
    "BufferConfig",
    "CheckpointError",
    "Curriculum",
    "DRConfig",
    "Evaluation",
    "GymUPOMDP",
    "LevelBatch",
    "LevelBuffer",
    "Method",
    "Minimax",
    "MinimaxConfig",
    "Mixture",
    "PLRConfig",
    "PPOConfig",
    "Paired",
    "PairedConfig",
    "Repaired",
    "RepairedConfig",
    "RobustPLR",
    "SFLConfig",
    "SelfRegret",
    "SelfRegretConfig",
    "Student",
    "ThetaError",
    "ThetaSpace",
    "Training",
    "UPOMDPWrapper",
    "evaluate",
    "level_dtype",
    "trial_dtype",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'ued' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
