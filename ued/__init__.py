"""Unsupervised environment design: the seam between environments and methods, and the methods.

    from ued import DR, GymUPOMDP, Paired, PPOConfig, evaluate

Names are loaded when first used, so that `import ued` stays quick and environments need no torch.
Read next: `upomdp`, the seam; then `learning.rollout`, `learning.worker`, `learning.ppo` and `methods.dr`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers and editors; what is true when the program runs is below
    from ued.checkpoint import CheckpointError
    from ued.config import (
        ACCELConfig,
        AdversaryConfig,
        ALPGMMConfig,
        BufferConfig,
        DRConfig,
        MinimaxConfig,
        PairedConfig,
        PairedLiteralConfig,
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
    from ued.levels.record import level_record_dtype
    from ued.method import LevelBatch, Method
    from ued.methods import METHODS
    from ued.methods.accel import ACCEL
    from ued.methods.alp_gmm import ALPGMM
    from ued.methods.dr import DR
    from ued.methods.minimax import Minimax
    from ued.methods.paired import Paired
    from ued.methods.paired_literal import PairedLiteral
    from ued.methods.plr import PLR, RobustPLR
    from ued.methods.repaired import Repaired
    from ued.methods.self_regret import SelfRegret
    from ued.methods.sfl import SFL
    from ued.mixture import Mixture
    from ued.upomdp import UPOMDP, ThetaError, level_dtype

_EXPORTS = {  # by module; the methods and their settings are those of `methods.METHODS`
    "ued.checkpoint": ("CheckpointError",),
    "ued.config": ("AdversaryConfig", "BufferConfig", "PPOConfig"),
    "ued.curriculum": ("Curriculum", "ThetaSpace"),
    "ued.evaluation": ("Evaluation", "evaluate"),
    "ued.gym_upomdp": ("GymUPOMDP", "UPOMDPWrapper"),
    "ued.learning.ppo": ("PPO",),
    "ued.learning.student": ("Student",),
    "ued.levels.adversary": ("Adversary",),
    "ued.levels.buffer": ("LevelBuffer",),
    "ued.levels.record": ("level_record_dtype",),
    "ued.method": ("LevelBatch", "Method"),
    "ued.methods": ("METHODS",),
    "ued.mixture": ("Mixture",),
    "ued.upomdp": ("UPOMDP", "ThetaError", "level_dtype"),
}


def _homes() -> dict[str, str]:
    """Return the module of each name that this package offers."""
    rows = import_module("ued.methods").METHODS.values()
    homes = {name: module for module, names in _EXPORTS.items() for name in names}
    homes |= {row.class_name: row.module for row in rows}
    return homes | {row.settings.__name__: row.settings.__module__ for row in rows}


def __getattr__(name: str) -> Any:
    homes = _homes() if not name.startswith("__") or name == "__all__" else {}
    if name == "__all__":
        return sorted(homes)
    if name not in homes:
        raise AttributeError(f"module 'ued' has no attribute {name!r}")
    return getattr(import_module(homes[name]), name)


def __dir__() -> list[str]:
    return sorted(_homes())
