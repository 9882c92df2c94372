"""`match`: values taken apart by patterns.

Read next: `evaluation.statements`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import Builtin, RandomChoice, describe_kind
from scenic_lite.errors import ScenicError
from scenic_lite.evaluation.attributes import attribute
from scenic_lite.evaluation.builtins import is_of
from scenic_lite.evaluation.comparisons import equal
from scenic_lite.values.graph import RandomExpr, Value


def choose_case(scope: Scope, node: ast.Match) -> None:
    """Run the first case whose pattern and guard hold; the subject must not be random."""
    scope.run(chosen_case(scope, node))


def chosen_case(scope: Scope, node: ast.Match) -> list[ast.stmt]:
    """The statements of the first case that holds; its names are assigned."""
    subject = scope.value(node.subject)
    for case in node.cases:
        names: dict[str, Value] = {}
        if not matches(scope, case.pattern, subject, names):
            continue
        for name, value in names.items():
            scope.assign(name, value)
        if case.guard is None or scope.truth(case.guard):
            return case.body
    return []


def matches(scope: Scope, pattern: ast.pattern, value: Value, names: dict[str, Value]) -> bool:
    """Whether a value fits, noting the names that the pattern gives to its parts."""
    scope.mode.budget.step()
    if not (isinstance(pattern, ast.MatchAs) and pattern.pattern is None) and isinstance(
        value, RandomExpr | RandomChoice
    ):
        scope.refuse_random(value, pattern, "control flow cannot depend on a random value")
    return PATTERNS[type(pattern)](scope, pattern, value, names)


def match_value(scope: Scope, pattern: ast.MatchValue, value: Value, names: dict[str, Value]) -> bool:
    return equal(scope, scope.value(pattern.value), value)


def match_constant(scope: Scope, pattern: ast.MatchSingleton, value: Value, names: dict[str, Value]) -> bool:
    return value is pattern.value


def match_name(scope: Scope, pattern: ast.MatchAs, value: Value, names: dict[str, Value]) -> bool:
    if pattern.pattern is not None and not matches(scope, pattern.pattern, value, names):
        return False
    if pattern.name is not None:
        names[pattern.name] = value
    return True


def match_either(scope: Scope, pattern: ast.MatchOr, value: Value, names: dict[str, Value]) -> bool:
    return any(matches(scope, each, value, names) for each in pattern.patterns)


def match_sequence(scope: Scope, pattern: ast.MatchSequence, value: Value, names: dict[str, Value]) -> bool:
    if not isinstance(value, list | tuple | range):
        return False
    items = scope.elements(value, pattern)
    parts = pattern.patterns
    star = next((i for i, each in enumerate(parts) if isinstance(each, ast.MatchStar)), None)
    if star is None:
        return len(items) == len(parts) and match_all(scope, parts, items, names)
    after = len(parts) - star - 1
    if len(items) < len(parts) - 1:
        return False
    middle = items[star : len(items) - after]
    starred = parts[star]
    if isinstance(starred, ast.MatchStar) and starred.name is not None:
        names[starred.name] = middle
    fixed = [*parts[:star], *parts[star + 1 :]]
    return match_all(scope, fixed, [*items[:star], *items[len(items) - after :]], names)


def match_all(scope: Scope, parts: list[ast.pattern], items: list, names: dict[str, Value]) -> bool:
    return all(matches(scope, each, item, names) for each, item in zip(parts, items, strict=True))


def match_mapping(scope: Scope, pattern: ast.MatchMapping, value: Value, names: dict[str, Value]) -> bool:
    if not isinstance(value, dict):
        return False
    keys = [scope.value(key) for key in pattern.keys]
    if not all(key in value for key in keys):
        return False
    if not match_all(scope, pattern.patterns, [value[key] for key in keys], names):
        return False
    if pattern.rest is not None:
        names[pattern.rest] = {key: each for key, each in value.items() if key not in keys}
    return True


def match_class(scope: Scope, pattern: ast.MatchClass, value: Value, names: dict[str, Value]) -> bool:
    cls = scope.value(pattern.cls)
    if not is_of(value, cls):
        return False
    if len(pattern.patterns) > 1 or (pattern.patterns and not isinstance(cls, Builtin)):
        raise ScenicError("unsupported", f"{describe_kind(cls)} has no parts by position", hint="write C(name=...)")
    if not match_all(scope, pattern.patterns, [value] * len(pattern.patterns), names):
        return False
    try:
        parts = [attribute(scope, value, name) for name in pattern.kwd_attrs]
    except ScenicError as error:
        if error.kind == "name":
            return False
        raise
    return match_all(scope, pattern.kwd_patterns, parts, names)


PATTERNS: dict[type, Callable[[Scope, Any, Value, dict[str, Value]], bool]] = {
    ast.MatchValue: match_value,
    ast.MatchSingleton: match_constant,
    ast.MatchAs: match_name,
    ast.MatchOr: match_either,
    ast.MatchSequence: match_sequence,
    ast.MatchMapping: match_mapping,
    ast.MatchClass: match_class,
}
