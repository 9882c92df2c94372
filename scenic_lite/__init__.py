"""A two-dimensional Scenic for batches of scenes: a program describes a distribution of scenes, evaluated N at a time.

`load` reads a program; `Program` maps θ in [-1, 1]^D to scenes; `dynamics` runs behaviors in them. README.md is the
manual of the language. The packages, from the ground up:

    syntax      text → tokens → checked tree
    values      random expressions as graphs, and geometry in the plane
    core        scopes, types, budget: the basis of all other packages
    language    the chapters of the manual: classes, distributions, specifiers, operators, requirements, regions
    evaluation  one walk over the tree, for both fixed and random values
    scene       θ → scenes, and scenes → θ
    dynamics    behaviors and monitors: the compiler and the virtual machine

Read next: `loader`, `values.graph`, `scene.program`; then `tests/reference/interpreter.py`.
"""

from scenic_lite.core.world import Domain
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.loader import load
from scenic_lite.scene.constraints import Constraint, RejectionReport
from scenic_lite.scene.naming import Draw
from scenic_lite.scene.program import Program
from scenic_lite.scene.scenes import ObjectInfo, Scenes

__all__ = [
    "Constraint",
    "Domain",
    "Draw",
    "ObjectInfo",
    "Program",
    "RejectionReport",
    "Scenes",
    "ScenicError",
    "SourceSpan",
    "load",
]
