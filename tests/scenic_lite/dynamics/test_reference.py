"""The reference: the two halves of a step, rewards, draws, what belongs to an episode, faults."""

import numpy as np
import pytest

from regista.envs.toy_world import toy_world
from scenic_lite import ScenicError, load
from tests.reference.interpreter import Reference
from tests.scenic_lite.dynamics.compare import differences
from tests.scenic_lite.dynamics.playing import actions, played
from tests.scenic_lite.dynamics.toy_world import first_table, run

LOOP = """
behavior Loop(w):
    while True:
        take w
"""


# ------------------------------------------------------------ rewards


def rewards(text, steps=3):
    return played(text, steps)[1].rewards


def test_reward_is_cleared_in_every_step():
    text = """
monitor Score():
    sim = simulation()
    wait
    sim.scenic_reward = 2
    wait
    wait
    sim.scenic_reward = 5
    sim.scenic_reward += 1
    wait
ego = new Object
require monitor Score()
"""
    assert rewards(text) == (0, 2, 0, 6)


def test_reward_of_a_behavior_belongs_to_the_next_verdict():
    text = """
behavior Brag():
    take 'a'
    simulation().scenic_reward = 3
    take 'b'
ego = new Object with behavior Brag()
"""
    assert rewards(text) == (0, 0, 3, 0)


def test_reward_of_none_is_refused():
    text = """
monitor Score():
    simulation().scenic_reward = None
    wait
ego = new Object
require monitor Score()
"""
    with pytest.raises(ScenicError, match="a reward is a number, not None"):
        rewards(text, 1)


def test_monitor_of_scenic_2_starts_by_being_defined():
    text = """
monitor Stop:
    while True:
        if ego.position.y >= 2:
            terminate
        wait
ego = Object
"""
    _, trace = played(text, dialect=2)
    assert trace.ending == 'terminatedByMonitor: "terminate" executed on line 5'
    assert len(trace.commands) == 2


# ------------------------------------------------------------ order


def test_whoever_is_asked_first_lets_the_scenario_take_its_step():
    text = (
        LOOP
        + """
scenario Part():
    setup:
        override ego with behavior Loop('b')
        terminate after 2 steps
scenario Main():
    setup:
        ego = new Object with behavior Loop('a')
    compose:
        do Part()
        wait
"""
    )
    program = load(text, dialect=3)
    reference = Reference(program, np.zeros(0), toy_world())
    table, seen = first_table(program, np.zeros(0)), []
    for time in range(3):
        seen.append(reference.act(table, np.array([float(time)])).actions[0])
        verdict = reference.watch(table, np.array([time + 1.0]))
    assert seen == [("b",), ("b",), ("a",)]
    assert verdict.terminated == "scenarioComplete: finished compose block"


def test_act_first_begins_with_the_conditions_of_the_scenario():
    program = load(LOOP + "ego = new Object with behavior Loop('a')\nterminate when ego.position.y >= 0", dialect=3)
    reference = Reference(program, np.zeros(0), toy_world())
    commands = reference.act(first_table(program, np.zeros(0)), np.zeros(1))
    assert commands.terminated == "scenarioComplete: termination condition on line 6"
    assert commands.actions == ((),)


LAST_STEP = """
monitor Pay{heading}:
    while True:
        simulation().scenic_reward = 1
        {last}
        wait
ego = new Object at 0 @ 0
{required}
terminate when ego.position.y >= 2
"""


@pytest.mark.parametrize("dialect, rewards", [(2, (1, 1, 1)), (3, (1, 1, 0))])
def test_monitors_of_scenic_2_pay_in_the_step_in_which_the_scenario_ends(dialect, rewards):
    heading, required = (("", ""), ("()", "require monitor Pay()"))[dialect - 2]
    text = LAST_STEP.format(heading=heading, required=required, last="pass")
    _, trace = played(text, dialect=dialect)
    assert trace.rewards == rewards
    assert trace.ending.startswith("scenarioComplete")
    assert differences(text, range(1), dialect=dialect)[0] == []


def test_what_a_monitor_of_scenic_2_says_in_the_last_step_counts():
    last = "if ego.position.y >= 2:\n            terminate"
    text = LAST_STEP.format(heading="", required="", last=last)
    assert played(text, dialect=2)[1].ending == 'terminatedByMonitor: "terminate" executed on line 6'
    assert differences(text, range(1), dialect=2)[0] == []


def test_nothing_is_asked_after_the_end():
    reference, trace = played(LOOP + "ego = new Object with behavior Loop('a')\nterminate after 2 steps")
    table, facts = np.zeros((1, 3)), np.array([9.0])
    assert reference.act(table, facts).actions == ((),)
    assert reference.watch(table, facts).terminated == trace.ending == "scenarioComplete: reached time limit"


def test_waiting_and_ended_behaviors_do_nothing():
    text = """
behavior Walk():
    take 'a'
    wait
    take 'b', 'c'
ego = new Object with behavior Walk()
new Object at 5 @ 5
"""
    _, trace = played(text, 4)
    assert [each.actions[0] for each in trace.commands] == [("a",), (), ("b", "c"), ()]
    assert all(each.agents == (0,) for each in trace.commands)


# ------------------------------------------------------------ draws


def test_a_behavior_draws_anew_and_its_arguments_are_drawn_once():
    text = """
behavior Tell(x):
    while True:
        take x, Range(0, 1)
ego = new Object with behavior Tell(Range(0, 1))
"""
    _, trace = played(text, 5, theta=[0.5])
    given, drawn = zip(*(each.actions[0] for each in trace.commands), strict=True)
    assert set(given) == {0.75}
    assert len(set(drawn)) == 5


def test_a_seed_repeats_an_episode():
    text = "behavior Tell():\n    while True:\n        take Range(0, 1)\nego = new Object with behavior Tell()"
    assert actions(text, seed=3) == actions(text, seed=3) != actions(text, seed=4)


def test_a_behavior_drawn_with_the_scene():
    text = "behavior A():\n    take 'a'\nbehavior B(w):\n    take w\nego = Object with behavior Uniform(A(), B('b'))"
    assert load(text).objects[0].behavior == "A or B"
    assert [actions(text, steps=1, dialect=2, theta=[theta]) for theta in (-1, 1)] == ["a", "b"]


def test_random_values_that_only_behaviors_read_are_columns_of_theta():
    text = """
side = Uniform('left', 'right')
unread = Range(0, 1)
def word():
    return helper()
def helper():
    return side
behavior Sub():
    take word()
behavior Main():
    do Sub()
ego = new Object with behavior Main()
terminate when late < 0.5
late = Range(0, 1)
"""
    program = load(text, dialect=3)
    assert [draw.name for draw in program.draws] == ["side", "late"]
    assert actions(text, theta=[-1, 1], steps=1) == "left"
    assert actions(text, theta=[1, 1], steps=1) == "right"
    assert actions(text, theta=[1, -1], steps=1) == ""


# ------------------------------------------------------------ what belongs to an episode


COUNTING = """
counted = []
behavior Count():
    self.tag = 0
    while True:
        counted.append(1)
        self.tag += 2
        take f'{len(counted)}{self.tag}'
ego = new Object at 0 @ 3, with behavior Count()
"""


def test_episodes_of_one_program_do_not_disturb_each_other():
    program = load(COUNTING, dialect=3)
    table, theta = first_table(program, np.zeros(0)), np.zeros(0)
    first, second = (Reference(program, theta, toy_world(), seed) for seed in (1, 2))
    taken = []
    for time in range(3):
        for each in (first, second):
            taken.append(each.act(table + time, np.array([float(time)])).actions[0][0])
    assert taken == ["12", "12", "24", "24", "36", "36"]


def test_containers_begin_every_episode_as_they_were_written():
    text = """
log, seen = [], {'n': 0}
alias = log
class Bag:
    items: [1]
behavior Add(more):
    while True:
        log.append(len(more))
        more.append(0)
        seen['n'] += len(alias)
        self.items.append(len(log))
        take f"{seen['n']}{self.items}{more}"
ego = new Bag with behavior Add(log)
"""
    program = load(text, dialect=3)
    for seed in (1, 2):
        trace = run(first_table(program, np.zeros(0)), Reference(program, np.zeros(0), toy_world(), seed), 2)
        assert [each.actions[0] for each in trace.commands] == [("2[1, 2][0, 0]",), ("6[1, 2, 4][0, 0, 2, 0]",)]
    assert program.instances[0].properties["items"] == [1]


def test_the_program_is_as_it_was_loaded_outside_of_episodes():
    program = load(COUNTING, dialect=3)
    session, (ego,) = program.mode.state, program.instances
    before = dict(vars(session))
    run(first_table(program, np.zeros(0)), Reference(program, np.zeros(0), toy_world()), 4, 1.0)
    assert vars(session) == before
    assert (ego.properties["position"].y, ego.attributes) == (3, {})
    assert program.behaviors["Count"].scope.lookup("counted") == []


# ------------------------------------------------------------ faults


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "line", "words"),
    [
        ("    take 'a'\n    take 1 / 0", 3, "division by zero"),
        ("    take [1, 2][2]", 2, "list index out of range"),
        ("    take nobody", 2, "name 'nobody' is not defined"),
        ("    take self.nothing", 2, "Object has no property 'nothing'"),
        ("    do 5", 2, "`do` needs a behavior, not a number"),
        ("    do B", 2, "`do` needs a behavior, not a behavior without its arguments (write B())"),
        ("    do B() for 'a' steps", 2, "a duration is a number, not a text"),
        ("    do choose {B(): 'a', B(): 1}", 2, "a weight is a number, and not negative: 'a'"),
        ("    take 'a'\n    new Object at 5 @ 5", 3, "no object can be made in a behavior"),
        (
            "    try:\n        wait\n    interrupt when B():\n        wait",
            4,
            "a behavior cannot be called in a condition",
        ),
        ("    while self.position.y < 3:\n        n = len([])\n    take 'a'", 2, "without an action"),
    ],
)
def test_a_fault_at_run_time_has_its_place(body, line, words):
    with pytest.raises(ScenicError) as caught:
        played(f"behavior B():\n{body}\nego = new Object with behavior B()", 3)
    assert words in str(caught.value)
    assert caught.value.line in (line, line + 1 if "without an action" in words else line)


def test_behaviors_that_call_each_other_for_ever():
    with pytest.raises(ScenicError, match="more than 40 deep"):
        played("behavior B():\n    do B()\nego = new Object with behavior B()")


def test_a_fault_leaves_the_program_as_it_was():
    program = load("behavior B():\n    take 1 / 0\nego = new Object with behavior B()", dialect=3)
    before = dict(vars(program.mode.state))
    with pytest.raises(ScenicError):
        run(first_table(program, np.zeros(0)), Reference(program, np.zeros(0), toy_world()), 4)
    assert vars(program.mode.state) == before


def test_one_behavior_for_two_objects():
    text = LOOP + "b = Loop('a')\nego = new Object with behavior b\nnew Object at 5 @ 5, with behavior b"
    with pytest.raises(ScenicError, match="Loop already is the behavior of another object") as caught:
        played(text)
    assert caught.value.line == 5


def test_a_choice_among_nothing_rejects_the_episode():
    _, trace = played("behavior B():\n    take Uniform(*[])\nego = new Object with behavior B()")
    assert trace.rejected == "a choice among no values"
