"""Calls of program functions, built-in functions and behaviors, and the creation of instances.

Read next: `evaluation.statements`.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable
from functools import lru_cache, partial
from inspect import Parameter, Signature
from typing import Any

from scenic_lite.core.scope import Scope
from scenic_lite.core.state import COMPILE, LOAD, LoadState, Mode
from scenic_lite.core.types import (
    Behavior,
    BehaviorCall,
    Bound,
    Builtin,
    Definition,
    Function,
    Instance,
    LazyValue,
    RandomChoice,
    ScenicClass,
    Undecided,
    broadcasts_over_choices,
    describe_kind,
    for_each_option,
    near,
)
from scenic_lite.errors import ScenicError, SourceSpan
from scenic_lite.language.distributions import draw_present
from scenic_lite.language.specifier_rules import SPECIFIERS
from scenic_lite.language.specifiers import ResolvedSpecifier, make, warn_of_unknown, with_property
from scenic_lite.syntax import nodes
from scenic_lite.values.graph import Value, is_number, kind_of

LONGEST_CHAIN = 8  # maximum number of calls in the notes of an error
POSITIONAL = Parameter.POSITIONAL_OR_KEYWORD
TRACKED_NAMES = ("ego", "workspace")  # stored in the state, from any scope
NAMING = (ast.FunctionDef, ast.ClassDef)
OWN_SCOPES = (
    ast.FunctionDef, ast.Lambda, ast.ClassDef, ast.ListComp, ast.DictComp, ast.GeneratorExp, nodes.Behavior,
    nodes.Scenario,
)  # fmt: skip


class Return(Exception):
    """Control flow: a function of the program returns a value."""

    def __init__(self, value: Value) -> None:
        super().__init__()
        self.value = value


def call_node(scope: Scope, node: ast.Call) -> Value:
    function = scope.value(node.func)
    values = [scope.value(each.value if isinstance(each, ast.Starred) else each) for each in node.args]
    keywords: dict[str, Value] = {}
    for keyword in node.keywords:
        assert keyword.arg is not None, "the parser refuses `**`"
        keywords[keyword.arg] = scope.value(keyword.value)
    return spread_call(scope, node, function, values, keywords)


def spread_call(scope: Scope, node: ast.Call, function: Value, values: list, keywords: dict[str, Value]) -> Value:
    """Call a function with starred arguments, such as `f(*items)`.

    For a random list, the call is mapped over the options of the list. `Uniform(*items)` draws once, from the elements.
    """
    stars = [isinstance(written, ast.Starred) for written in node.args]
    at = next((i for i, value in enumerate(values) if stars[i] and isinstance(value, Undecided)), None)
    if at is None:
        arguments: list[Value] = []
        for star, value, written in zip(stars, values, node.args, strict=True):
            arguments += scope.elements(value, written) if star else (value,)
        return scope.call(function, arguments, keywords, node)
    if isinstance(function, Builtin) and function.name == "Uniform" and scope.mode.phase == LOAD:
        pieces = [value if star else [value] for star, value in zip(stars, values, strict=True)]
        return draw_present(scope, node, pieces)

    def anew(_: Scope, items: Value) -> Value:
        return spread_call(scope, node, function, [*values[:at], items, *values[at + 1 :]], keywords)

    return scope.handlers.undecided(anew, 1, (scope, values[at]), {})


@broadcasts_over_choices(1)
def call(scope: Scope, function: Value, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
    """Call any callable value."""
    if isinstance(function, Bound):
        return call(scope, function.function, [function.receiver, *arguments], keywords, node)
    if isinstance(function, Builtin):
        return call_builtin(scope, function, arguments, keywords, node)
    if isinstance(function, Function):
        return call_function(scope, function, arguments, keywords, node)
    if isinstance(function, Behavior):
        return BehaviorCall(function, function.bind(arguments, keywords), scope.place(node))
    if isinstance(function, ScenicClass):
        raise ScenicError(
            "type", f"objects of class {function.name} are not made by a call", hint=f"write new {function.name}"
        )
    hint = f"write new {function.cls.name}, without brackets" if isinstance(function, Instance) else ""
    raise ScenicError("type", f"{describe_kind(function)} cannot be called", hint=hint)


def call_builtin(scope: Scope, function: Builtin, arguments: list, keywords: dict[str, Value], node: ast.AST) -> Value:
    if any(isinstance(argument, LazyValue) for argument in arguments):
        raise ScenicError("unsupported", f"{function.name}() of a value that depends on the object being made")
    at = next((i for i, argument in enumerate(arguments) if isinstance(argument, RandomChoice)), None)
    if at is not None and function.over_choices:
        anew = partial(call_builtin, scope, function, keywords=keywords, node=node)
        return for_each_option(lambda *option: anew(arguments=list(option)), at, tuple(arguments), {})
    if not function.needs_context:
        scope.mode.budget.whole(arguments)
    inputs = [scope, node, *arguments] if function.needs_context else arguments
    check_signature(function, inputs, keywords)
    result = function.function(*inputs, **keywords)
    scope.mode.budget.keep(result)
    scope.watch(result)
    return result


parameters_of = lru_cache(maxsize=512)(inspect.signature)


def check_signature(function: Builtin, inputs: list, keywords: dict[str, Value]) -> None:
    """Raise ScenicError, with the names that a program uses, if the arguments do not match the signature."""
    try:
        parameters_of(function.function).bind(*inputs, **keywords)
    except ValueError:  # some methods of Python's containers have no signature
        return
    except TypeError:
        own = 2 if function.needs_context else 0
        parameters = list(parameters_of(function.function).parameters.values())[own:]
        names = ", ".join(str(parameter).split(":")[0].split("=")[0] for parameter in parameters)
        count = len(inputs) - own + len(keywords)
        message = f"{function.name} does not take {count} argument{'s' * (count != 1)}"
        raise ScenicError("type", message, hint=f"write {function.name}({names})") from None


def call_function(
    scope: Scope, function: Function, arguments: list, keywords: dict[str, Value], node: ast.AST
) -> Value:
    """Run a function of the program; an error inside a library is reported at the call in the program."""
    inner = Scope.inside(scope.mode, function.scope, function.bind(arguments, keywords))
    inner.assigned = function.assigned
    budget = scope.mode.budget
    budget.enter()
    try:
        if isinstance(function.body, ast.expr):
            return inner.value(function.body)
        inner.run(function.body)
    except Return as result:
        return result.value
    except ScenicError as error:
        raise seen_from(scope.state, function, scope.place(node), error) from None
    finally:
        budget.leave()
    return None


def seen_from(state: LoadState, thing: Definition, place: SourceSpan, error: ScenicError) -> ScenicError:
    """Return the error of a called function: for a library function at the call, otherwise with a note on the call."""
    if error.place is None or place.file not in state.sources or error.place.file not in state.sources:
        return error
    caller, line = state.sources[place.file], state.sources[place.file].line(place.line)
    if state.sources[error.place.file].library and not caller.library:
        names, inner = ", ".join(thing.signature.parameters), f"{error.place.file}:{error.place.line}"
        where = f"    in {thing.name}({names}), {inner}: {error.source_line.strip()}"
        notes = [where, *error.notes]
        return ScenicError(error.kind, error.message, place, hint=error.hint, source_line=line, notes=notes)
    note = f"    in {thing.name}, called in {place.file}:{place.line}: {line.strip()}"
    same = (place.file, place.line) == (error.place.file, error.place.line)
    if not (same or caller.library or note in error.notes or len(error.notes) >= LONGEST_CHAIN):
        error.notes = (*error.notes, note)
    return error


def scenario_frame(mode: Mode, call: BehaviorCall) -> Scope:
    """Return a scope for the names of one run of a scenario, shared by its setup and its compose block."""
    call.names.clear()
    call.names.update(call.arguments)
    scope = Scope.inside(mode, call.behavior.scope, call.names)
    scope.assigned = call.behavior.assigned
    return scope


def lambda_of(scope: Scope, node: ast.Lambda) -> Function:
    return function_of(scope, "lambda", node.args, node.body)


def function_of(scope: Scope, name: str, arguments: ast.arguments, body: Any, is_method: bool = False) -> Function:
    """Create a function and evaluate its defaults. A method does not see the names of its class."""
    assigned = names_of(tuple(body)) if isinstance(body, list) else frozenset[str]()
    around = scope.outer if is_method and scope.outer is not None else scope
    return Function(name, signature_of(scope, arguments), around, assigned, body)


def signature_of(scope: Scope, arguments: ast.arguments) -> Signature:
    """Return the parameters of a definition with their default values."""
    defaults = [Parameter.empty] * (len(arguments.args) - len(arguments.defaults)) + [
        *map(scope.value, arguments.defaults)
    ]
    parameters = [Parameter(a.arg, POSITIONAL, default=d) for a, d in zip(arguments.args, defaults, strict=True)]
    if arguments.vararg is not None:
        parameters.append(Parameter(arguments.vararg.arg, Parameter.VAR_POSITIONAL))
    return Signature(parameters)


@lru_cache(maxsize=4096)  # the trees of a library are the same for every program
def names_of(body: tuple[ast.stmt, ...]) -> frozenset[str]:
    """Return the local names of a function: all names that the body assigns."""
    names: set[str] = set()
    for node in nodes.walk_own(*body, scopes=OWN_SCOPES):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            names.add(node.id)
        elif isinstance(node, NAMING) and node.name:
            names.add(node.name)
    return frozenset(names.difference(TRACKED_NAMES))


def new(scope: Scope, node: nodes.New) -> Value:
    """Return an instance; if the name is not a class, the value of the operator or plain name instead."""
    cls = scope.value(node.cls)
    if not isinstance(cls, ScenicClass):
        if not node.certain:
            return cls if node.operator is None else scope.value(node.operator)
        classes = [name for name, value in scope.module_names.items() if isinstance(value, ScenicClass)]
        hint = near(node.cls.id, classes) if isinstance(node.cls, ast.Name) else ""
        if isinstance(cls, Behavior | Function):
            hint = f"write {cls.name}(...), without new"
        raise scope.error("type", f"{describe_kind(cls)} is not a class of objects", node.cls, hint)
    if scope.mode.symbolic and scope.mode.phase != COMPILE:
        raise ScenicError("type", "a requirement cannot make objects")
    instance = Instance(cls, scope.place(node), scope.mode.owner)
    meanings = [meaning(scope, instance, specifier) for specifier in node.specifiers]
    return make(scope, cls, meanings, instance)


def meaning(scope: Scope, instance: Instance, node: nodes.Specifier) -> ResolvedSpecifier:
    """Return a specifier with its operands evaluated; errors point at the specifier."""
    first = node.arguments[0] if node.arguments else None
    name = str(first.value) if node.name == "with" and isinstance(first, ast.Constant) else ""
    scope = scope.owning(instance, name or ("heading" if "facing" in node.name else "position"))
    try:
        if name:
            value = None if (written := node.arguments[1]) is None else scope.value(written)
            warn_of_unknown(scope, instance.cls, node, name, value)
            return with_property(scope, node, name, value)
        if node.name not in SPECIFIERS:
            raise ScenicError("unsupported", f"`{node.name}` is not supported in two dimensions")
        operands = scope.operands(node.arguments)
        resolved = SPECIFIERS[node.name](scope, node, *operands)  # errors of this call mostly name the required types
        scope.refuse_none(node.arguments, operands)
        return resolved
    except ScenicError as error:
        raise scope.placed(error, node) from None


def named_by_do(scope: Scope, node: nodes.Do, kind: str) -> list[tuple[Value, Value]]:
    """Return the targets of a `do` with their weights; `kind` is "behavior" or "scenario".

    `choose` and `shuffle` also accept a dictionary of weights.
    """
    values, places = [scope.value(call) for call in node.calls], list(node.calls)
    weights = [1.0] * len(values) if node.weights is None else [scope.value(weight) for weight in node.weights]
    if len(values) == 1 and isinstance(values[0], dict) and node.how != "all":
        values, weights = list(values[0]), list(values[0].values())
        places *= len(values)
    for weight in weights:
        if kind_of(weight) not in ("number", "truth") or (is_number(weight) and weight < 0):
            raise scope.error("value", f"a weight is a number, and not negative: {weight!r}", node)
    return list(zip([called(scope, kind, *pair) for pair in zip(values, places, strict=True)], weights, strict=True))


def called(scope: Scope, kind: str, value: Value, place: ast.expr) -> Value:
    """Return a behavior or scenario with its arguments, or a random choice among such calls."""
    if isinstance(value, RandomChoice):
        return RandomChoice(value.index, tuple(called(scope, kind, option, place) for option in value.options))
    if isinstance(value, BehaviorCall) and value.behavior.kind == kind:
        return value
    if isinstance(value, Behavior | BehaviorCall):
        own = value if isinstance(value, Behavior) else value.behavior
        hint = f"write {own.name}()" if own.kind == kind else INSTEAD_OF_DO[own.kind].format(own.name)
        what = f"the {own.kind} {own.name}" if own is not value else describe_kind(value)
        raise scope.error("type", f"`do` needs a {kind}, not {what}", place, hint)
    made = scope.value(place.func) if isinstance(place, ast.Call) else value
    hint = ""
    if isinstance(made, Function | Builtin):
        action = isinstance(made, Function) and made.scope.source.library
        hint = f"an action is taken: take {made.name}()" if action else f"a function is called: {made.name}()"
    raise scope.error("type", f"`do` needs a {kind}, not {describe_kind(value)}", place, hint)


INSTEAD_OF_DO = {
    "behavior": "an object does it: override ego with behavior {}()",
    "monitor": "write require monitor {}() outside of behaviors",
    "scenario": "scenarios are run in a compose block",
}


def refuse_as_action(value: Value) -> None:
    """Raise ScenicError for a behavior, monitor or scenario after `take`."""
    if isinstance(value, Behavior | BehaviorCall):
        own = value if isinstance(value, Behavior) else value.behavior
        hint = INSTEAD_OF_DO[own.kind].format(own.name) if own.kind != "behavior" else f"write do {own.name}()"
        raise ScenicError("type", f"`take` needs an action, not the {own.kind} {own.name}", hint=hint)


CALLS: dict[type, Callable[[Scope, Any], Value]] = {
    ast.Call: call_node,
    ast.Lambda: lambda_of,
    nodes.New: new,
}
