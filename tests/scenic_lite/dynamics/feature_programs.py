"""Small programs, each about one thing that a behavior can do; together they use every opcode of the machine."""

OBJECTS = """
ego = new Object at 0 @ 0, with behavior Main(), with requireVisible False
mate = new Object at 4 @ Range(0, 3), with requireVisible False
foe = new Object at -4 @ 1, with requireVisible False
things = [ego, mate, foe]
"""
BODIES = {
    "arithmetic": """
    y = self.position.y + 1
    for i in range(4):
        y = -(y + 2 * i - 1) / 2
        take f'{y // 1.5:.6g} {y % 2:.6g} {abs(y) ** 0.5:.6g} {min(y, i):.6g} {max(y, i):.6g} {round(y)} {int(y)}'
        y = y - mate.position.y
""",
    "functions": """
    import math
    while True:
        x = self.position.y / 16 - 0.3
        take f'{sin(x):.9g} {cos(x):.9g} {math.exp(x):.9g} {math.log(x + 2):.9g}'
        take f'{math.floor(x)} {math.ceil(x)} {round(x)}'
        take f'{sqrt(x + 1):.9g} {math.atan2(x, 1):.9g} {hypot(x, 2):.9g} {normalizeAngle(x * 40):.9g}'
""",
    "comparisons": """
    while True:
        a, b = self.position.y, mate.position.y + 3
        less, at_most, same, other = a < b, a <= b, a == b, a != b
        take f'{less} {at_most} {same} {other} {a > b} {a >= b} {not less} {less and other} {less or same}'
        if a < b: take 'less'
        if a <= b: take 'at most'
        if a == 6: take 'same'
        if a != 6: take 'other'
        if not a < b: take 'not less'
        if not (a <= b): take 'not at most'
        if not (less and other): take 'neither'
""",
    "regions": """
    box = RectangularRegion(1 @ 3, 0.4, 6, 5)
    disc = CircularRegion(mate.position, 4)
    lane = SectorRegion(self.position, 8, 0.2, 1.2)
    home = PolygonalRegion([-5 @ 0, 5 @ 0, 3 @ 8, -3 @ 8])
    while True:
        spot = self.position + (0.4 @ -1.3)
        take f'{spot in box} {disc.containsPoint(spot)} {lane.containsPoint(mate.position)} {spot in home}'
        take f'{self intersects mate} {self can see foe} {mate can see (3 @ 4)}'
""",
    "draws": """
    for i in range(3):
        take f'{Range(1, 5):.9g} {DiscreteRange(2, 6)} {Normal(1, 2):.9g} {Uniform(1, 4, 9)} {Uniform("a", "b")}'
        take f'{Discrete({1: 2, 5: 1}):.9g} {Uniform(ego, mate, foe).position.x:.9g} {TruncatedNormal(1, 2, 0, 3):.9g}'
        spot = new Point in RectangularRegion(0 @ 0, 0.3, 2, 4)
        take f'{spot.position.x:.9g} {spot.position.y:.9g}'
        if Range(0, 1) < 0.5 and Range(0, 1) < 0.5:
            take 'both'
""",
    "lists": """
    far = []
    for i in range(12):
        near = [o for o in things if (distance from o to (1 @ i)) < 5 or o is foe]
        order = sorted(near, key=lambda o: -(distance from o to (0 @ 3)))
        first = min(near, key=lambda o: abs(o.position.y - i))
        far.append(first.position.y)
        take f'{len(near)} {order[0].position.x:.9g} {order[-1].position.y:.9g} {first.position.x:.9g} {len(far)}'
        take f'{max(far):.9g} {far[i // 2]:.9g} {mate in things} {any([o.position.y > i for o in things])}'
        numbers = [1, 5, i + 1]
        near.append(mate)
        take f'{numbers[0]} {sum(numbers[:2])} {[3, 1, 2][i % 3]} {sorted(numbers, reverse=True)[0]}'
""",
    "none": """
    best = None
    for o in things:
        if o.position.y > 2 + self.position.y / 2:
            best = o
            break
    take 'nobody' if best is None else f'{best.position.x:.9g}'
    least = None
    while True:
        if least is None or self.position.y - 3 < least:
            least = self.position.y - 3
        take f'{least:.9g}'
""",
    "interrupts": """
    count = 0
    try:
        while True:
            take f'body {count}'
            try:
                do Twice('x')
            interrupt when count > 3:
                take 'inner'
                count = 0
    interrupt when self.position.y % 5 == 2:
        count += 2
        take f'low {count}'
        if count > 8:
            abort
    interrupt when self.position.y == 7:
        do Twice('high') until count > 100
    take 'end'
""",
    "sub-behaviors": """
    do Twice('a')
    do Twice('b') for 1 steps
    do Forever() until self.position.y > 5
    do Forever() for 2 seconds
    do choose Twice('c'), Twice('d')
    do choose {Twice('e'): 1, Twice('f'): 3}
    do shuffle Twice('g'), Twice('h'), Twice('i')
    do Uniform(Twice('j'), Twice('k'))
    wait until self.position.y > 17
    wait for 1 steps
    take 'end'
""",
    "guards": """
    do choose Low(), High()
    do Low()
    take 'unreached'
""",
    "attributes": """
    self.count = 0
    mate.level = 1
    while True:
        self.count += 1
        if self.count % 2 == 0:
            mate.level += self.count
        simulation().scenic_reward = self.count - 2
        take f'{self.count} {mate.level}'
""",
    "functions of the program": """
    while True:
        gap, who = closest(self)
        take f'{gap:.9g} {who.position.x:.9g} {early(self.position.y)} {(lambda a, b=2: a * b)(gap):.9g}'
""",
    "last actions": """
    while True:
        take 'a', f'{self.position.y}'
        seen = self.lastActions
        take 'nothing' if len(seen) == 0 else seen[0]
""",
    "loops": """
    for i in range(5, 0, -2):
        for o in things:
            if o.position.y > i:
                continue
            if o is foe and i < 3:
                break
            take f'{i} {o.position.x:.9g}'
        else:
            take 'all'
    n = 0
    while n < 3:
        n += 1
        if n == 2:
            continue
        take f'n{n}'
    else:
        take 'through'
    for i in range(int(self.position.y)):
        if i > 1:
            return
        take f'i{i}'
""",
    "dictionaries": """
    words = {'up': 1, 'down': 2}
    while True:
        take f'{words["down"]} {words.get("up")} {{0: 5, 1: 6}}'
        take f'{({0: 5, 1: self.position.y})[1]:.9g}'
""",
    "vectors": """
    while True:
        a = self.position offset along 0.3 by 1 @ 2
        b = front of mate
        a, c = a + (1 @ 1), a
        take f'{a.x:.9g} {c.y:.9g} {(angle from a to c):.9g} {b.position.y:.9g} {(a - c).norm():.9g}'
        take f'{(relative heading of mate from self):.9g} {a.distanceTo(c):.9g} {(1 @ 2).rotatedBy(a.x).x:.9g}'
""",
}
DEFINITIONS = """
word = Uniform('up', 'down')
behavior Twice(w):
    take w
    take w + '!'
behavior Forever():
    while True:
        take 'on'
behavior Low():
    precondition: self.position.y < 1
    invariant: self.position.y < 9
    take 'low'
behavior High():
    precondition: self.position.y >= 1
    take 'high'
    wait
def closest(me):
    best, gap = None, 1000
    for o in things:
        if o is not me and (distance from o to me) < gap:
            best, gap = o, distance from o to me
    return gap, best
def early(y):
    for k in range(10):
        if k * 2 > y:
            return k
    return 99
"""
WATCHERS = """
monitor Count():
    n = 0
    while True:
        n += 1
        simulation().scenic_reward = n
        if n > 8:
            terminate
        require mate.position.y < 30
        wait
require monitor Count()
require always mate.position.y > -1
require eventually ego.position.y > 3
require (ego.position.y < 4) until (mate.position.y >= 2)
require (ego.position.y > 1) implies (next ego.position.y > 2)
terminate when ego.position.y > 20
terminate simulation when ego.position.y > 21
terminate after 30 steps
"""
MIXED = """
import random
def clamp(v, lo, hi):
    return max(lo, min(hi, v))
behavior Zig(points):
    for p in points:
        while (distance from self to p) > 3 and simulation().currentTime < 20:
            take f"go {p.x:.4g}"
        take 'next'
behavior Main(n=2):
    marks = []
    targets = [1 @ 3, mate, foe.position]
    scores = {mate: 1, foe: 2}
    for i, (o, s) in enumerate(scores.items()):
        take f"{i} {s} {o.position.x:.4g}"
    a, b, c = [1, 2, 3]
    words = ["x", "y", "z"]
    for w in words:
        if w == 'y': continue
        take w + str(a)
    def near(o, d=5):
        return (distance from self to o) < d + n
    while len(marks) < 3:
        if near(mate): marks.append(self.position.y)
        n += 1
        take f"{len(marks)}"
    pick = random.choice([mate, foe])
    k = random.randint(1, 3)
    for _ in range(k):
        take f"{pick.position.x:.4g} {clamp(self.position.y, 0, k):.4g}"
    best = min([o for o in things if o is not self], key=lambda o: distance from self to o, default=None)
    take 'none' if best is None else f"{best.position.x:.4g}"
    x, y = self.position.x, self.position.y
    z = x if y > 3 else None
    if z is not None and z < 5: take f"z{z:.4g}"
    do Zig([1 @ 30, 2 @ 2])
    take max(marks) > 3, not marks, marks[-1]
ego = new Object at 0 @ 0, with behavior Main(), with requireVisible False
mate = new Object at 4 @ Range(0, 3), with requireVisible False
foe = new Object at -4 @ 1, with requireVisible False
things = [ego, mate, foe]
"""


def program(name: str) -> str:
    """Return the text of one program."""
    return DEFINITIONS + "behavior Main():" + BODIES[name] + OBJECTS


def watched_program() -> str:
    return DEFINITIONS + "behavior Main():\n    do Forever()\n" + OBJECTS + WATCHERS
