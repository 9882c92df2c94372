"""Random modular scenarios, for comparing the compiled path with the reference: scenarios inside each other, sequences,
several at once, interrupts, overrides, monitors, conditions, requirements, records.

Every program is a text that a person could have written; a seed makes always the same one.
"""

from __future__ import annotations

import random

OBJECTS = ("ego", "mate", "foe")
LEVELS = (1, 2, 2, 3)  # scenarios of one level run those of the levels below


class Generator:
    """Writes one program."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.lines: list[str] = []
        self.numbers = 0
        self.scenarios: list[list[str]] = []  # by level, each with one parameter

    def pick(self, *options: str) -> str:
        return self.random.choice(options)

    def chance(self, probability: float) -> bool:
        return self.random.random() < probability

    def write(self, indent: int, text: str) -> None:
        self.lines.append("    " * indent + text)

    def number(self) -> int:
        self.numbers += 1
        return self.numbers

    # ------------------------------------------------------------ expressions

    def value(self, names: list[str]) -> str:
        leaves = [str(self.random.randrange(0, 6)), f"{self.thing()}.position.y", f"{self.thing()}.level", "kind"]
        leaves += names * 2
        a, b = self.pick(*leaves), self.pick(*leaves)
        drawn = ["DiscreteRange(0, 3)", "Range(0, 4)", "Uniform(1, 2, 5)"] if self.chance(0.15) else []
        return self.pick(a, a, f"({a} + {b})", f"({a} * 0.5)", f"max({a}, {b})", f"({a} % 3)", *drawn)

    def thing(self) -> str:
        return self.pick(*OBJECTS)

    def truth(self, names: list[str]) -> str:
        a, b = self.value(names), self.value(names)
        simple = [
            f"{a} {self.pick('<', '<=', '>', '>=')} {b}",
            f"ego.position.y % {self.random.randrange(2, 6)} == {self.random.randrange(2)}",
            f"ego.position.y >= {self.random.randrange(2, 12)}",
            f"simulation().currentTime >= {self.random.randrange(2, 12)}",
        ]
        first, second = self.pick(*simple), self.pick(*simple)
        return self.pick(first, first, f"({first} and {second})", f"({first} or {second})", f"not ({first})")

    # ------------------------------------------------------------ scenarios

    def call(self, level: int, names: list[str]) -> str:
        name = self.pick(*self.scenarios[self.random.randrange(level)])
        return f"{name}({self.value(names)})"

    def scenario(self, level: int, number: int) -> str:
        """Write a scenario with a setup, and a compose block unless it is of the lowest level; return its name."""
        name = f"S{level}{number}"
        self.write(0, f"scenario {name}(x):")
        if self.chance(0.2):
            self.write(1, f"precondition: {self.truth(['x'])} or ego.position.y < {self.random.randrange(16)}")
        if self.chance(0.15):
            self.write(1, f"invariant: {self.truth(['x'])} or ego.position.y < 9")
        self.write(1, "setup:")
        names = ["x"]
        self.setup(2, names, name)
        if level > 0 or self.chance(0.3):
            self.write(1, "compose:")
            self.block(2, names, 2, level)
            self.write(2, "wait")
        return name

    def setup(self, indent: int, names: list[str], name: str) -> None:
        if self.chance(0.4):
            self.write(indent, f"y = {self.value(names)}")
            names.append("y")
        for _ in range(self.random.randrange(1, 4)):
            self.setting(indent, names, name)
        if self.chance(0.6):
            self.write(indent, f"terminate after {self.random.randrange(1, 6)} steps")

    def setting(self, indent: int, names: list[str], name: str) -> None:
        """Write one statement of a setup; in a branch one that happens at once."""
        thing, number = self.thing(), self.number()
        forms = [
            f"override {thing} with behavior Loop(f'{name}{{{self.value(names)}:.4g}}')",
            f"override {thing} with behavior Loop('{name}')",
            f"override {thing} with behavior Count({self.value(names)})",
            f"override {thing} with behavior Guarded({self.value(names)})",
            f"override {thing} with level {self.value(names)}",
            f"override {thing} with level {self.value(names)}, with behavior Loop('L')",
            f"terminate when {self.truth(names)}",
            f"terminate when {self.truth(names)}",
            f"record {self.value(names).replace('kind', 'x')} as r{number}",
            f"record ego.position as r{number}",
            f"require monitor Pay({self.value(names)})",
        ]
        if self.chance(0.25):
            forms = [
                f"require always {self.truth(names)} or ego.position.y < 9",
                f"require eventually {self.truth(names)} or ego.position.y >= 0",
                f"require (ego.position.y < 3) until ({self.truth(names)} or ego.position.y > 3)",
                f"require ({self.truth(names)}) implies next (ego.position.y > 1 or simulation().currentTime < 3)",
                f"require monitor Halt({self.random.randrange(3, 14)})",
                f"require monitor Stop({self.random.randrange(1, 12)})",
                f"terminate simulation when ego.position.y > {self.random.randrange(6, 20)}",
                f"override {thing} with behavior None",
                f"override {thing} with behavior Ends({self.random.randrange(2, 9)})",
                f"require {self.truth(names)} or ego.position.y < 8",
            ]
        if self.chance(0.15):
            self.write(indent, f"if {self.truth(names)}:")
            indent += 1
            forms = [form for form in forms if form.startswith("override")]
        self.write(indent, self.pick(*forms))

    # ------------------------------------------------------------ compose blocks

    def block(self, indent: int, names: list[str], depth: int, level: int, loop: bool = False) -> None:
        names = list(names)
        for _ in range(self.random.randrange(1, 4)):
            if self.statement(indent, names, depth, level, loop):
                return

    def statement(self, indent: int, names: list[str], depth: int, level: int, loop: bool) -> bool:
        """Write one statement; return whether nothing can follow it."""
        roll = self.random.random()
        if level > 0 and (roll < 0.5 or depth == 0):
            self.do(indent, names, level)
        elif roll < 0.6 or depth == 0:
            self.write(indent, self.pick("wait", f"wait for {self.random.randrange(1, 3)} steps", "wait"))
        elif roll < 0.7:
            self.assign(indent, names)
        elif roll < 0.78:
            self.write(indent, f"if {self.truth(names)}:")
            self.block(indent + 1, names, depth - 1, level, loop)
            if self.chance(0.5):
                self.write(indent, "else:")
                self.block(indent + 1, names, depth - 1, level, loop)
        elif roll < 0.85:
            self.repeat(indent, names, depth, level)
        elif roll < 0.96:
            self.attempt(indent, names, depth, level, loop)
        else:
            self.write(indent, self.leaving(loop))
            return True
        return False

    def leaving(self, loop: bool) -> str:
        options = ["return", "terminate", "terminate simulation"]
        return self.pick(*options, *(["break", "continue"] * 3 if loop else []))

    def assign(self, indent: int, names: list[str]) -> None:
        if "y" in names and self.chance(0.5):
            self.write(indent, f"y = {self.value(names)}")
            return
        name = f"v{self.number()}"
        self.write(indent, f"{name} = {self.value(names)}")
        names.append(name)

    def do(self, indent: int, names: list[str], level: int) -> None:
        a, b = self.call(level, names), self.call(level, names)
        c = self.call(level, names)
        forms = [f"do {a}", f"do {a}", f"do {a}, {b}", f"do {a}, {b}, {c}"]
        forms += [f"do choose {a}, {b}", f"do shuffle {a}, {b}"]
        forms += [f"do choose {{{a}: 1, {b}: {self.random.randrange(1, 4)}}}", f"do Uniform({a}, {b})"]
        limits = ["", "", f" for {self.random.randrange(1, 5)} steps", f" until {self.truth(names)}"]
        form = self.pick(*forms)
        self.write(indent, form + (self.pick(*limits) if "Uniform" not in form else ""))

    def repeat(self, indent: int, names: list[str], depth: int, level: int) -> None:
        counter = f"n{self.number()}"
        if self.chance(0.5):
            self.write(indent, f"for {counter} in range({self.random.randrange(1, 4)}):")
        else:
            self.write(indent, f"{counter} = 0")
            self.write(indent, f"while {counter} < {self.random.randrange(1, 4)} and ({self.truth(names)}):")
            self.write(indent + 1, f"{counter} += 1")
        self.block(indent + 1, [*names, counter], depth - 1, level, True)
        self.write(indent + 1, "wait")

    def attempt(self, indent: int, names: list[str], depth: int, level: int, loop: bool) -> None:
        self.write(indent, "try:")
        self.block(indent + 1, names, depth - 1, level, loop)
        for _ in range(self.random.randrange(1, 3)):
            self.write(indent, f"interrupt when {self.truth(names)}:")
            self.write(indent + 1, "wait")
            if self.chance(0.6):
                self.block(indent + 1, names, depth - 1, level, loop)
            if self.chance(0.3):
                self.write(indent + 1, "abort")

    # ------------------------------------------------------------ the program

    def program(self) -> str:
        self.lines = [*HEADER.splitlines(), *OBJECTS_OF_ALL.splitlines()]
        levels = self.random.choice(LEVELS)
        for level in range(levels):
            names = [self.scenario(level, number) for number in range(3 if level == 0 else 2)]
            self.scenarios.append(names)
        self.write(0, "scenario Main():")
        if self.chance(0.15):
            self.write(1, f"invariant: {self.truth([]).replace('kind', '1')} or ego.position.y < 9")
        self.write(1, "setup:")
        self.write(2, "y = kind + 1")
        for kind in ("initial", "final"):
            if self.chance(0.4):
                self.write(2, f"record {kind} ego.position.y + mate.level as {kind}")
        if self.chance(0.3):
            self.write(2, f"record {self.truth(['y'])} as holds")
        if self.chance(0.3):
            self.write(2, f"terminate when {self.truth(['y'])} and ego.position.y > 5")
        if self.chance(0.2):
            self.write(2, f"require eventually ego.position.y > {self.random.randrange(2, 9)}")
        if self.chance(0.2):
            self.write(2, f"require monitor Stop({self.random.randrange(6, 16)})")
        self.write(1, "compose:")
        self.block(2, ["y"], 3, levels)
        self.block(2, ["y"], 2, levels)
        self.write(2, "wait")
        return "\n".join(self.lines) + "\n"


HEADER = """class Thing(Object):
    level: 0
kind = DiscreteRange(0, 2)
behavior Loop(w):
    while True:
        take w
behavior Count(n):
    while True:
        n += 1
        take f"n{n:.4g} {self.level:.4g}"
        if n % 3 == 0:
            wait
behavior Guarded(n):
    precondition: self.position.y + n > -1
    invariant: self.position.y < 40
    for i in range(4):
        take f"g{i} {n:.4g}"
behavior Ends(n):
    while simulation().currentTime < n:
        take 'e'
    terminate
monitor Stop(n):
    for i in range(n):
        wait
    terminate
monitor Halt(n):
    for i in range(n):
        wait
    terminate simulation
monitor Pay(v):
    while True:
        simulation().scenic_reward = v
        wait"""
OBJECTS_OF_ALL = """ego = new Thing at 0 @ 0, with behavior Loop('base'), with requireVisible False
mate = new Thing at 4 @ Range(0, 3), with behavior Count(kind), with requireVisible False
foe = new Thing at -4 @ 1, with requireVisible False"""


def program(seed: int) -> str:
    """Return the text of one program."""
    return Generator(seed).program()
