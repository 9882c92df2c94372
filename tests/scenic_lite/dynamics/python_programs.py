"""Programs that use more of Python in their behaviors: lists that grow, shared attributes, pairs."""

OBJECTS = """
ego = new Object at 0 @ 0, with behavior Main(), with requireVisible False
mate = new Object at 4 @ Range(0, 3){other}, with requireVisible False
foe = new Object at -4 @ 1, with requireVisible False
things = [ego, mate, foe]
word = Uniform('up', 'down')
"""
PROGRAMS = {
    "actions that are lists": """
x = Uniform([1, 2], [3, 4])
behavior Main():
    while True:
        take x, 5
        take [6, self.position.y]
        take len(x), len(self.lastActions)
""",
    "set on both ways": """
behavior Main():
    while True:
        if self.position.y > 3:
            z = 1
        else:
            z = 2
        take z
""",
    "read where a branch may have set it": """
behavior Main():
    take 1
    if self.position.y > 2:
        z = 3
    take 2
    take z
""",
    "read before it is set in the text": """
behavior Main():
    while True:
        if self.position.y > 3:
            take z
        z = 4
        take 1
""",
    "set on one of three ways, begun again": """
behavior Turn():
    for i in range(3):
        if self.position.y > 4:
            turn = 5
        elif self.position.y > 1:
            turn = self.position.y
        else:
            other = 6
        take turn
behavior Main():
    while True:
        do Turn()
        take 9
""",
    "read by a function that may come too early": """
def late(y):
    if y > 2:
        z = 3
    return z
behavior Main():
    take 1
    take 2
    take late(self.position.y)
    take late(mate.position.y - 3)
""",
    "set by an interrupt": """
behavior Main():
    try:
        for i in range(3):
            take i
    interrupt when self.position.y > 2:
        z = self.position.y
        take 7
    take z
""",
    "asked for behind another condition": """
behavior Main():
    while True:
        if self.position.y > 2:
            z = self.position.y
        if self.position.y > 2 and z > 3:
            take z
        else:
            take 0
""",
    "fixed keys": """
behavior Main():
    while True:
        k = 'a' if self.position.y % 2 == 0 else 'b'
        d = {'a': self.position.y, 'b': 7}
        take f"{d['a']} {d['b']:.6g} {k}"
        for k, v in d.items():
            take f'{k}{v}'
""",
    "shared attributes": """
def bump(x):
    ego.n += x
behavior Other():
    while True:
        take f'o{ego.n:.6g}{len(ego.seen)}'
behavior Main():
    self.n, self.seen = 0, []
    while True:
        self.n += self.position.y
        self.seen.append(self.n)
        bump(10)
        take f'{self.n:.6g}'
""",
    "variables of several sorts": """
behavior Main():
    x = 1
    self.mark = 'up'
    while True:
        take x, self.mark
        x = self.position
        self.mark = self.position.y
        take f'{x.y:.6g}'
        x = 'a' if self.position.y > 2 else 2
""",
    "branching field": """
def where(p):
    if p.y > 3:
        return 1.5
    return 0.5
vf = VectorField("f", where)
behavior Main():
    while True:
        take f'{vf[self.position]:.6g}'
        take f'{(self.position offset along vf by 0 @ 2).x:.6g}'
""",
    "enumerate zip": """
behavior Main():
    while True:
        for i, o in enumerate(things):
            take f'{i} {o.position.y:.6g}'
        for a, b in zip(things, [1, 2, 3]):
            take f'{a.position.y + b:.6g}'
        near = [o for o in things if o.position.y > 2]
        for o in near:
            take f'n {o.position.y:.6g}'
        for i in range(len(near)):
            take f'z{near[i] is things[i]}'
""",
    "list of lists": """
behavior Main():
    log = []
    while True:
        log.append((self.position.x, self.position.y))
        take f'{len(log)} {log[-1][1]:.6g} {log[0][1]:.6g}'
        log.append([1, 2][0:1] and (3, 4))
        x, y = log[-2]
        take f'{x + y:.6g}'
""",
    "any gen": """
behavior Main():
    while True:
        take any(o.position.y > 4 for o in things)
        take len([1 for o in things if o.position.y > 3])
        high = [o.position.x for o in things if o.position.y > 3]
        take high[0] if high else 9
""",
    "self attr list": """
behavior Main():
    self.log = []
    while True:
        self.log.append(self.position.y)
        take f'{len(self.log)} {self.log[-1]:.6g}'
""",
    "while else": """
behavior Main():
    while True:
        n = 0
        while n < self.position.y:
            n += 1
            if n > 4: break
        else:
            take 'else'
        take n
""",
    "number or text": """
behavior Main():
    while True:
        take mate.position.y and 'a', self.position.y > 3 or 'b'
        take [1, 'x', 2][int(self.position.y) % 3], Uniform(1, 'x')
        for x in [z for z in (1, 'x') if self.position.y > 4]:
            take x
""",
    "filters of pairs": """
behavior Main():
    while True:
        take len([i for i, o in enumerate(things) if o.position.y > 2])
        take sum([a.position.y - b.position.x for a in things for b in things])
        low = [b.position.x for b in [o for o in things if o.position.y > 2] if b.position.x < self.position.y]
        take max(low, default=0)
        take len([Range(0, 1) for o in things if o.position.y > 1 and Range(0, 1) < 0.5])
        take len([n for n in [] if self.position.y > n])
""",
    "dict comp": """
behavior Main():
    while True:
        d = {o.position.x: o.position.y for o in things}
        take f'{len(d)}'
        e = {o: o.position.y for o in things}
        take f'{e[mate]:.6g} {max(e.values()):.6g}'
""",
}


def text_of(name: str) -> str:
    other = ", with behavior Other()" if "Other" in PROGRAMS[name] else ""
    return PROGRAMS[name] + OBJECTS.format(other=other)
