"""The machine gives the commands of the reference: on small programs, on those of the repository, on generated ones."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.world import FOOTBALL_WORLD
from regista.envs.toy_world import toy_world
from scenic_lite import ScenicError, load
from scenic_lite.core.world import packed
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine import opcodes, vm
from scenic_lite.dynamics.machine.opcodes import OPCODES
from tests.football_programs import DYNAMIC, name_of
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics import feature_programs, python_programs
from tests.scenic_lite.dynamics.compare import alike, differences
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.generated import program as generated
from tests.scenic_lite.dynamics.generated_scenarios import program as generated_scenarios

BASE = FOOTBALL_WORLD.actions or 0
OPEN = Path(__file__).resolve().parents[2] / "oracle/open"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(feature_programs.BODIES))
def test_a_feature_gives_the_same_commands(name):
    found, _ = differences(feature_programs.program(name), range(4), steps=26)
    assert found == []


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(python_programs.PROGRAMS))
def test_more_of_python_gives_the_same_commands(name):
    found, _ = differences(python_programs.text_of(name), range(3), steps=24)
    assert found == []


def test_a_mixture_gives_the_same_commands():
    found, _ = differences(feature_programs.MIXED, range(8), steps=40)
    assert found == []


def test_random_values_of_modules_and_classes_are_those_of_the_scene(tmp_path):
    (tmp_path / "lib.scenic").write_text("far = Range(3, 5)\ndef reach():\n    return far + 1\n")
    path = tmp_path / "program.scenic"
    path.write_text(
        "import lib\nclass Zone:\n    size = Range(1, 2)\n    kind: Range(6, 7)\n"
        "behavior B():\n    while True:\n        take lib.far\n        take Zone.size + lib.reach()\n"
        "        take self.size + self.kind\n"
        "monitor M():\n    while True:\n        if lib.far + Zone.size > 6.2:\n            terminate\n        wait\n"
        "ego = new Zone at 0 @ 0, with behavior B()\nrequire monitor M()\nterminate when lib.far > 4.6\n"
    )
    assert load(path, dialect=3).dim == 3
    found, _ = differences(str(path), range(12), steps=9)
    assert found == []


@pytest.mark.slow
def test_watchers_give_the_same_verdicts():
    found, _ = differences(feature_programs.watched_program(), range(40), steps=34)
    assert found == []


@pytest.mark.slow
def test_every_opcode_is_used():
    texts = [*map(feature_programs.program, feature_programs.BODIES), feature_programs.watched_program(), FAULTY]
    used = {op for text in texts for op in differences(text, range(1), steps=3)[1].code.rows[:, 0].tolist()}
    assert {row.name for i, row in enumerate(OPCODES) if i not in used} == set()


FAULTY = feature_programs.DEFINITIONS + "behavior Main():\n    assert self.position.y < 2\n    take 'a'\n"
FAULTY += "    terminate\n"
FAULTY += feature_programs.OBJECTS


def seeds(count, quick):
    """Return the seeds of generated programs, of which the first are quick and the others many."""
    return [seed if seed < quick else pytest.param(seed, marks=pytest.mark.slow) for seed in range(count)]


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", seeds(60, quick=12))
def test_generated_programs_give_the_same_commands(seed):
    text = generated(seed)
    found, _ = differences(text, range(seed, seed + 1), steps=14)
    assert found == [], text


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(40, quick=6))
@pytest.mark.long
def test_generated_scenarios_give_the_same_commands(seed):
    text = generated_scenarios(seed)
    found, _ = differences(text, range(seed, seed + 1), steps=18)
    assert found == [], text


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1000, 1040))
@pytest.mark.long
def test_more_generated_scenarios_give_the_same_commands(seed):
    text = generated_scenarios(seed)
    found, _ = differences(text, range(seed, seed + 1), steps=18)
    assert found == [], text


@pytest.mark.slow
@pytest.mark.sample(17)
@pytest.mark.parametrize("path", sorted(OPEN.glob("dyn_*.scenic")), ids=lambda path: path.stem)
def test_open_oracle_programs_give_the_same_commands(path):
    text = path.read_text()
    settings = dict(re.findall(r"(\w+): ([^;\n]+)", "\n".join(text.splitlines()[:5])))
    drift, steps = float(settings.get("drift", 0)), int(settings["steps"])
    found, _ = differences(text, range(20), steps, drift=drift, timestep=float(settings["timestep"]))
    assert found == []


# ------------------------------------------------------------ football


def sampled(paths):
    """Return parameters: programs of a folder are much alike, so that all but its first are left to the slow tests."""
    for before, path in zip([None, *paths], paths, strict=False):
        alike = [pytest.mark.slow] * (before is not None and before.parent == path.parent)
        yield pytest.param(path, marks=alike, id=name_of(path))


def random_worlds(rng: np.random.Generator, objects: int, steps: int):
    """Yield tables [O, F] and facts [G] of matches that nobody has played."""
    fields, facts = FOOTBALL_WORLD.fields, FOOTBALL_WORLD.facts
    low, high = np.array([-100.0, -42.0]), np.array([100.0, 42.0])
    places = rng.uniform(low, high, (objects, 2))
    for step in range(steps):
        places += rng.normal(0, 2, places.shape)
        if rng.random() < 0.1:
            places = rng.uniform(low, high, (objects, 2))
        table = rng.integers(0, 2, (objects, len(fields))).astype(float)
        table[:, :2] = places
        table[:, fields.index("heading")] = rng.uniform(0, 2 * np.pi, objects)
        table[:, fields.index("owns_ball")] = np.arange(objects) == rng.integers(-3, objects)
        table[:, fields.index("owned_team")] = rng.integers(-1, 2)
        known = {"time": float(step), "steps_left": 400.0 - step}
        yield table, np.array([known.get(name, float(rng.integers(0, 2))) for name in facts])


@pytest.mark.slow
@pytest.mark.sample(4)
@pytest.mark.parametrize("path", list(sampled(DYNAMIC)))
def test_football_programs_give_the_same_commands(path):
    program = load(path, FOOTBALL)
    compiled = compile_program(program, FOOTBALL_WORLD)
    rng = np.random.default_rng(3)
    theta = program.sample(1, rng)[0][0]
    players = [Reference(program, theta, FOOTBALL_WORLD, 5), CompiledController(compiled, theta, 5)]
    for table, facts in random_worlds(rng, len(program.objects), 40):
        commands = [each.act(table, facts) for each in players]
        taken = [tuple(packed(each, BASE) for each in found.actions if each) for found in commands]
        assert taken[0] == taken[1]
        verdicts = [each.watch(table, facts) for each in players]
        assert alike(tuple(verdicts[0]), tuple(verdicts[1]))
        if verdicts[0].terminated or verdicts[0].rejected:
            break


# ------------------------------------------------------------ the machine


def test_a_new_program_compiles_no_kernel():
    differences(feature_programs.program("draws"), range(1))
    kernels = [vm.run_behaviors, vm.run_watchers, vm.run_thread]
    if not hasattr(vm.run_behaviors, "signatures"):
        pytest.skip("kernels run uncompiled")
    before = [list(kernel.signatures) for kernel in kernels]
    for name in ("lists", "interrupts", "regions"):
        differences(feature_programs.program(name), range(1))
    differences(feature_programs.watched_program(), range(1))
    assert [list(kernel.signatures) for kernel in kernels] == before


def test_disassembly_shows_the_lines_of_the_program():
    _, compiled = differences(feature_programs.program("interrupts"), range(1))
    text = compiled.disassembly()
    assert "ego: Main" in text
    assert "interrupt when self.position.y % 5 == 2:" in text
    assert re.search(r"\d+  take +\S+, \S+, -> \d+", text)
    assert "ego.y" in text


def test_every_opcode_says_what_it_does():
    assert all(getattr(opcodes, row.name) == number for number, row in enumerate(OPCODES))
    assert all(row.meaning and len(row.operands) == 3 for row in OPCODES)


# ------------------------------------------------------------ faults

FAULTS = {
    "never takes an action": ("    n = 1\n    while n > 0:\n        n += 1\n    take n\n", 3, "without an action"),
    "division": ("    take 1 / (self.position.y - 2)\n    take 2\n" * 3, 4, "division by zero"),
    "index": ("    for i in range(9):\n        take things[i].position.x\n", 3, "out of range"),
    "list index": (
        "    near = [o for o in things if o.position.y > 0]\n    for i in range(9):\n        take near[i].position.x\n",
        4,
        "out of range",
    ),
    "a fraction": (
        "    take 'abc'[int(self.position.y)]\n    take 'abc'[self.position.y]\n",
        3,
        "an integer, not a fraction",
    ),
    "a format": ("    take f'{self.position.y:.2f}'\n    take f'{self.position.y:d}'\n", 3, "format code 'd'"),
    "domain": ("    while True:\n        take sqrt(3.5 - self.position.y)\n", 3, "math domain"),
    "none": (
        "    best = None\n    for i in range(5):\n        if i == 2:\n            best = None\n        elif i < 2:\n"
        "            best = mate\n        take best.position.x\n",
        8,
        "None",
    ),
    "assertion": ("    while True:\n        assert self.position.y < 3\n        take 1\n", 3, "assertion"),
}


@pytest.mark.parametrize("name", sorted(FAULTS))
def test_a_fault_stops_at_its_line(name):
    body, line, words = FAULTS[name]
    text = "behavior Main():\n" + body + feature_programs.OBJECTS
    program = load(text, dialect=3)
    compiled = compile_program(program, toy_world())
    theta = program.sample(1, np.random.default_rng(0))[0][0]
    controller = CompiledController(compiled, theta)
    with pytest.raises(ScenicError, match=words) as caught:
        for step in range(12):
            table = np.array([[0.0, step, 0.0], [4.0, step + 1.0, 0.0], [-4.0, step + 1.0, 0.0]])
            controller.act(table, np.array([float(step)]))
    assert caught.value.place is not None
    assert caught.value.place.line == line


@pytest.mark.parametrize("term", ["log2(low)", "log10(low) + 1", "asin(low)", "acos(low)", "fmod(1, low - low)"])
def test_what_is_no_number_of_a_draw_fails_where_the_match_comes_to_it(term):
    program = load(f"""
import math
low = Range(-3, -2)
behavior Main():
    take 1
    take math.{term}
ego = new Object with behavior Main()
""")
    controller = CompiledController(compile_program(program, toy_world()), np.zeros(1))
    table = np.zeros((1, 3))
    assert controller.act(table, np.zeros(1)).actions == ((1,),)
    with pytest.raises(ScenicError, match="math domain error") as caught:
        controller.act(table, np.ones(1))
    assert caught.value.place.line == 6


def test_other_matches_go_on():
    text = "behavior Main():\n    while True:\n        take 1 / self.position.y\n" + feature_programs.OBJECTS
    program = load(text, dialect=3)
    compiled = compile_program(program, toy_world())
    rows = compiled.registers(program.sample(2, np.random.default_rng(0))[0])
    commands, rng = np.zeros((2, 3)), np.zeros(1, dtype=[("random", "u8")]).view(np.recarray)[0]
    for match, y in enumerate((0.0, 2.0)):
        rows[match, compiled.code.world_base + 1] = y
        vm.run_behaviors(compiled.code, rows[match], commands[match], rng)
    assert compiled.fault(rows[0]) is not None
    assert compiled.fault(rows[1]) is None
    assert commands[1, 0] >= 0 > commands[0, 0]


REFUSED = {
    "recursion": ("behavior Main():\n    take 1\n    do Main()\n", "calls itself"),
    "keys": ("n = Uniform(1, 2)\nbehavior Main():\n    d = {1: 2, n: 3}\n    take len(d)\n", "a dictionary whose keys"),
    "get": ("n = Uniform(1, 2)\nbehavior Main():\n    take {1: 2}.get(n, 3)\n", r"get\(\) of a dictionary with what"),
    "pop": ("behavior Main():\n    seen = []\n    seen.append(self.position.y)\n    seen.pop()\n    take 1\n", "pop"),
    "pop of a filter": (
        "behavior Main():\n    seen = [o for o in things if o.position.y > 2]\n    seen.pop()\n    take len(seen)\n",
        r"pop\(\) of a list cannot be done",
    ),
    "a list of the module": (
        "seen = []\nbehavior Main():\n    seen.append(self.position.y)\n    take len(seen)\n",
        "a match cannot append to 'seen'",
    ),
    "a rare function": (
        "import math\nbehavior Main():\n    take math.log2(self.position.y + 1)\n",
        "while a match runs",
    ),
    "rounding to digits": ("behavior Main():\n    take round(self.position.y, 2)\n", "while a match runs"),
    "a filter of pairs": (
        "behavior Main():\n    take len([a for a in things for b in things if a.position.y > b.position.y])\n",
        "a comprehension over several lists",
    ),
    "an element": ("behavior Main():\n    n = [1, 2]\n    n[0] = 3\n    take n[0]\n", "elements cannot be assigned"),
    "an attribute of the simulation": (
        "behavior Main():\n    simulation().level = 1\n    take 1\n",
        r"sets no attribute 'level' of simulation\(\)",
    ),
    "the target after a break": (
        "behavior Main():\n    for o in things:\n        if o.position.y > 2:\n            break\n    take o.y\n",
        "whether 'o' has a value here",
    ),
    "a key": (
        "behavior Main():\n    take {0: 1, 1: 2}[int(self.position.y)]\n",
        "an element of a dictionary whose key the match decides",
    ),
    "a variable that an interrupt asks for and its body sets": (
        "behavior Main():\n    try:\n        z = self.y\n        wait\n    interrupt when z > 2:\n        take z\n",
        "whether 'z' has a value here",
    ),
}
DOUBTFUL = {
    "an object": ("x = new Object at 1 @ 1", "no object can be made"),
    "the world's": ("self.position = 1 @ 2", "belongs to the world"),
    "a monitor": ("do M()", "`do` needs a behavior"),
    "arguments": ("do Twice()", "is missing"),
    "a name": ("take nobody.position", "'nobody' is not defined"),
    "a property": ("take foe.speedd", "no property 'speedd'"),
    "kinds": ("take 1 + foe.word", "no property 'word'"),
}


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_what_cannot_be_compiled_says_so(name):
    text, words = REFUSED[name]
    program = load(text + feature_programs.OBJECTS, dialect=3)
    with pytest.raises(ScenicError, match=words) as caught:
        compile_program(program, toy_world())
    assert caught.value.place is not None


CHANCE = {"one of several": "x, 5", "in a list": "[x, 5]"}


@pytest.mark.parametrize("name", sorted(CHANCE))
def test_a_list_chosen_by_chance_is_one_action_of_several(name):
    text = f"x = Uniform([1, 2], [3, 4])\nbehavior Main():\n    while True:\n        take {CHANCE[name]}\n"
    assert differences(text + "ego = new Object at 0 @ 0, with behavior Main()", range(8), steps=8)[0] == []


ONE_OF_SEVERAL = {
    "take": "take x\n        take Uniform([1, 2], [3], 4, ())",
    "take a filter": "take [n for n in [1, 2, 3] if n < self.position.y]",
    "a loop": "for n in Uniform([1, 2], [3]):\n            take n",
    "a variable": "near = Uniform([self, 2], [3], [])\n        take len(near)\n        take near",
    "a filter": "take [n + 1 for n in x if n > self.position.y]\n        take len([n for n in x])",
    "unpacked": "a, b = Uniform((1, 2), (3, 4))\n        take a - b",
    "the least": "take min(x), max(Uniform([4, 2], [3]), key=lambda n: -n), sorted(Uniform([3, 1], [2]))[0]",
    "a slice": "take [n for n in x if n > self.position.y][1:]",
    "added": "take [n for n in x if n > self.position.y] + x + [9]",
    "a sum": "take sum(n * n for n in x if n > self.position.y), all(n > 2 for n in x), any([n < 3 for n in x])",
    "in": "y = [n for n in x if n > self.position.y]\n        take 2 in y, 5 not in y",
    "enumerated": "for i, n in enumerate([n for n in x if n > 1]):\n            take i, n\n        wait",
    "zipped": "take sum([a * b for a, b in zip(x, [n for n in [7, 8] if n > self.position.y])])",
    "last actions": "take x\n        take len(self.lastActions)",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(ONE_OF_SEVERAL))
def test_a_list_chosen_by_chance_is_a_list(name):
    text = f"x = Uniform([1, 2], [3, 4, 5])\nbehavior Main():\n    while True:\n        {ONE_OF_SEVERAL[name]}\n"
    assert differences(text + "ego = new Object at 0 @ 0, with behavior Main()", range(6), steps=8)[0] == []


def test_a_point_drawn_in_a_match_stays_where_it_is():
    text = (
        "behavior Main():\n    spot = Point in CircularRegion(3 @ 3, 2)\n    while True:\n"
        "        take spot.position.x, distance to spot\n"
    )
    assert differences(text + "ego = new Object at 0 @ 0, with behavior Main()", range(3), steps=4)[0] == []


@pytest.mark.parametrize("reward", ["math.inf", "-math.inf * 1", "10 * (1e308 * self.position.y)", "'a'", "None"])
def test_a_reward_is_a_finite_number(reward):
    text = f"import math\nbehavior Main():\n    take 1\n    simulation().scenic_reward = {reward}\n    take 3\n"
    found, compiled = differences(text + "ego = new Object at 0 @ 0, with behavior Main()", range(4), steps=5)
    assert found == []
    stops = [row for row in compiled.listing.notes.values() if "a reward is" in row]
    assert stops, compiled.listing.notes


NO_CONDITIONS = {
    "if": ("take 1\n    if self.position.y > 5 or not B():\n        take 2", 1),
    "while": ("while B():\n        take 1", 0),
    "until": ("do B() until B()", 0),
    "at once": ("try:\n        take 1\n        take 2\n    interrupt when B():\n        take 3", 0),
    "behind another": (
        "try:\n        take 1\n        take 2\n    interrupt when B():\n        take 3\n"
        "    interrupt when self.position.y < 2:\n        take 4",
        2,
    ),
}


@pytest.mark.parametrize("name", sorted(NO_CONDITIONS))
def test_a_behavior_called_in_a_condition_stops_a_match_that_comes_to_it(name):
    body, steps = NO_CONDITIONS[name]
    text = "behavior B():\n    take 9\nbehavior Main():\n    " + body + feature_programs.OBJECTS
    differing, compiled = differences(text, range(2), steps=6)
    assert differing == []
    assert [(each.kind, each.message) for each in compiled.diagnostics] == [
        ("type", "a behavior cannot be called in a condition")
    ]
    controller = CompiledController(compiled, compiled.program.sample(1, np.random.default_rng(0))[0][0])
    for step in range(steps):
        controller.act(np.full((3, 3), float(step)), np.array([float(step)]))
    with pytest.raises(ScenicError, match="called in a condition"):
        controller.act(np.full((3, 3), 3.0), np.array([float(steps)]))


RISKY = ("1 / x", "max(1, 2 * (1 / n) + 1)", "3 // n", "5 % x", "math.sqrt(x)", "math.log(n) + 1", "int(1 / x)")


@pytest.mark.parametrize("risky", RISKY)
def test_arithmetic_of_columns_fails_where_and_when_a_match_comes_to_it(risky):
    text = "import math\nx = DiscreteRange(-1, 1)\nbehavior Main(n):\n    take 1\n"
    text += f"    if n < 1:\n        y = {risky}\n        take y\n    y = {risky}\n    take 2\n    take y\n"
    text += "ego = new Object at 0 @ 0, with behavior Main(DiscreteRange(-1, 1))"
    assert differences(text, range(8))[0] == []


@pytest.mark.parametrize("name", sorted(DOUBTFUL))
def test_what_cannot_be_executed_stops_only_a_match_that_comes_to_it(name):
    statement, words = DOUBTFUL[name]
    text = feature_programs.DEFINITIONS + "monitor M():\n    wait\n"
    text += f"behavior Main():\n    take 1\n    if self.position.y > 1.5:\n        {statement}\n    take 2\n"
    line = text.count("\n") - 1
    program = load(text + feature_programs.OBJECTS, dialect=3)
    compiled = compile_program(program, toy_world())
    assert [each.place.line for each in compiled.diagnostics] == [line]
    theta = program.sample(1, np.random.default_rng(0))[0][0]
    table = np.zeros((3, 3))
    calm = CompiledController(compiled, theta)
    taken = [calm.act(table, np.array([float(step)])).actions[0] for step in range(2)]
    assert taken == [(1,), (2,)]
    stopped = CompiledController(compiled, theta)
    stopped.act(table, np.array([0.0]))
    with pytest.raises(ScenicError, match=re.escape(words)) as caught:
        stopped.act(table + 2, np.array([1.0]))
    assert caught.value.place.line == line
