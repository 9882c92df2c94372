"""Unsupervised environment design: the seam between environments and methods, and the methods.

    from ued import DR, GymUPOMDP, Paired, PPOConfig, evaluate

Names are loaded when first used, so that `import ued` stays quick and environments need no torch.
Read next: `upomdp`, the seam; then `rollout`, `player`, `ppo` and `methods.dr`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ued.adversary import Adversary
    from ued.checkpoint import CheckpointError
    from ued.config import AdversaryConfig, DRConfig, PairedConfig, PPOConfig
    from ued.evaluation import Evaluation, evaluate
    from ued.gym_upomdp import GymUPOMDP, UPOMDPWrapper
    from ued.methods import LevelBatch, Method
    from ued.methods.dr import DR
    from ued.methods.paired import Paired
    from ued.ppo import PPO
    from ued.student import Student
    from ued.upomdp import UPOMDP, ThetaError, level_dtype

_HOME = {
    "Adversary": "ued.adversary",
    "AdversaryConfig": "ued.config",
    "CheckpointError": "ued.checkpoint",
    "DR": "ued.methods.dr",
    "DRConfig": "ued.config",
    "Evaluation": "ued.evaluation",
    "GymUPOMDP": "ued.gym_upomdp",
    "LevelBatch": "ued.methods",
    "Method": "ued.methods",
    "PPO": "ued.ppo",
    "PPOConfig": "ued.config",
    "Paired": "ued.methods.paired",
    "PairedConfig": "ued.config",
    "Student": "ued.student",
    "ThetaError": "ued.upomdp",
    "UPOMDP": "ued.upomdp",
    "UPOMDPWrapper": "ued.gym_upomdp",
    "evaluate": "ued.evaluation",
    "level_dtype": "ued.upomdp",
}

__all__ = [
    "DR",
    "PPO",
    "UPOMDP",
    "Adversary",
    "AdversaryConfig",
    "CheckpointError",
    "DRConfig",
    "Evaluation",
    "GymUPOMDP",
    "LevelBatch",
    "Method",
    "PPOConfig",
    "Paired",
    "PairedConfig",
    "Student",
    "ThetaError",
    "UPOMDPWrapper",
    "evaluate",
    "level_dtype",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'ued' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return __all__
