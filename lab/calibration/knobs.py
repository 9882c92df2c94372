"""Turn numbers of a law into knobs, which change between two plays without compiling again.

Numba freezes the fields of a named tuple when it compiles. The import hook of `lab/football_mutants.py` replaces each
`LAW.field` in the simulator's modules by a load from an array of this module. A profile over a dozen values then costs
one compilation.

A knob is named `path.LAW.field`, such as `skills.saves.SAVE.body`, or `path.NAME`, such as
`physics.running.LAG_RUNNING`; for a tuple, `[k]` selects one number. Install knobs before football is imported, with
`NUMBA_CACHE_DIR` set to a fresh folder, so that kernels with knobs are never reused as the simulator's. Numbers
computed from others at import keep their values. Read next: `profile.py`.
"""

from __future__ import annotations

import ast
import math
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic

from lab.football_mutants import FOOTBALL, PACKAGE, Changed

MOST = 512
VALUES = np.zeros(MOST)  # loaded by kernels; its address is part of compiled code


@intrinsic
def knob(_: Any, address: Any) -> Any:
    """Return the float64 at an address."""
    from llvmlite import ir

    def load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(builder.inttoptr(arguments[0], ir.DoubleType().as_pointer()))

    return types.float64(types.uintp), load


class Knob(NamedTuple):
    """A number of a law: its module below football, its name, its field ("" for a bare name), and its index in a tuple.

    The index is -1 for a number outside of a tuple.
    """

    module: str
    name: str
    field: str
    index: int

    def __str__(self) -> str:
        words = (self.module, self.name, *([self.field] if self.field else []))
        return ".".join(words) + (f"[{self.index}]" if self.index >= 0 else "")


def parse(text: str) -> Knob:
    """Return the knob of a name. Raises ValueError for an invalid name."""
    match = re.fullmatch(r"([a-z_.]+)\.([A-Z_]+)(?:\.(\w+))?(?:\[(\d+)\])?", text)
    if match is None:
        raise ValueError(
            f"a knob is called like skills.saves.SAVE.body or physics.running.LAG_RUNNING[2], not {text!r}"
        )
    module, name, field, index = match.groups()
    return Knob(module, name, field or "", int(index) if index else -1)


def install(knobs: Sequence[Knob]) -> None:
    """Make these numbers knobs in all modules imported afterwards.

    Raises RuntimeError if football has been imported already.
    """
    late = [f"{PACKAGE}.{each.module}" for each in knobs if f"{PACKAGE}.{each.module}" in sys.modules]
    if late:
        raise RuntimeError(f"knobs must be installed before football is imported, but {late[0]} has been")
    sys.meta_path.insert(0, Changed(Turned(knobs)))


class Turned:
    """Replaces the numbers in the trees of modules, and remembers the place of each knob's value."""

    def __init__(self, knobs: Sequence[Knob]) -> None:
        self.wanted = {(each.module, each.name, each.field) for each in knobs}
        SLOTS.clear()

    def __call__(self, path: Path, tree: ast.Module) -> ast.Module:
        """Return a module's tree with loads in place of numbers."""
        known = self.names(path, tree)
        if not known:
            return tree
        for node in tree.body:
            if isinstance(node, ast.FunctionDef):
                Loads(known).visit(node)
        at = next(k for k, node in enumerate(tree.body) if isinstance(node, ast.Import | ast.ImportFrom))
        at += any(isinstance(node, ast.ImportFrom) and node.module == "__future__" for node in tree.body)
        tree.body.insert(at, ast.parse("from lab.calibration.knobs import knob as _knob").body[0])
        return tree

    def names(self, path: Path, tree: ast.Module) -> dict[str, tuple[str, str, set[str]]]:
        """Return, by name in this module: the defining module, the name in it, and the fields that are knobs."""
        here = ".".join(path.relative_to(FOOTBALL).with_suffix("").parts)
        known = {name: (here, name) for module, name, _ in self.wanted if module == here}
        for node in tree.body:
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(PACKAGE + "."):
                origin = node.module.removeprefix(PACKAGE + ".")
                known |= {alias.asname or alias.name: (origin, alias.name) for alias in node.names}
        turned = {
            name: (*source, {field for module, what, field in self.wanted if (module, what) == source})
            for name, source in known.items()
        }
        return {name: entry for name, entry in turned.items() if entry[2]}


class Loads(ast.NodeTransformer):
    """Replaces `LAW.field` and bare names by loads in a function."""

    def __init__(self, known: dict[str, tuple[str, str, set[str]]]) -> None:
        self.known = known

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """Replace a field of a law."""
        if isinstance(node.value, ast.Name) and node.attr in self.known.get(node.value.id, ("", "", ()))[2]:
            module, name, _ = self.known[node.value.id]
            return loads(module, name, node.attr)
        self.generic_visit(node)
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        """Replace a bare number, or a tuple of numbers."""
        if "" in self.known.get(node.id, ("", "", ()))[2]:
            module, name, _ = self.known[node.id]
            return loads(module, name, "")
        return node


SLOTS: dict[tuple[str, str, str], tuple[int, int]] = {}  # first slot and count; 0: a single number, not a tuple


def loads(module: str, name: str, field: str) -> ast.expr:
    """Return an expression that loads a number, or a whole tuple."""
    first, count = slots(module, name, field)
    addresses = [VALUES.ctypes.data + 8 * (first + k) for k in range(max(count, 1))]
    calls = [f"_knob({address})" for address in addresses]
    return ast.parse(calls[0] if count == 0 else f"({', '.join(calls)},)", mode="eval").body


def slots(module: str, name: str, field: str) -> tuple[int, int]:
    """Return the slots of a number in `VALUES`; a new number gets slots with its value in the source."""
    if (module, name, field) not in SLOTS:
        first = sum(max(count, 1) for _, count in SLOTS.values())
        SLOTS[module, name, field] = first, 0
        value = in_source(module, name, field)
        SLOTS[module, name, field] = first, len(value) if isinstance(value, tuple) else 0
        VALUES[first : first + max(SLOTS[module, name, field][1], 1)] = value
    return SLOTS[module, name, field]


def in_source(module: str, name: str, field: str) -> Any:
    """Return the shipped value of a number. Raises ValueError if no number has this name."""
    path = FOOTBALL / Path(*module.split(".")).with_suffix(".py")
    tree = ast.parse(path.read_text())
    made = name if not field else law_class(tree, name)
    for node in ast.walk(tree):
        if not field and isinstance(node, ast.Assign) and any(getattr(t, "id", "") == made for t in node.targets):
            return evaluated(node.value)
        if field and isinstance(node, ast.ClassDef) and node.name == made:
            for line in node.body:
                if isinstance(line, ast.AnnAssign) and getattr(line.target, "id", "") == field and line.value:
                    return evaluated(line.value)
    raise ValueError(f"{module} must have a number {name}{'.' + field if field else ''}; it has none")


def law_class(tree: ast.Module, name: str) -> str:
    """Return the class from which a module creates a law, "" if the module has no law of this name."""
    for node in tree.body:
        if not isinstance(node, ast.Assign):
            continue
        target, value = node.targets[0], node.value
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        values = value.elts if isinstance(value, ast.Tuple) else [value]
        for each, made in zip(names, values, strict=False):
            if getattr(each, "id", "") == name and isinstance(made, ast.Call):
                return getattr(made.func, "id", "")
    return ""


def evaluated(node: ast.AST) -> Any:
    """Return the value of numbers, tuples, products and `math.pi`. Raises ValueError for anything else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.Tuple):
        return tuple(map(evaluated, node.elts))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -evaluated(node.operand)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        return evaluated(node.left) * evaluated(node.right)
    if ast.unparse(node) == "math.pi":
        return math.pi
    raise ValueError(f"a knob must be a number, a tuple, a product or math.pi, not {ast.unparse(node)}")


def read(which: Knob) -> float:
    """Return the current value of an installed knob."""
    return float(VALUES[place(which)])


def turn(which: Knob, value: float) -> None:
    """Set an installed knob to another value."""
    VALUES[place(which)] = value


def place(which: Knob) -> int:
    """Return the index of a knob's value. Raises ValueError if the simulator does not use the knob."""
    import_module(f"{PACKAGE}.{which.module}")
    if (which.module, which.name, which.field) not in SLOTS:
        raise ValueError(f"no function of the simulator that is in use reads {which}")
    first, count = SLOTS[which.module, which.name, which.field]
    if not (0 <= which.index < count if count else which.index == -1):
        raise ValueError(f"{which} must name one of {count} numbers" if count else f"{which} is a number by itself")
    return first + max(which.index, 0)
