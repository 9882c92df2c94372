"""Programs that use more of Python in their behaviors: lists that change, variables of modules, `match`, `del`."""

OBJECTS = """
ego = new Object at 0 @ 0, with behavior Main(), with requireVisible False
mate = new Object at 4 @ Range(0, 3){other}, with requireVisible False
foe = new Object at -4 @ 1, with requireVisible False
things = [ego, mate, foe]
"""
PROGRAMS = {
    "an element of a list of the module": """
log = []
behavior Main():
    while True:
        log.append(self.position.y)
        if len(log) > 3:
            log[0] = 7
            log[1] += 0.5
        take f'{len(log)} {sum(log):.6g}'
""",
    "the last five": """
behavior Main():
    hist = []
    while True:
        hist.append(self.position.y * 2)
        last = hist[-5:]
        take f'{len(last)} {sum(last):.6g} {last[0] if len(last) > 0 else 9:.6g}'
""",
    "slice :-1": """
behavior Main():
    hist = []
    while True:
        hist.append(self.position.y * 2)
        last = hist[:-1]
        take f'{len(last)} {sum(last):.6g} {last[0] if len(last) > 0 else 9:.6g}'
""",
    "slice 1:3": """
behavior Main():
    hist = []
    while True:
        hist.append(self.position.y * 2)
        last = hist[1:3]
        take f'{len(last)} {sum(last):.6g} {last[0] if len(last) > 0 else 9:.6g}'
""",
    "slice ::-1": """
behavior Main():
    hist = []
    while True:
        hist.append(self.position.y * 2)
        last = hist[::-1]
        take f'{len(last)} {sum(last):.6g} {last[0] if len(last) > 0 else 9:.6g}'
""",
    "slice ::2": """
behavior Main():
    hist = []
    while True:
        hist.append(self.position.y * 2)
        last = hist[::2]
        take f'{len(last)} {sum(last):.6g} {last[0] if len(last) > 0 else 9:.6g}'
""",
    "slice var": """
behavior Main():
    hist = []
    while True:
        hist.append(self.position.y * 2)
        last = hist[:int(self.position.y) // 2]
        take f'{len(last)} {sum(last):.6g} {last[0] if len(last) > 0 else 9:.6g}'
""",
    "a queue": """
behavior Main():
    q = []
    for i in range(20):
        q.append(i * self.position.y)
        if len(q) > 3:
            x = q.pop(0)
            take f'{x:.6g}'
        take f'{len(q)} {q[0]:.6g}'
""",
    "insert": """
behavior Main():
    q = []
    for i in range(20):
        q.insert(0, i * self.position.y)
        if len(q) > 3:
            x = q.pop()
            take f'{x:.6g}'
        q.insert(1, 7)
        if len(q) > 8: q.clear()
        take f'{len(q)} {q[0] if q else 0:.6g}'
""",
    "remove": """
behavior Main():
    q = [o for o in things if o.position.y > -1]
    take len(q)
    q.remove(mate)
    take len(q)
    near = [o for o in things if o.position.y > 2]
    if foe in near:
        near.remove(foe)
    take f'{len(near)}'
    near.reverse()
    near.sort(key=lambda o: o.position.x)
    take f'{near[0].position.x:.6g} {len(near)}'
    i = near.index(ego)
    take f'{i} {near.count(ego)}'
""",
    "global": """
n = 0
def bump():
    global n
    n += 10
behavior Main():
    global n
    while True:
        n += 1
        take n
        bump()
        take n
""",
    "global shared": """
n = 0
behavior Other():
    while True:
        take f'o{n}'
behavior Main():
    global n
    while True:
        n += self.position.y
        take f'{n:.6g}'
""",
    "global list": """
seen = []
behavior Other():
    while True:
        take f'o{len(seen)}'
behavior Main():
    while True:
        seen.append(self.position.y)
        take f'{len(seen)}'
""",
    "nonlocal": """
def outer(x):
    n = 1
    def inner():
        nonlocal n
        n += x
    inner()
    inner()
    return n
behavior Main():
    while True:
        take outer(self.position.y)
""",
    "del": """
behavior Main():
    x = 3
    del x
    take 1
    d = {'a': 1, 'b': 2}
    del d['a']
    take len(d)
    q = [1, 2, 3]
    del q[0]
    take f'{q}'
""",
    "dict fixed keys": """
behavior Main():
    d = {'a': 0, 'b': 0}
    while True:
        k = 'a' if self.position.y % 2 == 0 else 'b'
        d[k] += 1
        take f"{d['a']} {d['b']}"
        for k, v in d.items():
            take f'{k}{v}'
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
        for i, o in enumerate(near):
            take f'n{i} {o.position.y:.6g}'
        for a, b in zip(near, things):
            take f'z{a is b}'
""",
    "walrus": """
behavior Main():
    while True:
        if (n := self.position.y * 2) > 5:
            take f'{n:.6g}'
        take 1
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
        take sum(1 for o in things if o.position.y > 3)
        take next((o.position.x for o in things if o.position.y > 3), 9)
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
