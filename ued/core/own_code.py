"""User code by name, `module:name` or `file.py:name`: scores of levels and networks.

Names in Python or on a command line are trusted: the user chose to run this code. A file of another user may also name
code, so readers of files call `note_read`, and `load` then calls `checks` before any import. Read next:
`levels.scores`, `learning.own_network`; `regista.experiments.run.trust`, the rules of the command line.
"""

from __future__ import annotations

import functools
import importlib
import importlib.util
import inspect
import re
import sys
import traceback
from collections.abc import Callable
from difflib import get_close_matches
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

PACKAGE = Path(__file__).parents[1]
FAILURES = (Exception, SystemExit)  # failures of user code: sys.exit() must not end a command silently, Ctrl-C may
NAME = re.compile(r"(.+\.py|[A-Za-z_][\w.]*):[A-Za-z_]\w*")


class OwnCodeError(ValueError):
    """User code that is missing, fails, or returns a wrong value; the message gives the expected value."""


def _refuse(name: str) -> None:
    raise OwnCodeError(f"a file names {name}, which is Python code; read it, and pass trusted=True to run it")


checks: list[Callable[[str], None]] = [_refuse]  # the last one raises an error for a name that may not run
_noted: dict[str, str] = {}  # names that were read from a file, and its path


def is_name(text: str) -> bool:
    """Return whether a text names user code: it has a colon, which no built-in name has."""
    return bool(NAME.fullmatch(text))


def canonical(name: str) -> str:
    """Return a name with the absolute path of its file, valid in every working directory."""
    place, _, attribute = name.rpartition(":")
    return f"{Path(place).expanduser().resolve()}:{attribute}" if place.endswith(".py") else name


def note_read(*names: str, file: str = "") -> None:
    """Record that a file names this code, so that it is checked before it is loaded."""
    _noted.update({canonical(name): file for name in names})


def is_noted(name: str) -> bool:
    """Return whether a file names this code."""
    return canonical(name) in _noted


def permit(name: str) -> None:
    """Allow code that a file names: the user has confirmed it."""
    _noted.pop(canonical(name), None)


def advice(name: str) -> str:
    """Return the end of the error of missing code: the run's settings in which a moved file must be renamed, or ""."""
    file = _noted.get(canonical(name), "")
    if not file.endswith("config.json"):
        return ""
    return f"; if it was moved, change its name in {file}, or name its new place with train --resume"


def check(name: str) -> None:
    """Raise the error of the last of `checks` for code that a file names and that may not run."""
    if is_noted(name):
        checks[-1](canonical(name))


def load(name: str) -> Any:
    """Return the object that a name refers to; import its file or module if necessary.

    Raises `OwnCodeError` if it is missing or cannot be imported, and the error of a check for a name from a file.
    """
    name = canonical(name)
    place, _, attribute = name.rpartition(":")
    if place.endswith(".py") and not Path(place).is_file():
        raise OwnCodeError(f"there is no file {place}, which {name} names{advice(name)}")
    check(name)
    try:
        module = module_of(place)
    except FAILURES as error:
        raise OwnCodeError(f"{place} cannot be imported: {type(error).__name__}: {error}") from error
    if not hasattr(module, attribute):
        near = get_close_matches(attribute, vars(module), 1)
        raise OwnCodeError(f"{place} has no {attribute!r}{f' (did you mean {near[0]!r}?)' if near else ''}")
    return getattr(module, attribute)


def line_in(function: Any, error: BaseException) -> str:
    """Return " (FILE:LINE)", the last line in the file of the user's function that led to an error, or "".

    A call with wrong arguments fails before the function's first line and reports the line of its definition.
    """
    while isinstance(function, functools.partial):
        function = function.func
    code = getattr(inspect.unwrap(function), "__code__", None) or getattr(type(function).__call__, "__code__", None)
    if code is None:
        return ""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == code.co_filename]
    if not lines and isinstance(error, TypeError) and Path(frames[-1].filename).is_relative_to(PACKAGE):
        lines = [code.co_firstlineno]
    return f" ({code.co_filename}:{lines[-1]})" if lines else ""


def call(what: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a user's function, named `what` in errors. Raises `OwnCodeError`, with line and arguments, for any error."""
    try:
        return function(*arguments)
    except OwnCodeError:
        raise
    except FAILURES as error:
        given = ", ".join(map(str, arguments))
        shown = given if len(given) < 300 else given[:300] + " …"
        kind = type(error).__name__
        raise OwnCodeError(f"{what} failed{line_in(function, error)}: {kind}: {error} (called with {shown})") from error


class _Source(SourceFileLoader):
    """Compiles the file at each import: Python's cache misses an edit of the same length within the same second."""

    def get_code(self, fullname: str) -> CodeType:
        return self.source_to_code(self.get_data(self.path), self.path)


def module_of(place: str) -> ModuleType:
    """Return the module of a file `.py`, which must exist, or of a dotted name; importing executes its code."""
    if not place.endswith(".py"):
        if "" not in sys.path:
            sys.path.insert(0, "")  # like `python -m`
        return importlib.import_module(place)
    path = Path(place).expanduser().resolve()
    main = sys.modules.get("__main__")
    if main is not None and Path(getattr(main, "__file__", None) or "").resolve() == path:
        return main  # a script that trains on its own code
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))  # as Python does for a script
    known = sys.modules.get(path.stem)
    if known is not None and Path(getattr(known, "__file__", None) or "").resolve() == path:
        return known
    spec = importlib.util.spec_from_loader(path.stem, _Source(path.stem, str(path)))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.setdefault(path.stem, module)  # dataclasses and pickles look a class's module up
    try:
        spec.loader.exec_module(module)
    except BaseException:
        if sys.modules[path.stem] is module:
            del sys.modules[path.stem]  # incomplete module: the next attempt imports it again
        raise
    return module
