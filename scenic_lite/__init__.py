"""A compact interpreter of Scenic: programs that describe distributions of scenes, evaluated for N samples at once.

`load` reads a program; `Program` maps θ in [-1, 1]^D to scenes; `dynamics` plays what happens in them. The language itself
is described in README.md. Read next: `evaluate`, `frame`, `graph`, `program`; then `dynamics.reference`.
"""

from scenic_lite.domain import Domain
from scenic_lite.errors import Place, ScenicError
from scenic_lite.evaluate import load
from scenic_lite.program import Draw, Program
from scenic_lite.rejection import RejectionReport
from scenic_lite.rules import Rule
from scenic_lite.scenes import ObjectInfo, Scenes

__all__ = [
    "Domain",
    "Draw",
    "ObjectInfo",
    "Place",
    "Program",
    "RejectionReport",
    "Rule",
    "Scenes",
    "ScenicError",
    "load",
]
