"""Compose blocks for comparing the machine with the reference: each uses one part of modular scenarios.

What stands before a line of dashes is written before the main scenario.
"""

PARTS = """class Thing(Object):
    level: 0
behavior Loop(w):
    while True:
        take w
behavior Show():
    while True:
        take f"{self.level:.4g}"
behavior Low():
    invariant: self.position.y < 6
    take 'low'
    take 'low again'
monitor Pay(amount):
    while True:
        simulation().scenic_reward = amount
        wait
monitor Stop(n):
    for i in range(n):
        wait
    terminate
ego = new Thing at 0 @ 0, with behavior Loop('base'), with requireVisible False
mate = new Thing at 4 @ Range(0, 3), with behavior Show(), with requireVisible False
foe = new Thing at -4 @ 1, with requireVisible False
scenario Part(w, n):
    setup:
        override ego with behavior Loop(w)
        terminate after n steps
scenario Level(n):
    setup:
        override mate with level n
"""

BODIES = {
    "sequence": """
do Part('a', 2)
wait
do Part('b', 3)
""",
    "parallel": """
do Part('a', 4), Level(3), Level(mate.position.y) for 3 steps
do Level(1) for 2 steps
""",
    "parallel overrides": """
for i in range(2):
    do Part('a', 1), Part('b', 3), Part('c', 2)
wait
wait
""",
    "choose": """
for i in range(4):
    do choose {Part('a', 1): 1, Part('b', 2): 3}
do choose Part('c', 1), Part('d', 1)
""",
    "choose before its condition": """
do choose Part('a', 3), Part('b', 3) until ego.position.y < 1
wait
""",
    "shuffle": """
do shuffle Part('a', 1), Part('b', 2), Part('c', 3) for 4 steps
""",
    "a random one": """
do Uniform(Part('a', 2), Part('b', 3), Level(2)) for 3 steps
wait
""",
    "one in a variable": """
part = Part('a', 2)
if mate.position.y > 1.5:
    part = Part('b', 3)
do part
wait
""",
    "interrupts": """
try:
    do Part('a', 9)
interrupt when ego.position.y % 3 == 2:
    do Part('b', 1)
interrupt when ego.position.y == 7:
    do Level(2), Part('c', 2) for 2 steps
    abort
wait
""",
    "a break out of an interrupted scenario": """
while True:
    try:
        do Part('a', 9)
    interrupt when ego.position.y > 3:
        wait
        break
wait
wait
""",
    "continue": """
for i in range(3):
    try:
        do Part('a', 9), Level(i + 1)
    interrupt when ego.position.y % 2 == 1:
        wait
        continue
wait
""",
    "return": """
try:
    do Part('a', 9)
interrupt when ego.position.y > 2:
    return
wait
""",
    "a condition on a variable of the block": """
flag = 0
try:
    wait for 2 steps
    flag = ego.position.y
    wait for 4 steps
interrupt when flag > 0 and ego.position.y > 3:
    flag = -1
    do Part('h', 2)
wait
""",
    "terminate": """
do Part('a', 2)
terminate
wait
""",
    "terminate simulation inside": """
scenario End():
    compose:
        wait
        terminate simulation
---
do Part('a', 9), End(), Level(2)
wait
""",
    "terminate inside": """
scenario End():
    compose:
        wait
        terminate
---
do End(), Level(2) for 4 steps
wait
""",
    "monitors inside end the match": """
scenario Timed(n):
    setup:
        override ego with behavior Loop('t')
        require monitor Stop(n)
        require monitor Pay(n)
---
do Timed(4) for 3 steps
do Timed(4), Timed(2)
wait
""",
    "monitors in a compose block": """
require monitor Pay(5)
wait
do Part('a', 2)
require monitor Stop(3)
wait for 9 steps
""",
    "conditions of what the match decides": """
scenario Maybe(n):
    setup:
        if ego.position.y > 2:
            override ego with behavior Loop('m')
        big = n > 2
        terminate after (2 if big else 9) steps
        record n as big
        require monitor Pay(n)
        terminate when not big and ego.position.y > n
---
for i in [1, 3, 8]:
    do Maybe(i)
    wait
""",
    "a time limit drawn once": """
scenario Drawn():
    setup:
        override ego with behavior Loop(f'{Range(0, 1):.6g}')
        terminate after DiscreteRange(1, 5) steps
---
for i in range(3):
    do Drawn()
    wait
""",
    "requirements of a scenario": """
scenario Careful(n):
    setup:
        require always ego.position.y < n
        require eventually ego.position.y > 2
---
do Careful(9) for 4 steps
do Careful(12) for 3 steps
do Careful(mate.position.y + 8) for 9 steps
""",
    "a requirement that does not come true": """
scenario Careful():
    setup:
        require eventually ego.position.y > 5
---
do Careful() for 4 steps
wait
""",
    "a requirement in a compose block": """
x = 7
wait
require always ego.position.y < x
x = 99
do Part('a', 20)
""",
    "guards": """
scenario Early(n):
    precondition: ego.position.y < 3
    invariant: ego.position.y < n
    setup:
        override ego with behavior Loop('e')
---
do choose Early(20), Part('p', 1)
wait
wait
wait
""",
    "an invariant": """
scenario Early(n):
    invariant: ego.position.y < n
    compose:
        while True:
            wait
---
do Early(5)
""",
    "guards of behaviors": """
scenario Lower():
    setup:
        override ego with behavior Low()
---
do Lower() for 2 steps
do Part('a', 3)
do Lower() for 9 steps
""",
    "a behavior that ends": """
scenario Lower():
    setup:
        override foe with behavior Low()
---
do Lower() for 4 steps
wait
do Lower() for 1 steps
wait
""",
    "no behavior": """
scenario Nobody():
    setup:
        override ego with behavior None
---
wait
do Nobody() for 2 steps
wait
""",
    "variables": """
scenario Count(n):
    setup:
        total = n
        record total as total
        terminate when total > 5
    compose:
        while True:
            total += DiscreteRange(1, 2)
            do Part(f'{total:.4g}', 1)
---
c = Count(1)
do c
for i in range(2):
    do Count(i)
""",
    "draws": """
scenario Drawn():
    setup:
        x = Range(0, 5)
        override ego with behavior Loop(f'{x:.6g}')
        terminate when ego.position.y > x
---
do Drawn()
do Drawn() for DiscreteRange(1, 4) steps
wait
""",
    "an ego of its own": """
scenario Other():
    setup:
        ego = mate
        override ego with behavior Loop('other')
        record ego.position.x as x
        terminate when ego.position.y > 5
    compose:
        wait
        do Part('inner', 2)
        wait for 9 steps
---
do Other()
do Part('a', 2)
""",
    "over all": """
scenario All():
    setup:
        for each in [ego, mate, foe]:
            override each with behavior Loop('all')
---
do All() for 2 steps
wait
""",
}

RECORDS = """scenario Kept(n):
    setup:
        record ego.position as place
        record [o.position.y for o in [ego, mate, foe] if o.position.y > n] as high
        record f"{ego.position.y:.4g} of {n:.4g}" as words
        record (min([ego, mate, foe], key=lambda o: abs(o.position.y - 3)), n) as near
        record n as n
        record ego.position.y > n as above
"""
TOP = """record kind as kind
record initial mate.position.y as first
record final mate.position.y + mate.level as last
record ego.position.y * 2 as twice
"""


def program(name: str) -> str:
    """Return the text of one program."""
    before, _, compose = BODIES[name].strip("\n").rpartition("---\n")
    return PARTS + before + main(compose)


def main(compose: str, setup: str = "") -> str:
    """Return the main scenario with a compose block and perhaps a setup."""
    text = "scenario Main():\n"
    text += "    setup:\n" + indented(setup) if setup else ""
    return text + "    compose:\n" + indented(compose)


def indented(lines: str) -> str:
    return "".join(f"        {line}\n" for line in lines.strip("\n").splitlines())
