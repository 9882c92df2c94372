"""Exceptions as a program sees them: what `raise` may raise and `except` may name, from one fixed table.

Faults of Python's own operators become a ScenicError here; `except` finds out from its `fault` what a program would
call it. Budget, syntax and unsupported constructs have no such name: no program can catch them. Read next:
`evaluation.trying`, which runs the statements.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from scenic_lite.core.budget import exceeded
from scenic_lite.errors import ScenicError


@dataclass(frozen=True, eq=False)
class ExceptionClass:
    """A class of exceptions, of the table below or of the program's own."""

    name: str
    base: ExceptionClass | None = None

    def lineage(self) -> Iterator[ExceptionClass]:
        """The class and its bases, most derived first."""
        at: ExceptionClass | None = self
        while at is not None:
            yield at
            at = at.base

    def derives_from(self, other: ExceptionClass) -> bool:
        return any(each is other for each in self.lineage())


@dataclass(frozen=True, eq=False)
class Fault:
    """One exception: what `except E as e` gives a name to."""

    cls: ExceptionClass
    arguments: tuple = ()

    def text(self) -> str:
        """`str(e)`."""
        if len(self.arguments) == 1:
            only = self.arguments[0]
            return repr(only) if self.cls.name == "KeyError" else str(only)
        return str(self.arguments) if self.arguments else ""


def table(tree: dict[str, str]) -> dict[str, ExceptionClass]:
    """Classes by name; `tree` gives the base of each, itself given before."""
    classes: dict[str, ExceptionClass] = {}
    for name, base in tree.items():
        classes[name] = ExceptionClass(name, classes.get(base))
    return classes


EXCEPTIONS = table(
    {
        "BaseException": "",
        "Exception": "BaseException",
        "ArithmeticError": "Exception",
        "ZeroDivisionError": "ArithmeticError",
        "OverflowError": "ArithmeticError",
        "AssertionError": "Exception",
        "AttributeError": "Exception",
        "ImportError": "Exception",
        "ModuleNotFoundError": "ImportError",
        "LookupError": "Exception",
        "IndexError": "LookupError",
        "KeyError": "LookupError",
        "NameError": "Exception",
        "UnboundLocalError": "NameError",
        "RuntimeError": "Exception",
        "NotImplementedError": "RuntimeError",
        "StopIteration": "Exception",
        "TypeError": "Exception",
        "ValueError": "Exception",
        "UnicodeError": "ValueError",
        "ScenicError": "Exception",
        "SpecifierError": "ScenicError",
        "RandomControlFlowError": "ScenicError",
        "InvalidScenarioError": "ScenicError",
        "RejectionException": "Exception",
    }
)
OF_KINDS = {
    "name": "NameError",
    "type": "TypeError",
    "value": "ValueError",
    "import": "ModuleNotFoundError",
    "specifier": "SpecifierError",
    "random-control-flow": "RandomControlFlowError",
}
# Scenic's own exceptions are no builtins of Python: a program cannot name them, but `except Exception` holds them.
NAMED = {
    name: cls
    for name, cls in EXCEPTIONS.items()
    if cls.base is not EXCEPTIONS["ScenicError"] and name not in ("ScenicError", "RejectionException")
}


def fault_of(error: ScenicError) -> Fault | None:
    """What a program may catch of an error; None if it may not."""
    if error.fault is not None:
        return error.fault
    name = OF_KINDS.get(error.kind)
    return None if name is None else Fault(EXCEPTIONS[name], (error.message,))


def named_fault(name: str, error: ScenicError) -> ScenicError:
    """The error, to be caught under this name."""
    error.fault = Fault(EXCEPTIONS[name], (error.message,))
    return error


def raised(fault: Fault) -> ScenicError:
    """The error of a `raise` statement."""
    names = [each.name for each in fault.cls.lineage()]
    kind = next((kind for kind, name in OF_KINDS.items() if name in names), "value")
    text = fault.text()
    error = ScenicError(kind, f"{fault.cls.name}: {text}" if text else fault.cls.name)
    error.fault = fault
    return error


def from_python(fault: BaseException) -> ScenicError:
    """Our error for a fault of Python's own operators and methods."""
    if isinstance(fault, RecursionError):
        return exceeded("expressions and functions are nested too deeply")
    if isinstance(fault, MemoryError):
        return exceeded("more memory is asked for than there is")
    message = f"key {fault} is not in the dictionary" if isinstance(fault, KeyError) else str(fault)
    error = ScenicError("type" if isinstance(fault, TypeError) else "value", message or type(fault).__name__)
    cls = next(EXCEPTIONS[each.__name__] for each in type(fault).__mro__ if each.__name__ in EXCEPTIONS)
    error.fault = Fault(cls, fault.args)
    return error
