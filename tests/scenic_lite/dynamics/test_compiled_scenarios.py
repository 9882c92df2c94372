"""Modular scenarios and records in the machine: each program gives what the reference gives, in both dialects where it
can be written in both; random ones are in `test_compiled`.
"""

import re

import numpy as np
import pytest

from regista.envs.toy_world import toy_world
from scenic_lite import ScenicError, load
from scenic_lite.dynamics.compiler.compile import compile_program
from scenic_lite.dynamics.machine import vm
from scenic_lite.dynamics.machine.compiled import recorded
from tests.scenic_lite.dynamics.compare import differences
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.scenario_programs import BODIES, PARTS, RECORDS, TOP, main, program
from tests.scenic_lite.dynamics.toy_world import first_table, run


@pytest.mark.slow
@pytest.mark.sample(26)
@pytest.mark.parametrize("name", sorted(BODIES))
def test_the_machine_does_as_the_reference(name):
    found, compiled = differences(program(name), range(6), steps=20)
    assert found == []
    assert not [each for each in compiled.diagnostics if each.kind != "warning"]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(BODIES))
def test_in_scenic_2_too(name):
    text = program(name).replace("new Thing", "Thing")
    assert differences(text, range(3), steps=20, dialect=2)[0] == []


def test_monitors_of_scenic_2_start_by_themselves():
    text = program("sequence").replace("new Thing", "Thing")
    text = text.replace(
        "    setup:\n        override ego",
        "    setup:\n        monitor Own:\n            while True:\n"
        "                simulation().scenic_reward = n\n                wait\n        override ego",
        1,
    )
    assert "monitor Own" in text
    assert differences(text, range(3), steps=20, dialect=2)[0] == []


def test_records_are_those_of_the_reference():
    text = PARTS + "kind = Uniform('k', 'l')\n" + RECORDS
    text += main("do Kept(2), Part('a', 3) for 4 steps\nwait\ndo Kept(mate.position.y) for 3 steps", TOP)
    found, compiled = differences(text, range(5), steps=20)
    assert found == []
    names = {each.name for each in compiled.records}
    assert names == {"place", "high", "words", "near", "n", "above", "kind", "first", "last", "twice"}


@pytest.mark.parametrize("dialect", [2, 3])
def test_records_of_a_program_without_scenarios(dialect):
    text = "ego = new Object at 0 @ Range(0, 2)\nrecord ego.position.y as y\nrecord final ego.position as end\n"
    text += "record initial ego.position.y as first\nterminate when ego.position.y > 4\n"
    text = text.replace("new Object", "Object") if dialect == 2 else text
    found, compiled = differences(text, range(3), steps=9, dialect=dialect)
    assert found == []
    assert len(compiled.records) == 3


def test_many_matches_record_side_by_side():
    text = "ego = new Object at 0 @ Range(0, 2)\nrecord ego.position as place\nrecord ego.position.y as y\n"
    text += "record 'word' as word\nrecord initial ego.position.y as first\n"
    loaded = load(text, dialect=3)
    compiled = compile_program(loaded, toy_world())
    theta = loaded.sample(4, np.random.default_rng(1))[0]
    rows = compiled.registers(theta)
    rng = np.zeros(1, dtype=[("random", "u8")]).view(np.recarray)[0]
    assert np.isnan(recorded(compiled, rows)["y"]).all()
    for match, row in enumerate(rows[:3]):
        table = first_table(loaded, theta[match])
        row[compiled.code.world_base : compiled.code.world_base + table.size] = table.ravel()
        vm.run_watchers(compiled.code, row, rng)
    found = recorded(compiled, rows)
    y = [first_table(loaded, each)[0, 1] for each in theta[:3]]
    assert found["y"].tolist()[:3] == found["first"].tolist()[:3] == found["place"][:3, 1].tolist() == y
    assert np.isnan(found["y"][3]) and np.isnan(found["place"][3]).all()
    assert found["word"].tolist() == ["word", "word", "word", None]


def test_disassembly_shows_scenarios():
    _, compiled = differences(program("interrupts"), range(1))
    text = compiled.disassembly()
    for words in ("scenario Main", "ego: Loop (override in Part)", "end of Part", "ego: its behavior", "Part.running"):
        assert words in text
    assert re.search(r"set_slot +Main.compose, -> \d+", text)
    assert "do Level(2), Part('c', 2) for 2 steps" in text


def test_scenarios_compile_no_kernel():
    if not hasattr(vm.run_watchers, "signatures"):
        pytest.skip("kernels run uncompiled")
    differences(program("sequence"), range(1))
    kernels = [vm.run_behaviors, vm.run_watchers, vm.run_thread]
    before = [list(kernel.signatures) for kernel in kernels]
    for name in ("parallel", "interrupts", "variables"):
        differences(program(name), range(1))
    assert [list(kernel.signatures) for kernel in kernels] == before


REFUSED = {
    "an object": ("scenario Made():\n    setup:\n        new Thing at 9 @ 9\n---\ndo Made()", "by the reference only"),
    "a parameter": ("scenario Set():\n    setup:\n        param x = 3\n---\ndo Set()", "no meaning in a match"),
    "itself": ("scenario Again(n):\n    compose:\n        wait\n        do Again(n)\n---\ndo Again(1)", "calls itself"),
    "a monitor in a loop": (
        "while ego.position.y < 9:\n    require monitor Pay(1)\n    wait",
        "can make this in a loop",
    ),
    "a condition in a branch": (
        "scenario Maybe():\n    setup:\n        if ego.position.y > 2:\n            terminate when mate.y > 3\n"
        "---\ndo Maybe()",
        "can make this in a branch",
    ),
    "the ego of a match": ("wait\nego = mate\nwait", "no match can change ego here"),
}


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_what_cannot_be_compiled_says_so(name, monkeypatch):
    text, words = REFUSED[name]
    monkeypatch.setitem(BODIES, name, text)
    with pytest.raises(ScenicError, match=words) as caught:
        compile_program(load(program(name), dialect=3), toy_world())
    assert caught.value.place is not None


def test_a_fault_in_a_scenario_stops_at_its_line():
    text = PARTS + "scenario Main():\n    compose:\n        wait\n        do Part('a', 1 / (ego.position.y - 1))\n"
    loaded = load(text, dialect=3)
    theta = loaded.sample(1, np.random.default_rng(0))[0][0]
    controller = CompiledController(compile_program(loaded, toy_world()), theta)
    with pytest.raises(ScenicError, match="division by zero") as caught:
        run(first_table(loaded, theta), controller, 9, 1.0)
    assert caught.value.place.line == text.count("\n")


INNER_RECORDS = """
scenario Inner(k):
    setup:
        record initial ego.position.y * k as inner_first
        record final (ego.position.y, k) as inner_last
        record ego.position.y + k as inner
        terminate after 2 steps
scenario Outer(n, mate):
    setup:
        override ego with level n
        record initial ego.level as first
        record final ego.level as last
        record initial f"{n:.3g} {ego.position.y}" as words
        record final [o.position.y for o in [ego, mate] if o.position.y > n] as far
    compose:
        wait
        do Inner(n), Inner(n + 1)
        try:
            do Inner(7) for 1 steps
            wait
        interrupt when ego.position.y > 5:
            do Inner(9)
            abort
scenario Main():
    setup:
        ego = new Object at 0 @ 0, with level 0
        mate = new Object at 5 @ Range(0, 2)
        record initial ego.level as first
        record final ego.level as last
        terminate when ego.position.y > 14
    compose:
        n = 1
        while True:
            do Outer(n, mate) until ego.position.y > 8
            n = n + 1
            wait
            do Inner(Range(1, 2))
"""


@pytest.mark.parametrize("steps", [1, 4, 8, 13, 19])
def test_a_scenario_inside_records_its_own_beginning_and_end(steps):
    found, compiled = differences(INNER_RECORDS, range(3), steps=steps)
    assert found == []
    assert not compiled.diagnostics


def test_what_a_scenario_inside_records_shows_in_its_step_alone():
    text = "scenario Part(k):\n    setup:\n        record initial ego.position.y + k as first\n"
    text += "        record final ego.position.y + k as last\n        terminate after 2 steps\n"
    text += "scenario Main():\n    setup:\n        ego = new Object at 0 @ 0\n"
    text += "    compose:\n        wait\n        do Part(100)\n        wait\n        do Part(200)\n"
    loaded = load(text)
    controller = CompiledController(compile_program(loaded, toy_world()), np.zeros(0))
    table, seen = first_table(loaded, np.zeros(0)), []
    for time in range(7):
        facts = np.array([time], float)
        controller.watch(table, facts)
        shown = recorded(controller.compiled, controller.registers[None])
        seen.append((shown["first"][0], shown["last"][0]))
        controller.act(table, facts)
        table[0, 1] += 1
    expected = [(None, None), (101, None), (None, None), (None, 103), (204, None), (None, None), (None, 206)]
    np.testing.assert_equal(seen, [[np.nan if part is None else part for part in pair] for pair in expected])
