"""Resource limits of a program during loading and sampling: an untrusted file can only waste time.

Every limit has its own message. Read next: `core.scope`, which counts the steps.
"""

from __future__ import annotations

from collections.abc import Sized
from dataclasses import dataclass, field, replace

from scenic_lite.errors import ScenicError


@dataclass(frozen=True)
class Limits:
    """The limits of one program."""

    steps: int = 200_000  # evaluations of tree nodes, also repeated ones in loops and calls
    calls: int = 40  # nested function calls; Python's own stack allows only a few more
    elements: int = 100_000  # in one list, tuple, dict or range
    memory: int = 10_000_000  # total of created elements and characters
    characters: int = 1_000_000  # in one text
    bits: int = 4096  # in one integer
    objects: int = 400  # every pair of objects is tested for overlap
    draws: int = 2000  # random values
    operations: int = 20_000  # operations on random values; each costs one array operation per batch
    scene: int = 20_000  # steps per scene of a condition that is evaluated scene by scene
    scenes: int = 2_000_000  # such steps in all scenes of one call of Program: a few seconds


@dataclass
class Budget:
    """Counts the resources of a load; each method raises ScenicError of kind `budget` when a limit is exceeded."""

    limits: Limits = field(default_factory=Limits)
    steps: int = 0
    memory: int = 0
    calls: int = 0
    scenes: int = 0  # steps of scene-by-scene evaluation since `new_call`
    task: str = "to load"

    def step(self) -> None:
        self.steps += 1
        if self.steps > self.limits.steps:
            raise exceeded(f"the program takes more than {self.limits.steps:,} steps {self.task}")

    def round(self) -> None:
        """Count one iteration of a potentially infinite loop."""
        self.step()

    def new_call(self, scenes: int = 0) -> None:
        """Reset the count of scene-by-scene evaluation; many requested scenes may be rejected and allow extra steps."""
        self.scenes = -scenes * self.limits.scene // 4

    def scene(self) -> Budget:
        """Return the budget for the evaluation of one scene."""
        return Budget(replace(self.limits, steps=self.limits.scene), task="in one scene")

    def charge(self, scene: Budget) -> None:
        """Count the steps of one scene."""
        self.scenes += scene.steps
        if self.scenes > self.limits.scenes:
            raise exceeded(
                f"conditions evaluated scene by scene take more than {self.limits.scenes:,} steps in all scenes"
            )

    def enter(self) -> None:
        self.calls += 1
        if self.calls > self.limits.calls:
            raise exceeded(f"functions call each other more than {self.limits.calls} deep")

    def leave(self) -> None:
        self.calls -= 1

    def keep(self, value: object) -> None:
        """Count a new value against the limits."""
        if isinstance(value, str):
            self.text(len(value))
        elif isinstance(value, int):
            self.integer(value.bit_length())
        elif isinstance(value, list | tuple | dict):
            self.container(len(value))

    def container(self, length: int) -> None:
        if length > self.limits.elements:
            raise exceeded(f"a collection of {length:,} elements; at most {self.limits.elements:,} are allowed")
        self.spend(length)

    def grow(self, container: Sized, count: int) -> None:
        """Count elements that are added to a container."""
        self.container(len(container) + count)
        self.memory -= len(container)

    def whole(self, value: object) -> None:
        """Count the elements that Python visits to compare or hash a value, with every visit to a shared part."""
        if not isinstance(value, list | tuple | dict):
            return
        count, pending = 0, [value]
        while pending:
            container = pending.pop()
            count += len(container)
            if count > self.limits.elements:
                raise exceeded(f"a collection whose parts hold more than {self.limits.elements:,} elements in all")
            parts = container.values() if isinstance(container, dict) else container
            pending += [part for part in parts if isinstance(part, list | tuple | dict)]
        self.spend(count)

    def text(self, length: int) -> None:
        if length > self.limits.characters:
            raise exceeded(f"a text of {length:,} characters; at most {self.limits.characters:,} are allowed")
        self.spend(length)

    def integer(self, bits: int) -> None:
        if bits > self.limits.bits:
            raise exceeded(f"an integer of more than {self.limits.bits:,} bits")

    def repeated(self, value: Sized, count: int) -> None:
        """Check `value * count` before it is computed."""
        length = len(value) * max(0, count)
        if isinstance(value, str):
            self.text(length)
        else:
            self.container(length)

    def spend(self, amount: int) -> None:
        self.memory += amount
        if self.memory > self.limits.memory:
            raise exceeded(f"more than {self.limits.memory:,} elements and characters are made in all")


def exceeded(what: str) -> ScenicError:
    """Return the error for an exceeded limit; the caller adds the place of the error."""
    return ScenicError("budget", f"evaluation budget exceeded: {what}")
