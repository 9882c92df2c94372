"""The Python inside programs: what it gives is what Python gives."""

import math

import numpy as np
import pytest
from scene import param, things

from scenic_lite import ScenicError

# expressions without anything random: their value is Python's own.
EXPRESSIONS = [
    "1 + 2 * 3 - 4 / 5",
    "7 // 2 + 7 % 3 + 2 ** 10",
    "-3 ** 2",
    "1 << 4 | 3 & 6 ^ 1",
    "not 3 or 4 and 0",
    "1 < 2 <= 2 != 3",
    "'b' in 'abc' and 4 not in [1, 2]",
    "[i * j for i in range(4) for j in range(i) if (i + j) % 2]",
    "{k: v for k, v in enumerate('abc')}",
    "sorted([3, 1, 2])",
    "[*range(3), *(7, 8)]",
    "{**{'a': 1}, 'b': 2}['b']",
    "[5, 6, 7, 8][1:-1][::-1]",
    "'ab' * 2 + str(3.5)",
    "f'{3.14159:.2f} {7:>4} {\"x\"}'",
    "(lambda a, b=2, *c, d, **e: [a, b, len(c), d, e['k']])(1, 5, 6, 7, d=8, k=9)",
    "sum([1, 2.5]) + len('abc') + abs(-3) + round(2.567, 1) + int('12') + float('1.5')",
    "min(3, 1, 2) + max([4, 9])",
    "list(zip([1, 2], ['a', 'b']))",
    "sorted([3, 1, 2], key=lambda v: -v, reverse=True)",
    "list(map(lambda v: v + 1, [1, 2])) + list(filter(lambda v: v > 1, [1, 2]))",
    "any([False, True]) and all([])",
    "'a,b'.split(',') + ['-'.join(['x', 'y']), ' q '.strip().upper()]",
    "[isinstance(1, int), isinstance('a', (int, str)), isinstance([], dict)]",
    "(n := 4) + n",
    "math.hypot(3, 4) + math.floor(-2.5) + math.atan2(1, 1) + math.pi",
    "3 if [] else None",
    "'{} {1}'.replace('{}', '{0}').format(1, 'b') + '{x:>5.1f}|{y!r}'.format(x=2.25, y='q')",
    "[str([1, 'a', (2,), {'k': None}]), repr('x'), str(range(3)), str(())]",
    "['Ab'.swapcase(), 'a-b'.partition('-'), 'x'.rjust(3, '.'), 'a\\nb'.splitlines(), 'abc'.removeprefix('a')]",
    "[divmod(17, 5), pow(2, 10, 1000), hex(255), chr(97), ord('b'), max([3, -5], key=abs), min([], default=7)]",
    "[next(v for v in [3, 8] if v > 5), list(iter('ab')), list(reversed([1, 2])), sum([[1], [2]], [])]",
    "[{'a': 1} | {'b': 2}, dict.fromkeys('ab', 0)]",
    "list(map(str.upper, 'ab'))",
    "[type(3) is int, type('a').__name__, callable(len), isinstance(None, type(None))]",
    "[math.comb(5, 2), math.gcd(12, 18), math.prod([2, 3]), math.log(8, 2), math.dist((0, 0), (3, 4)), math.isqrt(17)]",
]


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_expression(text):
    value = things(f"import math\nresult = {text}\nparam value = [result]").params["value"][0]
    assert value == eval(text, {"math": math})


BLOCKS = [
    "total = 0\nfor i in range(10):\n    if i == 3:\n        continue\n    if i == 6:\n        break\n    total += i\n",
    "total = 0\nwhile total < 5:\n    total += 2\nelse:\n    total += 100\n",
    "total = 0\nfor a, (b, *c) in [(1, (2, 3, 4)), (5, (6,))]:\n    total += a * b + len(c)\n",
    "def f(n):\n    return 1 if n < 2 else n * f(n - 1)\ntotal = f(6)\n",
    "count = 0\ndef bump():\n    global count\n    count += 1\n    return count\ntotal = bump() + bump()\n",
    "def outer(k):\n    def inner(v):\n        return v * k\n    return inner\ntotal = outer(3)(4)\n",
    "d = {'a': 1}\nd['b'] = [1, 2]\nd['b'][0] = 9\nd['b'].append(3)\ntotal = sum(d['b']) + len(d)\n",
    "def f(*args, k=3, **rest):\n    return len(args) + k + rest['z']\ntotal = f(1, 2, k=4, z=5)\n",
    "x = y = 4\na, b = y, x + 1\ntotal: int = a * b\n",
    "def outer():\n    n = 0\n    def step():\n        nonlocal n\n        n += 2\n        return n\n    step()\n"
    "    return step()\ntotal = outer()\n",
    "l = list(range(6))\nl[1:3] = 'abc'\ndel l[0], l[-2:]\nl[::2] = [0, 0]\nk = l\nk += (7,)\ntotal = l\n",
]


@pytest.mark.parametrize("text", BLOCKS)
def test_statements(text):
    names = {}
    exec(text, names)
    assert things(f"{text}param value = total").params["value"] == names["total"]


def test_methods_and_attributes_of_classes():
    text = (
        "class Box(Thing):\n    size: 4\n    sides = 6\n"
        "    def double(self, by=2):\n        return by * self.size\n"
        "a = new Box\nb = new Box with size 7\n"
        "param value = (a.double(), b.double(by=3), b.sides, isinstance(b, Thing), isinstance(b, Object))"
    )
    assert things(text).params["value"] == (8, 21, 6, True, True)


def test_random_values_inside_containers_and_functions():
    text = (
        "x = Range(0, 1)\ndef f(v, by=x):\n    pair = {'a': v, 'b': [by]}\n    return pair['a'] + pair['b'][0]\n"
        "param value = f(10)"
    )
    program = things(text)
    assert program.dim == 1
    assert program.instantiate([[0.5]]).params["value"] == [10.75]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("while True:\n    x = 'a' * 10 ** 9", "budget"),
        ("def f():\n    return f()\nf()", "budget"),
        ("def f():\n    y = x\n    x = 2\nx = 1\nf()", "name"),
        ("with open('f') as f:\n    pass", "unsupported"),
        ("x = [Range(0, 1)] == [0.5]", "random-control-flow"),
        ("x = '{0.__class__}'.format(1)", "unsupported"),
    ],
)
def test_what_no_program_may_do(text, kind):
    with pytest.raises(ScenicError) as caught:
        things(text)
    assert caught.value.kind == kind
    assert caught.value.place is not None


def test_random_values_of_the_module_random():
    text = (
        "import random\nl = [1, 2, 3, 4]\nrandom.shuffle(l)\ns = random.sample([5, 6, 7], 2)\n"
        "param l0 = l[0], l1 = l[1], l2 = l[2], l3 = l[3], s0 = s[0], s1 = s[1], t = random.triangular(0, 2, 1)"
    )
    _, scenes = things(text).sample(3000, np.random.default_rng(0))
    p = scenes.params
    orders = {tuple(sorted(row)) for row in zip(p["l0"], p["l1"], p["l2"], p["l3"], strict=True)}
    assert orders == {(1, 2, 3, 4)}
    assert all(abs(np.mean(p["l3"] == k) - 1 / 4) < 0.04 for k in (1, 2, 3, 4))
    assert not np.any(p["s0"] == p["s1"])
    assert abs(np.mean(p["t"]) - 1) < 0.03 and abs(np.var(p["t"]) - 1 / 6) < 0.02


def test_random_truth_values_count_as_numbers():
    value = param("Uniform(True, True) + Uniform(True, True)")
    assert value.tolist() == [2]


def test_a_requirement_may_ask_which_object_was_chosen():
    text = (
        "a = new Thing with tag 'a'\nb = new Thing with tag 'b'\nc = Uniform(a, b)\nrequire c is a\n"
        "require c is not b\nparam t = c.tag, before = c is a"
    )
    _, scenes = things(text).sample(50, np.random.default_rng(0))
    assert set(scenes.params["t"]) == {"a"}
    assert scenes.params["before"] is False
