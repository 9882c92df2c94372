"""Modular scenarios where real Scenic 3.1.1 needlessly fails or forgets something, and the choice of the main one.

What it does well is in the golden oracle.
"""

import numpy as np
import pytest

from regista.envs.toy_world import toy_world
from scenic_lite import ScenicError, load
from scenic_lite.dynamics.compiler.compile import compile_program
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.compare import differences
from tests.scenic_lite.dynamics.controller import CompiledController
from tests.scenic_lite.dynamics.playing import actions, played
from tests.scenic_lite.dynamics.toy_world import first_table, run

PARTS = """
behavior Loop(w):
    while True:
        take w
scenario Part(w, n):
    setup:
        override ego with behavior Loop(w)
        terminate after n steps
"""
MAIN = """
scenario Main():
    setup:
        ego = new Object with behavior Loop('-')
    compose:
"""


def composed(compose, parts=""):
    return PARTS + parts + MAIN + "\n".join(f"        {line}" for line in compose.splitlines())


def test_a_condition_ends_a_scenario_inside():
    part = "scenario Until(y):\n    setup:\n        override ego with behavior Loop('u')\n"
    part += "        terminate when ego.position.y >= y\n"
    assert actions(composed("do Until(2)\ndo Part('p', 1)", part)) == "u u p"


def test_an_interrupted_scenario_goes_on():
    compose = "try:\n    do Part('a', 4)\ninterrupt when ego.position.y == 2:\n    do Part('b', 1)\nwait"
    assert actions(composed(compose), 9) == "a a b a a -"


def test_an_aborted_scenario_gives_back_what_it_had_overridden():
    compose = "try:\n    do Part('a', 4)\ninterrupt when ego.position.y == 2:\n    abort\nwait"
    assert actions(composed(compose)) == "a a -"


STOP = """
monitor Stop(n):
    for i in range(n):
        wait
    terminate
monitor Halt(n):
    for i in range(n):
        wait
    terminate simulation
scenario Inner(n):
    setup:
        require monitor Stop(n)
scenario Outer(halt, stop, inner):
    setup:
        override ego with behavior Loop('o')
        require monitor Halt(halt)
        require monitor Stop(stop)
    compose:
        do Inner(inner)
"""
STOPPED, HALTED = '"terminate" executed on line 13', '"terminate simulation" executed on line 17'


@pytest.mark.parametrize(
    "call, reason",
    [
        ("Outer(9, 2, 9)", STOPPED),
        ("Outer(9, 9, 2)", STOPPED),
        ("Outer(2, 2, 9)", HALTED),  # of two ends in one scenario
        ("Outer(2, 9, 2)", STOPPED),  # of two ends, the one further inside
        ("Inner(2), Outer(2, 2, 9)", HALTED),  # the one that was asked for later
        ("Outer(2, 2, 9), Inner(2)", STOPPED),
    ],
)
def test_a_monitor_ends_the_simulation_wherever_it_belongs(call, reason):
    """As Scenic 3.1.1 does, whose manual says that it ends its scenario; the endings are those that it gave."""
    text = composed(f"do {call}\nwait", STOP)
    _, trace = played(text, 9)
    assert trace.ending == f"terminatedByMonitor: {reason}" and len(trace.commands) == 2
    assert differences(text, range(1))[0] == []


def test_what_an_ended_scenario_leaves_unsatisfied_rejects():
    required = "Stop(n)\n        require eventually ego.position.y > 5\nscenario"
    text = composed("do Inner(2)", STOP.replace("Stop(n)\nscenario", required))
    _, trace = played(text, 9)
    assert trace.rejected == "require eventually ego.position.y > 5"
    assert differences(text, range(1))[0] == []


def test_records_of_a_scenario_inside():
    part = "scenario Kept():\n    setup:\n        record ego.position.y as y\n        terminate after 2 steps\n"
    reference, _ = played(composed("wait\ndo Kept()", part))
    assert reference.records == {"y": [(1, 1.0), (2, 2.0)]}


def test_a_scenario_inside_records_when_it_begins_and_when_it_ends():
    part = "scenario Kept():\n    setup:\n        record initial ego.position.y as first\n"
    part += "        record final ego.position.y as last\n        terminate after 2 steps\n"
    reference, _ = played(composed("wait\ndo Kept()\nwait\ndo Kept()\nwait", part), steps=9)
    assert reference.records == {"first": 4.0, "last": 6.0}
    reference, _ = played(composed("wait\ndo Kept()", part), steps=2)
    assert reference.records == {"first": 1.0, "last": 2.0}  # it still runs when the time is over


def test_a_temporal_requirement_made_in_a_behavior():
    text = "behavior B():\n    take 'a'\n    require always self.position.y < 3\n    while True:\n        take 'b'\n"
    _, trace = played(text + "ego = new Object with behavior B()")
    assert trace.rejected == "require always self.position.y < 3"


def test_random_names_of_the_setup_are_drawn_with_the_scene():
    text = composed("do Part(x, 1)").replace(
        "setup:\n        ego", "setup:\n        x = Uniform('l', 'r')\n        ego"
    )
    assert [actions(text, theta=[theta]) for theta in (-1, 1)] == ["l", "r"]


def test_guards_of_the_main_scenario():
    text = PARTS + "scenario Main():\n    invariant: ego.position.y < 2\n    setup:\n"
    text += "        ego = new Object with behavior Loop('a')\n"
    assert played(text)[1].rejected == "violated invariant of Main on line 10"


# ------------------------------------------------------------ which one is the program


SEVERAL = "scenario A():\n    ego = new Object\nscenario B():\n    ego = new Object at 3 @ 3\n    new Object at 9 @ 9\n"


def test_the_scenario_that_is_asked_for():
    assert [len(load(SEVERAL, dialect=3, scenario=name).objects) for name in "AB"] == [1, 2]


def test_several_scenarios_and_no_main_one():
    with pytest.raises(ScenicError, match="there are several scenarios: A, B"):
        load(SEVERAL, dialect=3)


def test_a_scenario_that_is_not_there():
    with pytest.raises(ScenicError, match="has no scenario 'Bb'"):
        load(SEVERAL, dialect=3, scenario="Bb")


def test_the_main_scenario_takes_over_objects_but_not_monitors():
    text = "monitor M():\n    wait\nego = new Object\nrequire monitor M()\nterminate after 1 steps\n"
    program = load(text + "scenario Main():\n    new Object at 5 @ 5\n", dialect=3)
    assert (len(program.objects), program.monitors, program.terminations) == (2, (), ())


def test_variables_of_a_setup_belong_to_an_episode():
    text = composed("while n < 2:\n    n += 1\n    wait").replace(
        "setup:\n        ego", "setup:\n        n = 0\n        ego"
    )
    program = load(text, dialect=3)
    assert [Reference(program, [], toy_world()).episode.program.main_frame.locals["n"] for _ in range(2)] == [0, 0]
    assert [len(played(text)[1].commands) for _ in range(2)] == [2, 2]


def test_the_main_scenario_gets_no_arguments():
    text = "scenario Main(speed):\n    setup:\n        ego = new Object\n"
    with pytest.raises(ScenicError, match=r"1:1: Main\(speed\): 'speed' is missing") as caught:
        load(text, dialect=3)
    assert "defaults" in caught.value.hint


# ------------------------------------------------------------ where a program begins

LIMITED = """
behavior Walk():
    while True:
        take 1
ego = new Object at 0 @ 0, with behavior Walk()
terminate after Range(2, 6) steps
"""


@pytest.mark.parametrize(("theta", "steps"), [(-1.0, 2), (0.0, 4), (1.0, 6)])
def test_the_time_limit_of_a_program_is_a_column_of_theta(theta, steps):
    program = load(LIMITED, dialect=3)
    assert program.dim == 1
    _, trace = played(LIMITED, 9, theta=[theta])
    assert (len(trace.commands), trace.ending) == (steps, "scenarioComplete: reached time limit")
    controller = CompiledController(compile_program(program, toy_world()), np.array([theta]))
    compiled = run(first_table(program, np.array([theta])), controller, 9, 1.0)
    assert [each.actions for each in compiled.commands] == [each.actions for each in trace.commands]


INITIAL = """
behavior Tell():
    while True:
        take 1 if initial scenario else 2
scenario Sub():
    setup:
        inner = initial scenario
    compose:
        wait
scenario Main():
    setup:
        outer = initial scenario
        ego = new Object at 0 @ 0, with behavior Tell()
    compose:
        s = Sub()
        do s
        require outer and not s.inner
        wait
"""


def test_the_initial_scenario_is_the_one_that_loading_sets_up():
    assert actions(INITIAL, 3) == "2 2"
    assert differences(INITIAL, range(1), steps=4)[0] == []


def test_the_variables_of_a_scenario_that_has_run_are_its_attributes():
    text = """
scenario Sub(n):
    setup:
        far = n + Range(1, 2)
    compose:
        wait
scenario Main():
    setup:
        ego = new Object at 0 @ 0
    compose:
        s = Sub(2)
        do s
        require 3 <= s.far <= 4
        wait
"""
    found, compiled = differences(text, range(4), steps=4)
    assert found == []
    assert compiled.warnings == ()


@pytest.mark.parametrize(
    ("kind", "body"), [("scenario", "    compose:\n        wait\n"), ("monitor", "    while True:\n        wait\n")]
)
def test_an_object_behaves_by_a_behavior_alone(kind, body):
    text = f"{kind} Other():\n{body}ego = new Object with behavior Other()\n"
    with pytest.raises(ScenicError, match=f"must be a behavior, not the {kind} Other"):
        load(text, dialect=3)


def test_a_fault_in_a_scenario_inside_tells_who_has_called_it():
    part = "scenario Inner():\n    setup:\n        x = mate.x\nscenario Outer():\n    compose:\n        do Inner()\n"
    text = composed("mate = 1\ndo Outer()", part)
    with pytest.raises(ScenicError) as caught:
        played(text)
    said = str(caught.value)
    assert said.startswith("<program>:11:13: name 'mate' is not defined (it belongs to the scenario Main: give it to")
    assert [line.split(", ")[0] for line in said.splitlines()[-2:]] == ["    in Inner", "    in Outer"]
    assert [error.line for error in compile_program(load(text), toy_world()).diagnostics] == [11]
