"""Random programs with behaviors, for comparing the compiled path with the reference: nested interrupts, loops, draws.

Every program is a text that a person could have written; a seed makes always the same one.
"""

from __future__ import annotations

import random

OBJECTS = ("ego", "mate", "foe")


class Generator:
    """Writes one program."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.lines: list[str] = []
        self.taken = 0
        self.functions = 0
        self.numbers = 0
        self.loops = 0

    def pick(self, *options: str) -> str:
        return self.random.choice(options)

    def chance(self, probability: float) -> bool:
        return self.random.random() < probability

    # ------------------------------------------------------------ expressions

    def number(self, names: list[str], depth: int = 2) -> str:
        """Return a number of some kind."""
        if depth == 0 or self.chance(0.3):
            return self.leaf(names)
        a, b = self.number(names, depth - 1), self.number(names, depth - 1)
        forms = [
            f"({a} + {b})",
            f"({a} - {b})",
            f"({a} * 0.5)",
            f"({a} / (1 + abs({b})))",
            f"({a} // 2)",
            f"({a} % 3)",
            f"min({a}, {b})",
            f"max({a}, {b})",
            f"abs({a})",
            f"round({a})",
            f"int({a})",
            f"(-{a})",
            f"({a} if {self.truth(names, depth - 1)} else {b})",
            f"near({a}, {b})",
            f"pick_first({a}, {b})",
            f"(distance from self to {self.thing()})",
            f"(angle from self to {self.thing()})",
            f"len([o for o in things if o.position.y > {a}])",
            f"sum([{b}, {a}, 1])",
            f"len([o.position.y for o in things if o.position.x < {a}])",
            f"[{a}, {b}, 2][{self.random.randrange(3)}]",
            f"sorted([{a}, {b}, 0.5])[1]",
            f"sum([{a}, {b}, 3, self.position.y][{self.random.randrange(-3, 3)}:])",
            f"max([o.position.y for o in things if o.position.y > {a}], key=lambda y: y, default=0)",
            f"abs({a}) ** 0.5",
            f"(ego.shared + {a})",
            "len(ego.log)",
            f"({self.nearest(a)}).position.y",
            f"sqrt(abs({a}))",
            f"sin({a})",
            f"({a} deg)",
            f"[o for o in things if o is ego or o.position.y > {a}][-1].position.x",
            "max([o.position.y for o in things])",
        ]
        return self.pick(*forms)

    def nearest(self, key: str) -> str:
        return self.pick(
            f"min(things, key=lambda o: abs(o.position.y - {key}))",
            f"max(things, key=lambda o: distance from o to ({key} @ 1))",
            f"sorted(things, key=lambda o: -o.position.y)[{self.random.randrange(3)}]",
            f"closest(self, {key})",
        )

    def leaf(self, names: list[str]) -> str:
        forms = [
            str(self.random.randrange(-2, 6)),
            f"{self.random.uniform(-2, 5):.2f}",
            "self.position.y",
            f"{self.thing()}.position.x",
            f"{self.thing()}.position.y",
            "simulation().currentTime",
            "speed",
            "kind",
        ]
        if names:
            forms += names * 3
        if self.chance(0.12):
            forms = ["Range(0, 4)", "DiscreteRange(0, 3)", "Uniform(1, 2, 5)", "Normal(1, 2)", "Discrete({1: 2, 4: 1})"]
        return self.pick(*forms)

    def thing(self) -> str:
        return self.pick("self", *OBJECTS)

    def truth(self, names: list[str], depth: int = 2) -> str:
        """Return a condition."""
        if depth == 0 or self.chance(0.4):
            a, b = self.number(names, max(0, depth - 1)), self.number(names, 0)
            return self.pick(
                f"{a} {self.pick('<', '<=', '>', '>=', '==', '!=')} {b}",
                f"{b} < {a} <= {b} + 3",
                f"self.position.y % {self.random.randrange(2, 5)} == {self.random.randrange(2)}",
                f"simulation().currentTime >= {self.random.randrange(8)}",
                f"({a} @ {b}) in area",
                f"self is {self.thing()}",
                f"any([o.position.y > {a} for o in things])",
                f"all([o.position.y < {a} for o in things])",
                f"word == '{self.pick('up', 'down')}'",
                f"closest(self, {a}) is {self.thing()}",
                f"lane(self, {a}).containsPoint({self.thing()}.position)",
            )
        a, b = self.truth(names, depth - 1), self.truth(names, depth - 1)
        return self.pick(f"({a} and {b})", f"({a} or {b})", f"not ({a})", f"({a} if {b} else {self.truth(names, 0)})")

    # ------------------------------------------------------------ statements

    def write(self, indent: int, text: str) -> None:
        self.lines.append("    " * indent + text)

    def block(self, indent: int, names: list[str], depth: int, loop: bool = False, handler: bool = False) -> None:
        """Write some statements; `names` are the variables that have a value."""
        names = list(names)
        for _ in range(self.random.randrange(1, 4)):
            if self.statement(indent, names, depth, loop, handler):
                return

    def statement(self, indent: int, names: list[str], depth: int, loop: bool, handler: bool) -> bool:
        """Write one statement; return whether nothing can follow it."""
        roll = self.random.random()
        if depth == 0 or roll < 0.3:
            self.act(indent, names)
        elif roll < 0.45:
            self.assignment(indent, names)
        elif roll < 0.58:
            self.branch(indent, names, depth, loop, handler)
        elif roll < 0.66:
            self.while_loop(indent, names, depth, handler)
        elif roll < 0.73:
            self.for_loop(indent, names, depth, handler)
        elif roll < 0.85:
            self.attempt(indent, names, depth, loop)
        elif roll < 0.95:
            self.sub(indent, names)
        else:
            return self.leave(indent, loop, handler)
        return False

    def act(self, indent: int, names: list[str]) -> None:
        self.taken += 1
        word = f"{self.pick('a', 'b', 'c')}{self.taken}"
        shown = self.pick(f"{{{self.number(names)}:.6g}}", *(f"{{{each}:.6g}}" for each in names)) if names else ""
        self.write(
            indent,
            self.pick(
                f'take f"{word}{shown}"',
                f'take f"{word}{shown}"',
                f"take '{word}', 'x'",
                f"take word + '{word}'",
                "wait",
                f"take ({self.number(names, 1)}) * 1.0",
            ),
        )

    def assignment(self, indent: int, names: list[str]) -> None:
        roll = self.random.random()
        if self.chance(0.12):
            self.change(indent, names)
        elif names and roll < 0.3:
            self.write(indent, f"{self.pick(*names)} {self.pick('+=', '-=', '*=')} {self.number(names, 1)}")
        elif names and roll < 0.6:
            self.write(indent, f"{self.pick(*names)} = {self.number(names)}")
        elif len(names) > 1 and roll < 0.7:
            a, b = self.random.sample(names, 2)
            self.write(indent, f"{a}, {b} = {b}, {self.number([a], 1)}")
        else:
            self.numbers += 1
            self.write(indent, f"v{self.numbers} = {self.number(names)}")
            names.append(f"v{self.numbers}")

    def change(self, indent: int, names: list[str]) -> None:
        """Write what changes a variable that all behaviors see, or a list that they share."""
        number = self.number(names, 1)
        self.write(indent, self.pick(f"bump({number})", f"ego.log.append({number})", f"ego.log.append({number})"))
        if self.chance(0.5):
            self.write(indent, f"if len(ego.log) > {self.random.randrange(1, 6)}:")
            self.write(indent + 1, self.pick("bump(ego.log[0])", "bump(ego.log[-1])", f"bump(max(ego.log) + {number})"))

    def branch(self, indent: int, names: list[str], depth: int, loop: bool, handler: bool) -> None:
        self.write(indent, f"if {self.truth(names)}:")
        self.block(indent + 1, names, depth - 1, loop, handler)
        if self.chance(0.3):
            self.write(indent, f"elif {self.truth(names)}:")
            self.block(indent + 1, names, depth - 1, loop, handler)
        if self.chance(0.5):
            self.write(indent, "else:")
            self.block(indent + 1, names, depth - 1, loop, handler)

    def while_loop(self, indent: int, names: list[str], depth: int, handler: bool) -> None:
        self.loops += 1
        counter = f"n{self.loops}"
        self.write(indent, f"{counter} = 0")
        self.write(indent, f"while {counter} < {self.random.randrange(1, 6)} and ({self.truth(names)}):")
        self.write(indent + 1, f"{counter} += 1")
        self.block(indent + 1, [*names, counter], depth - 1, True, handler)

    def for_loop(self, indent: int, names: list[str], depth: int, handler: bool) -> None:
        self.loops += 1
        roll = self.random.random()
        if roll < 0.5:
            name = f"i{self.loops}"
            self.write(indent, f"for {name} in range({self.random.randrange(1, 5)}):")
            self.block(indent + 1, [*names, name], depth - 1, True, handler)
        elif roll < 0.8:
            name = f"p{self.loops}"
            self.write(indent, f"for {name} in things:")
            self.write(indent + 1, f"if {name}.position.y > {self.number(names, 1)}:")
            first = self.pick("break", "continue", f"take f'{name}{{{name}.position.x:.6g}}'")
            self.write(indent + 2, first)
            lines = len(self.lines)
            self.block(indent + 1, names, depth - 1, True, handler)
            left = any(line.strip() == "break" for line in (first, *self.lines[lines:]))
            if self.chance(0.5) and not left:  # what it is after a `break` only the reference can tell
                self.write(indent, f"take f'last{{{name}.position.x:.6g}}'")
        else:
            name = f"q{self.loops}"
            self.write(indent, f"for {name} in [o for o in things if o.position.y < {self.number(names, 1)}]:")
            self.write(indent + 1, f"take f'{name}{{{name}.position.x:.6g}}'")

    def attempt(self, indent: int, names: list[str], depth: int, loop: bool) -> None:
        self.write(indent, "try:")
        self.block(indent + 1, names, depth - 1, loop)
        for _ in range(self.random.randrange(1, 3)):
            self.write(indent, f"interrupt when {self.truth(names)}:")
            self.act(indent + 1, names)
            if self.chance(0.4):
                self.block(indent + 1, names, depth - 1, loop, True)
            elif self.chance(0.2):
                self.write(indent + 1, "abort")

    def sub(self, indent: int, names: list[str]) -> None:
        call = f"Sub{self.random.randrange(3)}({self.number(names, 1)})"
        other = f"Sub{self.random.randrange(3)}({self.number(names, 1)})"
        self.write(
            indent,
            self.pick(
                f"do {call}",
                f"do {call} until {self.truth(names)}",
                f"do {call} for {self.random.randrange(1, 4)} steps",
                f"do choose {call}, {other}",
                f"do shuffle {call}, {other}",
                f"do choose {{{call}: 1, {other}: {self.random.randrange(1, 4)}}}",
                f"wait until {self.truth(names)}",
                f"wait for {self.random.randrange(1, 3)} steps",
                f"do Uniform({call}, {other})",
            ),
        )

    def leave(self, indent: int, loop: bool, handler: bool) -> bool:
        options = ["return", "terminate"]
        if loop:
            options += ["break", "continue"] * 3
        if handler:
            options += ["abort"] * 3
        self.write(indent, self.pick(*options))
        return True

    # ------------------------------------------------------------ the program

    def program(self) -> str:
        self.lines = HEADER.splitlines()
        for number in range(3):
            self.write(0, f"behavior Sub{number}(x):")
            if self.chance(0.3):
                self.write(1, f"precondition: {self.truth(['x'], 1)}")
            if self.chance(0.2):
                self.write(1, f"invariant: {self.truth([], 1)} or self.position.y < 9")
            self.write(1, f"take f's{number}{{x:.6g}}'")
            self.block_without_subs(1, ["x"])
        for number in range(2):
            self.write(0, f"behavior Main{number}(a, b=2):")
            self.block(1, ["a", "b"], 3)
            self.block(1, ["a", "b"], 2)
            self.write(1, "take 'end'")
        watched = self.chance(0.5)
        if watched:
            self.monitor()
        self.lines += FOOTER.splitlines()
        if self.chance(0.3):
            self.write(0, f"terminate when {self.truth([], 1).replace('self', 'mate')}")
        if watched:
            self.write(0, "require monitor Watch()")
        return "\n".join(self.lines) + "\n"

    def block_without_subs(self, indent: int, names: list[str]) -> None:
        names = list(names)
        self.assignment(indent, names)
        self.write(indent, f"if {self.truth(names)}:")
        self.act(indent + 1, names)
        self.write(indent, "else:")
        self.assignment(indent + 1, list(names))
        self.act(indent + 1, names)

    def monitor(self) -> None:
        condition = self.truth([], 1).replace("self", "foe")
        self.write(0, "monitor Watch():")
        self.write(1, "while True:")
        self.write(2, f"if {condition}:")
        self.write(3, f"simulation().scenic_reward = {self.number([], 1).replace('self', 'foe')}")
        self.write(2, "wait")


HEADER = """def bump(x):
    ego.shared = ego.shared / 2 + x
def near(a, b):
    if a < b:
        c = a + 1
        return c
    c = b
    for k in range(3):
        if c > 4:
            return k
        c += a * 0.5
    return c
def pick_first(a, b):
    return [z for z in [a, b, 7] if z > 1][0]
def closest(me, d):
    best = None
    gap = 1000
    for o in [ego, mate, foe]:
        if o is me:
            continue
        g = abs((distance from me to o) - d)
        if best is None or g < gap:
            best = o
            gap = g
    return best
def lane(me, r):
    return SectorRegion(me.position, 3 + abs(r), 0.3, 1.5)
area = RectangularRegion(1 @ 2, 0.2, 4, 5)
speed = Range(0, 3)
kind = DiscreteRange(0, 2)
word = Uniform('up', 'down')"""
FOOTER = """ego = new Object at 0 @ 0, with behavior Main0(speed + 1), with requireVisible False,
    with shared 0, with log []
mate = new Object at 4 @ Range(2, 4), with behavior Main1(3, kind), with requireVisible False
foe = new Object at -4 @ 1, with requireVisible False
things = [ego, mate, foe]"""


def program(seed: int) -> str:
    """Return the text of one program."""
    return Generator(seed).program()
