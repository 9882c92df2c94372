"""Unsupervised environment design: the interface between environments and methods, and the methods.

    from ued import DR, GymUPOMDP, Paired, PPOConfig, evaluate

Names are loaded on first use, so `import ued` is fast and environments need no torch. Editors and type checkers find
the names in `__init__.pyi`.
Read next: `core.upomdp`, the interface; then `learning.rollout`, `learning.worker`, `learning.ppo` and `methods.dr`.
"""

import os
import sys
from importlib import import_module
from typing import Any

# Torch and Numba each have an OpenMP pool whose idle threads spin. The two pools compete for the cores, which is ten
# times slower. The variable must be set before torch starts its pool: import torch after `ued`, or set it yourself.
if "torch" not in sys.modules:
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")

_EXPORTS = {  # by module; the methods and their settings come from `methods.METHODS`
    "ued.core.checkpoint": ("CheckpointError",),
    "ued.config": ("AdversaryConfig", "BufferConfig", "BuilderConfig", "PPOConfig"),
    "ued.core.curriculum": ("Curriculum", "ThetaSpace"),
    "ued.evaluation": ("Evaluation", "evaluate"),
    "ued.adapters.gym": ("GymUPOMDP", "UPOMDPWrapper"),
    "ued.learning.ppo": ("PPO",),
    "ued.learning.student": ("Student",),
    "ued.levels.adversary": ("Adversary",),
    "ued.levels.builder": ("Builder",),
    "ued.levels.buffer": ("LevelBuffer",),
    "ued.levels.record": ("level_record_dtype",),
    "ued.levels.batch": ("LevelBatch",),
    "ued.levels.table": ("read_level", "read_levels"),
    "ued.methods.method": ("Method",),
    "ued.methods": ("METHODS",),
    "ued.adapters.mixture": ("Mixture",),
    "ued.adapters.vector": ("VectorUPOMDP",),
    "ued.core.parameters": ("Choice", "Integer", "LogRange", "Range", "Seeds"),
    "ued.core.families": ("LevelBuilder", "LevelFamily"),
    "ued.adapters.policy": ("load_policy",),
    "ued.core.task": ("Task",),
    "ued.core.level_space": ("LevelError", "ThetaError", "level_dtype", "luck_seed"),
    "ued.core.upomdp": ("UPOMDP",),
}


def _homes() -> dict[str, str]:
    """Return the module of each public name of this package."""
    rows = import_module("ued.methods").METHODS.values()
    homes = {name: module for module, names in _EXPORTS.items() for name in names}
    homes |= {row.class_name: row.module for row in rows}
    return homes | {row.settings.__name__: row.settings.__module__ for row in rows}


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return __dir__()
    homes = {} if name.startswith("__") else _homes()
    if name not in homes:
        raise AttributeError(f"module 'ued' has no attribute {name!r}")
    return getattr(import_module(homes[name]), name)


def __dir__() -> list[str]:
    return sorted(_homes())
