"""Declaration and checks of settings: a dataclass field with a default, one line of help, a rule and bounds.

The command line is derived from such fields (`regista.experiments.run.arguments`). No torch is needed here, so
`--help` is quick. Read next: `config`, the settings of methods.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import typing
from collections.abc import Callable, Mapping
from dataclasses import field, fields, is_dataclass
from types import NoneType
from typing import Any, Literal

from ued.core.own_code import canonical, is_name

# Rules for settings: a check, which nan fails, and its wording in messages.
RULES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "": (lambda value: True, ""),
    ">=1": (lambda value: value >= 1, "must be at least 1"),
    ">0": (lambda value: value > 0, "must be positive"),
    ">=0": (lambda value: value >= 0, "must not be negative"),
    "0-1": (lambda value: 0 <= value <= 1, "must be between 0 and 1"),
}


LARGEST_SEED = 2**32 - 1
Check = tuple[str, Mapping[str, Any], bool, Any]
WORDS: dict[Any, str] = {int: "an integer", float: "a number", bool: "True or False", str: "a text"}
Bound = float | Callable[[], float]  # a number, or a function that computes it on this machine


def most_threads() -> int:
    """Return the maximum number of threads, or of game engine processes, of a command on this machine."""
    return 4 * (os.cpu_count() or 1)


def setting(
    default: Any,
    help: str,
    rule: Literal["", ">=1", ">0", ">=0", "0-1"] = "",
    most: Bound | None = None,
    least: float | None = None,
    metavar: str = "",
) -> Any:
    """Return a dataclass field: its default, one line of help, as the command line shows it, and a rule of `RULES`.

    A number has a maximum, `most`, and a minimum, `least`, if no rule gives it. `metavar` is the placeholder of the
    value in the help.
    """
    about = {"help": help, "rule": rule, "most": most, "least": least, "metavar": metavar}
    return field(default=default, metadata=about)


def named(default: str, help: str, names: tuple[str, ...], kind: str) -> Any:
    """Return the field of a setting that names a built-in object, or a function or class of the user.

    `kind` is the type of the user's object: "function" or "class". See `core.own_code`.
    """
    about = {"help": f"{help}; or your own, module:{kind} or file.py:{kind}", "names": names, "kind": kind}
    return field(default=default, metadata=about)


def own_names(config: Any) -> list[str]:
    """Return the names of the user's functions and classes in a configuration and its parts."""
    values = [(item, getattr(config, item.name)) for item in fields(config)]
    nested = [name for _, value in values if is_dataclass(value) for name in own_names(value)]
    return [value for item, value in values if item.metadata.get("names") and is_name(value)] + nested


def bounds_of(about: Mapping[str, Any]) -> tuple[float, float]:
    """Return the smallest and the largest number that a field of this metadata allows; infinite without a bound."""
    rule, least, most = about.get("rule", ""), about.get("least"), about.get("most")
    if rule == "0-1":
        return 0, 1
    lowest: float = {">=1": 1, ">=0": 0, ">0": 0}.get(rule, -math.inf) if least is None else least
    highest: float = math.inf if most is None else most() if callable(most) else most
    return lowest, highest


def complaint(about: Mapping[str, Any], value: Any) -> str | None:
    """Return the error of a value for a field of this metadata; None if it is valid."""
    names = about.get("names", ())
    if names and value not in names and not is_name(str(value)):
        kind = about["kind"]
        return f"must be {' or '.join(names)}, or your own, module:{kind} or file.py:{kind}, got {value!r}"
    holds, words = RULES[about.get("rule", "")]
    if not holds(value):
        return f"{words}, got {value!r}"
    for number in value if isinstance(value, tuple) else (value,):
        if isinstance(number, int | float) and not isinstance(number, bool):
            least, most = bounds_of(about)
            if not least <= number:
                return f"must be at least {spelled(least)}, got {number!r}"
            if not number <= most:
                scope = " on this machine" if callable(about.get("most")) else ""
                return f"must be at most {spelled(most)}{scope}, got {number!r}"
    return None


def spelled(number: float) -> str:
    """Return a bound as users type it: 1_000_000, 0.5, 1e+12."""
    return f"{number:_}" if isinstance(number, int) else f"{number:g}"


@functools.cache
def hints_of(kind: Any) -> dict[str, Any]:
    """Return the types of a class's fields, evaluated from their annotations and cached."""
    return typing.get_type_hints(kind)


@functools.cache
def _checks_of(kind: Any) -> list[Check]:
    """Return the name, the metadata, whether None is allowed, and the type of each field of a class.

    Cached: a command creates hundreds of settings to show the defaults of games and presets in its help.
    """
    hints = hints_of(kind)
    checks: list[Check] = []
    for entry in dataclasses.fields(kind):
        hint = hints[entry.name]
        optional = NoneType in typing.get_args(hint)
        inner = next(part for part in typing.get_args(hint) if part is not NoneType) if optional else hint
        checks.append((entry.name, entry.metadata, optional, inner))
    return checks


def converted(kind: Any, value: Any) -> Any:
    """Return a value as the type of its field: a NumPy number or 1e6 as an int, a list as a tuple.

    Raises `ValueError` for another type; the message reports the expected type. Types other than numbers, texts, tuples
    and nested settings are not checked.
    """
    if type(value) is kind:
        return value
    plain = value.item() if getattr(value, "ndim", None) == 0 else value
    if typing.get_origin(kind) is tuple:
        if isinstance(plain, list | tuple):
            return tuple(converted(typing.get_args(kind)[0], part) for part in plain)
        raise ValueError(f"must be a tuple or a list, got {value!r:.100}")
    if typing.get_origin(kind) is Literal:
        if value in typing.get_args(kind):
            return value
        raise ValueError(f"must be {' or '.join(map(str, typing.get_args(kind)))}, got {value!r}")
    if isinstance(kind, type) and is_dataclass(kind) and not isinstance(plain, kind):
        raise ValueError(f"must be {kind.__name__}(...), got {value!r:.100}")
    if kind is int and isinstance(plain, float) and plain.is_integer():
        return int(plain)
    fits = isinstance(plain, int | float if kind is float else kind) if kind in WORDS else True
    if not fits or (kind in (int, float) and isinstance(plain, bool)):
        raise ValueError(f"must be {WORDS[kind]}, got {value!r:.100}")
    return plain


class Checked:
    """Settings that are checked against the types, rules and bounds of their fields.

    Raises `ValueError` for the first invalid setting.
    """

    def __post_init__(self) -> None:
        kind: Any = type(self)
        for name, about, optional, hint in _checks_of(kind):
            value = given = self.__dict__[name]
            if value is None and optional:
                continue
            try:
                value = converted(hint, given)
                wrong = complaint(about, value)
            except ValueError as error:
                wrong = str(error)
            if value is not given:
                object.__setattr__(self, name, value)
            if wrong:
                raise ValueError(f"{name} {wrong}")
            if about.get("names"):  # make the path of a file absolute
                object.__setattr__(self, name, value if value in about["names"] else canonical(value))
