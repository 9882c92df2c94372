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
    "not 3 or 4 and 0",
    "1 < 2 <= 2 != 3",
    "'b' in 'abc' and 4 not in [1, 2]",
    "[i * j for i in range(4) for j in range(i) if (i + j) % 2]",
    "{k: v for k, v in enumerate('abc')}",
    "sorted([3, 1, 2])",
    "[*range(3), *(7, 8)]",
    "[5, 6, 7, 8][1:-1][::-1]",
    "'ab' * 2 + str(3.5)",
    "f'{3.14159:.2f} {7:>4} {\"x\"}'",
    "(lambda a, b=2, *c: [a, b, len(c)])(1, 5, 6, 7)",
    "sum([1, 2.5]) + len('abc') + abs(-3) + round(2.567, 1) + int(12.7) + float(1)",
    "min(3, 1, 2) + max([4, 9])",
    "list(zip([1, 2], ['a', 'b']))",
    "sorted([3, 1, 2], key=lambda v: -v, reverse=True)",
    "list(map(lambda v: v + 1, [1, 2])) + list(filter(lambda v: v > 1, [1, 2]))",
    "any([False, True]) and all([])",
    "[isinstance(1, int), isinstance('a', (int, str)), isinstance([], list)]",
    "math.hypot(3, 4) + math.floor(-2.5) + math.atan2(1, 1) + math.pi",
    "3 if [] else None",
    "[str([1, 'a', (2,), [None]]), str((1, 2.5)), str(())]",
    "[17 // 5, 17 % 5, 2 ** 10, max([3, -5], key=abs), min([], default=7)]",
    "[[v for v in [3, 8] if v > 5][0], list('ab'), list(reversed([1, 2])), sum([[1], [2]], [])]",
    "[math.log(8, 2), math.exp(1), math.degrees(1), math.ceil(1.5), math.inf]",
]


@pytest.mark.parametrize("text", EXPRESSIONS)
def test_expression(text):
    value = things(f"import math\nresult = {text}\nparam value = [result]").params["value"][0]
    assert value == eval(text, {"math": math})


BLOCKS = [
    "total = 0\nfor i in range(10):\n    if i == 3:\n        continue\n    if i == 6:\n        break\n    total += i\n",
    "total = 0\nwhile total < 5:\n    total += 2\nelse:\n    total += 100\n",
    "total = 0\nfor a, (b, c) in [(1, (2, [3, 4])), (5, (6, []))]:\n    total += a * b + len(c)\n",
    "def f(n):\n    return 1 if n < 2 else n * f(n - 1)\ntotal = f(6)\n",
    "counts = []\ndef bump():\n    counts.append(1)\n    return len(counts)\ntotal = bump() + bump()\n",
    "def outer(k):\n    def inner(v):\n        return v * k\n    return inner\ntotal = outer(3)(4)\n",
    "d = {'a': 1}\nd['b'] = [1, 2]\nd['b'][0] = 9\nd['b'].append(3)\ntotal = sum(d['b']) + len(d)\n",
    "def f(k, *args):\n    return len(args) + k\ntotal = f(1, 2, 4) + f(k=5)\n",
    "x = y = 4\na, b = y, x + 1\ntotal = a * b\n",
    "l = list(range(6))\nl[1:3] = 'abc'\nl[:1] = l[-2:] = []\nl[::2] = [0, 0]\nk = l\nk += (7,)\ntotal = l\n",
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
        ("x = [Range(0, 1)] == [0.5]", "unsupported"),
        ("x = [1 @ 2] == [1 @ 2]", "unsupported"),
        ("x = dict([(1, 2)])", "unsupported"),
        ("x = '{0.__class__}'.format(1)", "unsupported"),
    ],
)
def test_what_no_program_may_do(text, kind):
    with pytest.raises(ScenicError) as caught:
        things(text)
    assert caught.value.kind == kind
    assert caught.value.place is not None


def test_the_module_random_draws_as_scenic_does():
    text = (
        "import random\nparam u = random.uniform(2, 4), i = random.randint(1, 3), c = random.choice(['a', 'b'])\n"
        "param g = random.gauss(5, 0.5), r = random.random(), n = random.normalvariate(0, 1)"
    )
    program = things(text)
    assert program.dim == 6
    _, scenes = program.sample(3000, np.random.default_rng(0))
    p = scenes.params
    assert p["u"].min() >= 2 and p["u"].max() <= 4
    assert set(p["i"]) == {1, 2, 3} and set(p["c"]) == {"a", "b"}
    assert abs(np.mean(p["g"]) - 5) < 0.05 and abs(np.std(p["n"]) - 1) < 0.05
    assert p["r"].min() >= 0 and p["r"].max() <= 1


LEFT_OUT = [
    ("x = 1 << 4", 7, "bit operators are not supported", "truth values are joined by"),
    ("x = ~1", 5, "bit operators are not supported", "truth values are joined by"),
    ("x = 1\nx |= 4", 3, "bit operators are not supported", "truth values are joined by"),
    ("x = {**{}, 1: 2}", 6, "`**` before a value or parameter is not supported", "write each name"),
    ("x = dict(**{})", 10, "`**` before a value or parameter is not supported", "write each name"),
    ("def f(**k):\n    pass", 7, "`**` before a value or parameter is not supported", "write each name"),
    ("def f(*a, b):\n    pass", 11, "a parameter behind `*` is not supported", "write it before"),
    ("x = (y := 1)", 8, "`:=` is not supported", "assign on a line of its own"),
    ("x: int = 1", 2, "types of variables are not supported", "write "),
    ("class A:\n    x: int = 1", 12, "types of variables are not supported", "write "),
    ("x = [1]\ndel x[0]", 1, "`del` is not supported", "without it"),
    ("def f():\n    global x", 5, "`global` is not supported", "return the new value"),
    ("a, *b = [1, 2]", 4, "`*` before a variable is not supported", "items[1:]"),
    ("def f():\n    nonlocal x", 5, "`nonlocal` is not supported", "return the new value"),
    ("x = 'a'.upper()", 5, "texts have no method 'upper' here", "texts are put together by"),
    ("y = str(Range(0, 1))\nx = y.split()", 5, "texts have no method 'split' here", "texts are put together by"),
    ("x = list(map(str.upper, ['a']))", 14, "texts have no method 'upper' here", "texts are put together by"),
    ("x = '{}'.format(1)", 5, "texts have no method 'format' here", "texts are put together by"),
    ("y = 'a%d'\nx = y % 3", 5, "`%` does not format texts here", 'write f"...{x}..."'),
    ("x = set([1, 2])", 5, "there is no set() here", "write a list"),
    ("x = next(iter([1, 2]))", 10, "there is no iter() here", "write a list"),
    ("x = pow(7, 2)", 5, "there is no pow() here", "write a ** b"),
    ("x = [1].sort()", 5, "there is no sort() here", "write items = sorted(items)"),
    ("x = {}\nx.update({1: 2})", 1, "there is no update() here", "write d[key] = value"),
    ("x = str([Range(0, 1)])", 5, "a collection or vector with random or live values", "write them one by one"),
    ("x = str([{1: 2}])", 5, "a dictionary cannot be converted to text", "write its elements one by one"),
    ("x = divmod(7, 2)", 5, "there is no divmod() here", "write a // b and a % b"),
    ("x = getattr(ego, 'width')", 5, "there is no getattr() here", "write x.name"),
    ("x = type(3)", 5, "there is no type() here", "write isinstance(x, ...)"),
    ("import math\nx = math.gcd(4, 6)", 5, "there is no gcd() here", "write a function with a loop"),
    ("import random\nx = random.shuffle([1, 2])", 5, "there is no shuffle() here", "draw the elements one by one"),
    ("import random\nx = random.expovariate(2)", 5, "there is no expovariate() here", "write Range"),
    ("class Box:\n    def f(self):\n        return super().f()\nb = new Box\nb.f()", 16, "there is no super()", "base"),
]


@pytest.mark.parametrize(("text", "column", "message", "hint"), LEFT_OUT)
def test_what_is_left_out_of_python_says_what_to_write(text, column, message, hint):
    with pytest.raises(ScenicError) as caught:
        things(text)
    assert caught.value.kind == "unsupported"
    assert caught.value.column == column
    assert caught.value.message.startswith(message)
    assert hint in caught.value.hint


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


def test_a_filter_may_keep_other_elements_in_each_scene():
    text = (
        "a = Range(0, 2)\nb = Range(0, 2)\nkept = filter(lambda v: v > 1, [a, 5, b])\n"
        "param a = a, b = b, count = len(kept), one = Uniform(*filter(lambda v: v < 1, [a, b]))"
    )
    _, scenes = things(text).sample(400, np.random.default_rng(0))
    p = scenes.params
    assert np.array_equal(p["count"], 1 + (p["a"] > 1) + (p["b"] > 1))
    assert np.all((p["a"] < 1) | (p["b"] < 1))
    assert np.all(((p["one"] == p["a"]) & (p["a"] < 1)) | ((p["one"] == p["b"]) & (p["b"] < 1)))
    with pytest.raises(ScenicError, match="a filter with more than 256 results"):
        things("x = filter(lambda v: v > 0, [Range(-1, 1) for i in range(9)])")


def test_a_random_list_takes_random_places():
    program = things(
        "n = DiscreteRange(-2, 1)\nm = DiscreteRange(1, 3)\nitems = Uniform([1, 2, 3], [4, 5, 6])\n"
        "param at = items[n], part = items[:m], one = Uniform(*items[:m])\n"
    )
    theta, scenes = program.sample(40, np.random.default_rng(0))
    for k, row in enumerate(map(program.describe, theta)):
        items = [[1, 2, 3], [4, 5, 6]]["no. 2" in row["items"]]
        assert scenes.params["at"][k] == items[row["n"]] and list(scenes.params["part"][k]) == items[: row["m"]]
    with pytest.raises(ScenicError, match="list index out of range"):
        things("items = Uniform([1, 2], [3, 4])\nparam at = items[DiscreteRange(0, 2)]")


def test_an_empty_random_list_has_the_default_extreme():
    program = things("items = Uniform([3, 1], [])\nparam low = min(items, default=7), high = max(items, default=7)\n")
    _, scenes = program.sample(40, np.random.default_rng(0))
    assert set(zip(scenes.params["low"], scenes.params["high"], strict=True)) == {(1, 3), (7, 7)}


@pytest.mark.parametrize(("index", "message"), [("n", "index of a list"), (":n", "ends of a slice")])
def test_what_stands_at_random_places_is_refused(index, message):
    text = "n = DiscreteRange(-3, 2)\nitems = [1, 2, 3]\n"
    with pytest.raises(ScenicError, match=f"the {message} must not be random"):
        things(text + f"param value = items[{index}]")
