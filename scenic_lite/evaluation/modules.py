"""Imports: the domain's library, `math` and `random`, and `.scenic` files beside the program.

The importer never uses Python's own import. Read next: `scene.program`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import LoadState, Mode
from scenic_lite.core.types import Namespace, Source, describe_kind, near
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.evaluation.functions import MODULES
from scenic_lite.syntax import nodes
from scenic_lite.syntax.check import check
from scenic_lite.syntax.lexer import unified
from scenic_lite.syntax.parser import parse

LARGEST_FILE = 200_000  # bytes or characters; parsing them takes about two seconds
LONGEST_NAME = 200  # maximum number of characters of a path in messages


@lru_cache(maxsize=64)
def parsed(text: str, file: str, dialect: int) -> tuple[ast.Module, tuple[ScenicError, ...]]:
    """Return the checked tree of a text and its warnings. Raises one ScenicError that holds all errors in the text.

    Results are cached, since all programs share the library files.
    """
    if len(text) > LARGEST_FILE:
        raise ScenicError(
            "budget", f"the program is longer than {LARGEST_FILE:,} characters", SourceSpan(file, 1, 0, 1, 1)
        )
    tree = parse(text, file, dialect)
    findings = check(tree, text, file, dialect)
    errors = [finding for finding in findings if finding.kind != "warning"]
    if errors:
        errors[0].also = tuple(errors[1:])
        raise errors[0]
    return tree, tuple(findings)


def read(path: Path) -> str:
    """Return the text of a program file. Raises ScenicError if the file is not readable text."""
    shown = str(path) if len(str(path)) <= LONGEST_NAME else f"{str(path)[:LONGEST_NAME]}..."
    try:
        if path.is_dir():
            raise ScenicError("import", f"{shown} is a folder, not a program")
        if not path.is_file():  # reading a pipe or a device may never end
            raise ScenicError("import", f"there is no file {shown}")
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as fault:
        reason = (fault.strerror if isinstance(fault, OSError) else None) or fault
        raise ScenicError("import", f"{shown} cannot be read: {reason}") from None
    if len(data) > LARGEST_FILE:
        raise ScenicError("budget", f"{shown} is larger than {LARGEST_FILE:,} bytes")
    try:
        return data.decode()
    except UnicodeDecodeError as fault:
        line = data.count(b"\n", 0, fault.start) + 1
        raise ScenicError("syntax", f"{shown} is not UTF-8 text: see line {line}") from None


def run_file(mode: Mode, text: str, source: Source) -> dict[str, Any]:
    """Evaluate one file and return its names, including those of the domain's default model."""
    state = mode.state
    state.sources[source.file] = source
    scope = Scope(mode, source, {})
    tree, diagnostics = parsed(text, source.file, state.dialect)
    if not source.library:
        state.diagnostics += diagnostics
        model = unnamed_model(state, tree)
        if model is not None:
            take_model(scope, model, tree)
    scope.run(tree.body)
    return scope.locals


def unnamed_model(state: LoadState, tree: ast.Module) -> str | None:
    """Return the world model of a file without a `model` line: the caller's, or the domain's default."""
    library = state.domain.library if state.domain else {}
    model = (state.domain.default_model or None) if state.domain else None
    if state.model is not None:
        library, model = {}, None if state.importing else state.model
    if model is None:
        return None
    statements = list(ast.walk(tree))
    names = [node.module for node in statements if isinstance(node, ast.ImportFrom)]
    names += [alias.name for node in statements if isinstance(node, ast.Import) for alias in node.names]
    own = any(isinstance(node, nodes.Model) for node in statements) or any(name in library for name in names)
    return None if own else model


def take_model(scope: Scope, name: str, node: ast.AST) -> None:
    """Import all names of a world model; its params never replace existing params."""
    try:
        take_all(scope, import_module(Scope.at(replace(scope.mode, in_model=True), scope), name))
    except ScenicError as error:
        raise scope.placed(error, node) from None


def source_of(text: str, file: str, folder: Path | None, library: bool = False) -> Source:
    """Return a `Source` whose line numbers match those of the lexer."""
    return Source(file, tuple(unified(text).split("\n")), folder, library)


def import_module(scope: Scope, name: str) -> Namespace:
    """Return a module, which is evaluated on its first import."""
    state = scope.state
    path, library = locate(scope, name)
    if path is None:
        return MODULES[name]
    key = str(path)
    if key in state.importing:
        raise ScenicError("import", f"{name} imports itself in a circle")
    if key in state.modules:
        return state.modules[key]
    shown = f"{state.domain.name}/{path.name}" if library and state.domain else f"{name.replace('.', '/')}.scenic"
    text = read(path)
    state.importing.append(key)
    try:
        with state.own_ego():
            names = run_file(scope.mode, text, source_of(text, shown, path.parent, library))
            state.modules[key] = Namespace(name, names, not library)
    finally:
        state.importing.pop()
    return state.modules[key]


def locate(scope: Scope, name: str) -> tuple[Path | None, bool]:
    """Return the file of a module and whether it belongs to the domain; the file is None for built-in modules.

    The search order is: the library, the built-in modules, the folder of the program, the folder of the importing file.
    """
    state = scope.state
    library = state.domain.library if state.domain else {}
    if name in library:
        return Path(library[name]), True
    if name in MODULES:
        return None, False
    folders = [scope.source.folder] if scope.source.library else [state.root, scope.source.folder]
    for folder in folders:
        file = folder.joinpath(f"{name.replace('.', '/')}.scenic") if folder else Path()
        if folder and file.is_file():
            root = folder if scope.source.library or state.root is None else state.root
            if not file.resolve().is_relative_to(root.resolve()):
                raise ScenicError("import", f"{file.name} is a link that leads out of the program's folder")
            return file, scope.source.library
    known = [*library, *MODULES, *neighbors(scope)]
    files = {str(file): module for module, file in reversed([*library.items()])}  # each file once, with its first name
    shown = [*reversed(files.values()), "math", "random", *neighbors(scope)]
    notes = [f"    modules that exist: {', '.join(shown)}"]
    raise ScenicError("import", f"there is no module '{name}'", hint=near(name, known), notes=notes)


def neighbors(scope: Scope) -> list[str]:
    """Return the names of programs in the same folder."""
    folder = scope.source.folder
    if folder is None or scope.source.library:
        return []
    return sorted(path.stem for path in folder.glob("*.scenic") if path.is_file())[:20]


def model(scope: Scope, node: nodes.Model) -> None:
    """Execute `model a.b`, or import the caller's model instead. Its params never replace existing params."""
    replacement = None if scope.source.library or scope.mode.in_model else scope.state.model
    take_model(scope, replacement or node.name, node)


def import_whole(scope: Scope, node: ast.Import) -> None:
    """Execute `import a` or `import a.b as c`."""
    for alias in node.names:
        if "." in alias.name and alias.asname is None:
            last = alias.name.rpartition(".")[2]
            hint = f"write import {alias.name} as {last}"
            raise ScenicError("unsupported", "a module in a folder is imported by a name of its own", hint=hint)
        scope.assign(alias.asname or alias.name, import_module(scope, alias.name))


def import_from(scope: Scope, node: ast.ImportFrom) -> None:
    """Execute `from a import b as c` or `from a import *`."""
    assert node.module is not None, "the parser refuses dots before the name"
    module = import_module(scope, node.module)
    for alias in node.names:
        if alias.name == "*":
            take_all(scope, module)
        elif alias.name in module.names:
            scope.assign(alias.asname or alias.name, module.names[alias.name])
        else:
            hint = near(alias.name, module.names)
            raise ScenicError("import", f"{module.name} has no '{alias.name}'", hint=hint)


def take_all(scope: Scope, module: Namespace) -> None:
    """Execute `from module import *`: import the names in `__all__`, or all names without a leading underscore."""
    public = module.names.get("__all__", [name for name in module.names if not name.startswith("_")])
    if not isinstance(public, list | tuple) or not all(isinstance(name, str) for name in public):
        raise ScenicError("type", f"`__all__` of {module.name} is a list of names, not {describe_kind(public)}")
    for name in public:
        if name not in module.names:
            raise ScenicError("import", f"{module.name} has no '{name}', which its `__all__` lists")
        scope.locals[name] = module.names[name]


IMPORTS: dict[type, Callable[[Scope, Any], None]] = {
    ast.Import: import_whole,
    ast.ImportFrom: import_from,
    nodes.Model: model,
}
