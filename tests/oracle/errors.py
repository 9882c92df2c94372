"""Error programs, and our one class of errors under the names of real Scenic's many.

Real Scenic tells kinds of mistakes apart by class, and raises Python's own classes for many; we have one class with a
`kind`. A record names the first class of its kind as its type and the others as its bases. Read next: `compare`.
"""

from pathlib import Path

import numpy as np

from regista.envs.toy_world import toy_world
from scenic_lite import Domain, ScenicError, load
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.toy_world import first_table, run

SYNTAX = ("ScenicParseError", "ParseCompileError", "ScenicSyntaxError", "TokenParseError", "PythonParseError")
FAULTS = ("ZeroDivisionError", "ArithmeticError", "OverflowError", "IndexError", "KeyError", "LookupError")
CLASSES = {
    "syntax": SYNTAX,
    "name": ("NameError", "AttributeError", "InvalidScenarioError", "UnboundLocalError"),
    "type": ("TypeError", "AttributeError", "AssertionError", "RuntimeParseError", "InvalidScenarioError"),
    "value": ("ValueError", *FAULTS, "AttributeError", "TypeError", "AssertionError", "InvalidScenarioError"),
    "specifier": ("SpecifierError", "RuntimeParseError", "TypeError"),
    "random-control-flow": ("RandomControlFlowError", "TypeError"),
    "rejection": ("RejectionException",),
    "budget": ("RecursionError", "MemoryError", "OverflowError", "ValueError"),
    "import": ("ModuleNotFoundError", "ImportError", "InvalidScenarioError"),
    "unsupported": ("InvalidScenarioError", "NotImplementedError", "TypeError"),
}


def error_record(error: ScenicError, stage: str) -> dict:
    """Return an error in the oracle's shape."""
    first, *others = CLASSES.get(error.kind, ("ScenicError",))
    record = {"stage": stage, "type": first, "bases": [*others, "ScenicError", "Exception"], "message": error.message}
    if error.place is not None:
        record |= {"line": error.line, "column": error.column}
    return record


def failing(path: Path, entries: dict[str, str], world: Domain, dialect: int) -> dict:
    """Return the record's fields for a program of kind `error` that fails neither to load nor to sample."""
    program = load(path, world, dialect)
    theta, _ = program.sample(1, np.random.default_rng(7))
    if entries.get("run") == "dynamic":
        try:
            run(first_table(program, theta[0]), Reference(program, theta[0], toy_world()), int(entries.get("steps", 3)))
        except ScenicError as error:
            return {"error": error_record(error, "simulate")}
    return {"no_error": True}
