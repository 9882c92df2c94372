"""What loading has made and an episode may change: variables, and the contents of lists, dictionaries and sets.

Each episode has its own, so that a list that its behaviors add to begins every episode as the program wrote it. Read
next: `dynamics.reference.episode`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from scenic_lite.core.types import Definition, Instance, Namespace, parts_of
from scenic_lite.scene.program import Program
from scenic_lite.values.graph import Value


class ProgramState:
    """The containers of one program as one episode has them."""

    def __init__(self, program: Program) -> None:
        mutable = {id(container): container for container in (*variables(program), *containers(program))}
        self._own = [(container, container.copy()) for container in mutable.values()]

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Inside, every container has the contents that it has in this episode."""
        loaded = [container.copy() for container, _ in self._own]
        for container, own in self._own:
            fill(container, own)
        try:
            yield
        finally:
            self._own = [(container, container.copy()) for container, _ in self._own]
            for (container, _), contents in zip(self._own, loaded, strict=True):
                fill(container, contents)


def fill(container: Any, contents: Any) -> None:
    container.clear()
    if isinstance(container, list):
        container.extend(contents)
    else:
        container.update(contents)


def variables(program: Program) -> list[dict[str, Value]]:
    """Return the names that an episode may assign: those of the main scenario, and of modules by `global`."""
    modules = {id(each.scope.module_names): each.scope.module_names for each in program.behaviors.values()}
    assigned = [names for names in modules.values() if any(assigns_globals(value) for value in names.values())]
    return assigned if program.main_frame is None else [*assigned, program.main_frame.locals]


def assigns_globals(value: Value) -> bool:
    return isinstance(value, Definition) and any(has_global(tree) for tree in value.trees())


@lru_cache(maxsize=4096)  # the trees of a library are the same for every program
def has_global(tree: ast.AST) -> bool:
    return any(isinstance(each, ast.Global) for each in ast.walk(tree))


def containers(program: Program) -> list[Any]:
    """Return the lists, dictionaries and sets that behaviors, monitors and conditions can reach."""
    pending: list[Value] = [*program.read_in_episodes, *program.instances, program.mode.state.params]
    if program.main_frame is not None:
        pending += program.main_frame.locals.values()
    mutable: list[Any] = []
    seen: set[int] = set()
    while pending:
        value = pending.pop()
        parts = parts_within(value)
        if parts and id(value) not in seen:
            pending += parts
        if isinstance(value, list | dict | set) and id(value) not in seen:
            mutable.append(value)
        seen.add(id(value))
    return mutable


def parts_within(value: Value) -> tuple[Value, ...]:
    """Return what can be reached through a value."""
    if isinstance(value, Instance):
        return (*value.properties.values(), *value.attributes.values())
    return tuple(value.names.values()) if isinstance(value, Namespace) else parts_of(value)
