"""Specifiers, with the properties that they provide and need, and the resolution of an instance's properties.

Read next: `language.specifier_rules`, the meaning of each specifier.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from inspect import Signature
from typing import NamedTuple

from scenic_lite.core.scope import Scope
from scenic_lite.core.types import (
    Behavior,
    BehaviorCall,
    Instance,
    LazyValue,
    RandomChoice,
    ScenicClass,
    describe_kind,
    near,
)
from scenic_lite.errors import ScenicError
from scenic_lite.language.classes import OBJECT, ORIENTED_POINT, SIDES, checked, is_object
from scenic_lite.syntax import nodes
from scenic_lite.values.geometry import normalized
from scenic_lite.values.graph import Value, is_number

REQUIRED, MODIFYING, OPTIONAL = 1, 2, 3  # priorities: the lowest number wins
TILTS = ("orientation", "pitch", "roll")  # properties of dialect 3 that leave the plane


class Given(NamedTuple):
    """The value that a specifier gives to a property; a LazyValue if it depends on other properties."""

    priority: int
    value: Value


@dataclass(eq=False)
class ResolvedSpecifier:
    """One specifier with evaluated operands.

    `always` is called even if specifiers of higher priority provide all of the properties.
    """

    name: str
    node: ast.AST
    gives: dict[str, Given]
    always: Callable[[Instance], None] | None = None

    @property
    def needs(self) -> frozenset[str]:
        """Return the properties of the same object on which the specifier depends."""
        needs = [given.value.needs for given in self.gives.values() if isinstance(given.value, LazyValue)]
        return needs[0] if len(needs) == 1 else frozenset().union(*needs)


@dataclass(eq=False)
class Resolution:
    """The computation of an instance's properties in the order of their dependencies."""

    scope: Scope
    instance: Instance
    by_property: dict[str, ResolvedSpecifier]
    done: set[ResolvedSpecifier] = field(default_factory=set)
    waiting: list[ResolvedSpecifier] = field(default_factory=list)

    def resolve(self, specifier: ResolvedSpecifier) -> None:
        """Apply `specifier` after its dependencies."""
        if specifier in self.done:
            return
        if specifier in self.waiting:
            others = [other.name for other in self.waiting[self.waiting.index(specifier) + 1 :]]
            hint = f"through `{'`, `'.join(others)}`" if others else ""
            raise self.scope.error("specifier", f"`{specifier.name}` depends on itself", specifier.node, hint)
        self.waiting.append(specifier)
        for need in sorted(specifier.needs):
            if need not in self.by_property:
                what = f"the property '{need}', which {self.instance.cls.name} does not have"
                message, hint = f"`{specifier.name}` needs {what}", near(need, self.by_property)
                raise self.scope.error("specifier", message, specifier.node, hint)
            self.resolve(self.by_property[need])
        self.waiting.pop()
        self.done.add(specifier)
        try:
            self._compute(specifier)
        except ScenicError as error:
            raise self.scope.placed(error, specifier.node) from None

    def _compute(self, specifier: ResolvedSpecifier) -> None:
        if specifier.always is not None:
            specifier.always(self.instance)
        for name, (_, value) in specifier.gives.items():
            if self.by_property.get(name) is specifier:
                value = value.compute(self.instance) if isinstance(value, LazyValue) else value
                self.instance.properties[name] = checked(name, value, self.scope.state.dialect)


def make(scope: Scope, cls: ScenicClass, specifiers: list[ResolvedSpecifier], instance: Instance) -> Instance:
    """Resolve the properties of a new instance; add an Object to the scene."""
    refuse(scope, cls, specifiers)
    by_property = resolve_priorities(scope, specifiers)
    for name in cls.property_names():
        if name not in by_property:
            by_property[name] = default_of(scope, cls, name, instance)
    if scope.state.dialect == 3 and cls.derives_from(ORIENTED_POINT):
        split_heading(scope, cls, by_property, instance)
    resolution = Resolution(scope, instance, by_property)
    for specifier in [*specifiers, *by_property.values()]:
        resolution.resolve(specifier)
    if scope.state.dialect == 3:
        refuse_tilt(scope, instance, by_property)
        instance.parent_heading = instance.properties.pop("parentOrientation", 0.0)
    if cls.derives_from(OBJECT):
        limit = scope.mode.budget.limits.objects
        if len(scope.state.objects) >= limit:
            raise ScenicError("budget", f"evaluation budget exceeded: more than {limit} objects")
        scope.state.objects.append(instance)
    return instance


def refuse_tilt(scope: Scope, instance: Instance, by_property: dict[str, ResolvedSpecifier]) -> None:
    """Raise ScenicError for a specifier or a class that leaves the plane; a pitch or roll of 0 is allowed."""
    for name in TILTS:
        value = instance.properties.get(name, 0)
        if (name == "orientation" and name in by_property) or not (is_number(value) and value == 0):
            hint = "write facing H, or with yaw H"
            message = f"in two dimensions no specifier or class sets the {name}"
            raise scope.error("specifier", message, by_property[name].node, hint)


def refuse(scope: Scope, cls: ScenicClass, specifiers: list[ResolvedSpecifier]) -> None:
    """Raise ScenicError for a specifier of a final property or reserved name, or `facing` without a heading."""
    for specifier in specifiers:
        message = hint = ""
        for name in specifier.gives:
            if any("final" in default.attributes for default in cls.defaults_of(name)):
                message = f"the property '{name}' is final: no specifier can set it"
            elif name in SIDES:
                message = f"'{name}' is the place at a side of every object"
        if "facing" in specifier.name and scope.state.dialect == 3 and not cls.derives_from(ORIENTED_POINT):
            message, hint = f"a {cls.name} has no heading for `{specifier.name}`", "an OrientedPoint has one"
        if message:
            raise scope.error("specifier", message, specifier.node, hint)


def resolve_priorities(scope: Scope, specifiers: list[ResolvedSpecifier]) -> dict[str, ResolvedSpecifier]:
    """Return the specifier of each property. Raises ScenicError if two specifiers have the same priority."""
    seen: set[str] = set()
    by_property: dict[str, ResolvedSpecifier] = {}
    for new in specifiers:
        if new.name in seen:
            raise scope.error("specifier", f"`{new.name}` is given twice", new.node)
        seen.add(new.name)
        for name, (priority, _) in new.gives.items():
            old = by_property.setdefault(name, new)
            if old is not new and priority == old.gives[name].priority:
                raise scope.error("specifier", f"`{old.name}` and `{new.name}` both set the {name}", new.node)
            if priority < old.gives[name].priority:
                by_property[name] = new
    return by_property


def default_of(
    scope: Scope, cls: ScenicClass, name: str, instance: Instance, owner: str | None = None
) -> ResolvedSpecifier:
    """Return the default of a property as a specifier; an `additive` property collects the defaults of all bases."""
    defaults = cls.defaults_of(name)
    additive = "additive" in defaults[0].attributes
    used = defaults if additive else defaults[:1]

    def compute(self: Instance) -> Value:
        values = tuple(default.compute(scope, self, owner or name) for default in used)
        return values if additive else values[0]

    return optional(
        f"default of {name}", instance, name, compute, *(need for default in used for need in default.needs)
    )


def optional(
    title: str, instance: Instance, name: str, compute: Callable[[Instance], Value], *needs: str
) -> ResolvedSpecifier:
    """Return a default as a specifier; its errors have the place where the instance is created."""
    place = instance.place
    node = ast.Pass(
        lineno=place.line, col_offset=place.column, end_lineno=place.end_line, end_col_offset=place.end_column
    )
    return ResolvedSpecifier(title, node, {name: Given(OPTIONAL, LazyValue(frozenset(needs), compute))})


def split_heading(
    scope: Scope, cls: ScenicClass, by_property: dict[str, ResolvedSpecifier], instance: Instance
) -> None:
    """Set dialect 3's heading to parent heading + yaw, unless specified; a class default is the parent heading."""
    heading, yaw = by_property["heading"], by_property.get("yaw")
    if not heading.name.startswith("default"):
        if yaw is not None:
            raise scope.error("specifier", f"`{heading.name}` and `{yaw.name}` both set the yaw", yaw.node)
        return
    default = default_of(scope, cls, "heading", instance, "parentOrientation").gives["heading"].value

    def turned(self: Instance) -> Value:
        return normalized(self.properties["parentOrientation"] + self.properties["yaw"])

    parent = optional("parent heading", instance, "parentOrientation", default.compute, *default.needs)
    by_property.setdefault("parentOrientation", parent)
    by_property.setdefault("yaw", optional("yaw", instance, "yaw", lambda self: 0.0))
    by_property["heading"] = optional("heading", instance, "heading", turned, "parentOrientation", "yaw")


# ------------------------------------------------------------ `with`
def with_property(scope: Scope, node: ast.expr, name: str, value: Value) -> ResolvedSpecifier:
    """Return the specifier `with name value`."""
    if name == "behavior" and isinstance(value, Behavior):
        scope.warn(
            f"the behavior {value.name} is written without brackets", node, f"write with behavior {value.name}()"
        )
        value = scope.call(value, [], {}, node)
    elif name == "behavior":
        value = one_behavior(scope, node, value)
    return ResolvedSpecifier(f"with {name}", node, {name: Given(REQUIRED, value)})


def one_behavior(scope: Scope, node: ast.expr, value: Value) -> Value:
    """Wrap a random choice of behaviors in a behavior `A or B(chosen): do chosen`; return other values unchanged."""
    if not isinstance(value, RandomChoice) or not all(isinstance(option, BehaviorCall) for option in value.options):
        return value
    name = " or ".join(dict.fromkeys(option.behavior.name for option in value.options))
    do = nodes.Do([ast.Name("chosen", ast.Load())], "all", None, None, None, None)
    parameters = ast.arguments([], [], None, [], [], None, [])
    tree = nodes.Behavior(name, parameters, [], [], [do], "behavior", None)
    for made in (do, do.calls[0], tree):
        ast.copy_location(made, node)
    return BehaviorCall(Behavior(name, Signature(), scope, frozenset(), tree), {"chosen": value}, scope.place(node))


def warn_of_unknown(scope: Scope, cls: ScenicClass, node: ast.AST, name: str, value: Value) -> None:
    """Warn about an undeclared property if it is probably a mistake."""
    known = cls.property_names()
    if name in known:
        return
    hint = near(name, known)
    is_behavior = isinstance(scope.module_names.get(name), Behavior)
    if is_behavior:
        hint = f"did you mean 'behavior {name}()'?"
    if hint or isinstance(value, BehaviorCall):
        scope.warn(f"{cls.name} has no property '{name}'", node, hint or "a behavior is attached by 'with behavior'")


def overridden_properties(scope: Scope, node: nodes.Override, target: Value, live: Collection[str]) -> dict[str, Value]:
    """Return the values of `override target with p v, ...` by name; `live` are the simulator's properties."""
    if not is_object(target):
        raise scope.error("type", f"`override` needs an object, not {describe_kind(target)}", node.target)
    values: dict[str, Value] = {}
    for specifier in node.specifiers:
        name, value = "heading" if "facing" in specifier.name else "position", None
        if specifier.name == "with":
            first, expression = specifier.arguments
            assert isinstance(first, ast.Constant) and expression is not None
            name, value = str(first.value), scope.value(expression)
        if name in live:
            raise scope.error("specifier", f"'{name}' is of the simulator and cannot be overridden", specifier)
        if name not in target.properties:
            message, hint = f"{target.title()} has no property '{name}' to override", near(name, target.properties)
            raise scope.error("specifier", message, specifier, hint)
        values[name] = value if isinstance(value, RandomChoice) else checked(name, value, scope.state.dialect)
    return values
