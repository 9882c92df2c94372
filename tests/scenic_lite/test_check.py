"""The rules about what may stand where: all findings at once, each at its place."""

import pytest

from scenic_lite.syntax.check import check
from scenic_lite.syntax.parser import parse


def findings(text):
    return [(error.line, error.column, error.message) for error in check(parse(text, "p"), text, "p")]


FINE = [
    "behavior A():\n  take x\n  do B() until y\n  wait\n  terminate\n",
    "monitor M():\n  while True:\n    if x: terminate\n    wait\nrequire monitor M()\n",
    "behavior A():\n  try: take x\n  interrupt when y:\n    for i in z:\n      if i: abort\n      break\n",
    "scenario S():\n  setup:\n    param x = 3\n    terminate when y\n  compose:\n    do A(), B()\n    wait\n",
    "behavior A():\n  do choose B(), C()\n  return\n",
    "behavior A():\n  def f():\n    return 3\n  take f()\n",
    "behavior A():\n  while True:\n    k += 1\n    if k > 3: break\n  take x\n",
    "behavior A():\n  while k < 3:\n    k += 1\n  take x\n",
    "behavior A():\n  while self.far:\n    take x\n",
    "behavior A():\n  while queue:\n    queue.pop()\n  take x\n",
    "def f():\n  while True: pass\n",
    "require always x implies (next y and not eventually z)\n",
    "class A:\n  width: 1\n  length: 1\nclass B:\n  width: 1\n",
    "param x = 1\nparam x = 2\n",
    "while x:\n  if y: break\nelse: z\nfor i in j: continue\n",
    "behavior A():\n  do B()\nx = A()\n",
]


@pytest.mark.parametrize("text", FINE)
def test_fine(text):
    assert findings(text) == []


WRONG = [
    ("take x", 1, 1, '"take" may only stand in a behavior, not at the top level'),
    ("monitor M:\n  take x\n  wait", 2, 3, '"take" may only stand in a behavior, not in the monitor "M"'),
    ("def f():\n  take x", 2, 3, '"take" may only stand in a behavior, not in the function "f"'),
    (
        "behavior A():\n  take x\n  def f():\n    take y",
        4,
        5,
        '"take" may only stand in a behavior, not in the function "f"',
    ),
    ("scenario S():\n  compose:\n    take x", 3, 5, '"take" may only stand in a behavior, not in a compose block'),
    ("wait", 1, 1, '"wait" may only stand in a behavior, a monitor or a compose block, not at the top level'),
    ("do A()", 1, 1, '"do" may only stand in a behavior, a monitor or a compose block, not at the top level'),
    ("terminate", 1, 1, '"terminate" may only stand in a behavior, a monitor or a compose block, not at the top level'),
    (
        "try: x\ninterrupt when y: z",
        1,
        1,
        '"interrupt when" may only stand in a behavior, a monitor or a compose block, not at the top level',
    ),
    ("behavior A():\n  take x\n  abort", 3, 3, '"abort" may only stand in the block of an "interrupt when"'),
    ("behavior A():\n  do B(), C()", 2, 3, '"do" takes one behavior here; several at once only in a compose block'),
    ("behavior A():\n  take x\n  param y = 3", 3, 3, '"param" cannot stand in the behavior "A"'),
    ("behavior A():\n  take x\n  mutate", 3, 3, '"mutate" cannot stand in the behavior "A"'),
    ("behavior A():\n  take x\n  model y", 3, 3, '"model" cannot stand in the behavior "A"'),
    ("behavior A():\n  take x\n  record y", 3, 3, '"record" cannot stand in the behavior "A"'),
    ("monitor A:\n  wait\n  terminate when y", 3, 3, '"terminate when" cannot stand in the monitor "A"'),
    ("behavior A():\n  take x\n  behavior B():\n    take y", 3, 3, 'a behavior cannot stand in the behavior "A"'),
    ("return 3", 1, 1, '"return" may only stand in a function or a behavior'),
    ("break", 1, 1, '"break" may only stand in a loop'),
    ("while x:\n  def f():\n    continue", 3, 5, '"continue" may only stand in a loop'),
    ("class A:\n  width: 1\n  x: 2\n  width: 3", 4, 3, 'the property "width" occurs twice in the class "A"'),
    ("param a = 1, b = 2, 'a' = 3", 1, 21, 'the parameter "a" occurs twice in one statement'),
    ("monitor M():\n  wait\nrequire M()", 3, 9, '"M" is a monitor'),
    ("require[0.5] always x", 1, 14, "a temporal requirement cannot have a probability"),
    ("require (always x) + 1 > 3", 1, 10, '"always" cannot be an operand here'),
    (
        "behavior A():\n  x = 3\nego = LeftGK with behavior A()",
        3,
        28,
        'the behavior "A" of line 1 never takes an action',
    ),
    (
        "behavior A():\n  take x\n  while True:\n    y = 3",
        3,
        3,
        'this loop never lets time pass: there is no "take", "wait" or "do" in it',
    ),
]


@pytest.mark.parametrize(("text", "line", "column", "message"), WRONG)
def test_wrong(text, line, column, message):
    assert findings(text) == [(line, column, message)]


# The thesis's Figures 2.3 and 2.4 as printed, with the `wait` outside of the loop.
FIGURES = """
monitor CustomRewardMonitor:
    sim = simulation()
    while True:
        ball_y = sim.game_ds.ball.position.y
        if ball_y > 70 and abs(ball_y) < 50:
            sim.scenic_reward = 0.1
        else:
            sim.scenic_reward = 0
    wait
monitor CustomTerminationMonitor:
    sim = simulation()
    while True:
        if sim.game_ds.ball.position.x > 0:
            terminate
    wait
"""


def test_figures_as_printed_never_wait():
    message = 'the monitor "Custom{}Monitor" never waits: there is no "wait" in this loop'
    assert findings(FIGURES) == [(4, 5, message.format("Reward")), (13, 5, message.format("Termination"))]
    assert findings(FIGURES.replace("    wait", "        wait")) == []


def test_all_findings_at_once_sorted_by_place():
    text = "wait\nbehavior A():\n  take x\n  abort\n  param y = 1\ntake z\nclass C:\n  a: 1\n  a: 2\nabort"
    assert [line for line, _, _ in findings(text)] == [1, 4, 5, 6, 9, 10]


DOUBTFUL = [
    (
        "LeftGK at 1 @ 2, facing -90",
        "angles are in radians, and this one makes 14 turns",
        'degrees are written "90 deg"',
    ),
    (
        "LeftGK with viewAngle 60",
        "angles are in radians, and this one makes 10 turns",
        'degrees are written "90 deg"',
    ),
]


DOUBTFUL += [
    (
        "ego = new Ball at 1 @ 2\nBall ahead of ego by 3",
        "this is written as in Scenic 2, and the program is read as Scenic 3",
        'write "new" before the class',
    ),
    (
        "monitor M:\n  wait\nego = new Ball at 1 @ 2",
        "this is written as in Scenic 2, and the program is read as Scenic 3",
        'write "monitor M():" and "require monitor M()"',
    ),
    (
        "monitor M():\n  wait\nego = new Ball at 1 @ 2",
        'the monitor "M" is never required',
        'write "require monitor M()"',
    ),
]


@pytest.mark.parametrize(("text", "message", "hint"), DOUBTFUL)
def test_doubtful_specifiers_are_warnings(text, message, hint):
    (warning,) = check(parse(text), text, "p")
    assert (warning.kind, warning.message, warning.hint) == ("warning", message, hint)


def test_new_is_of_the_other_dialect_in_a_program_of_scenic_2():
    text = "ego = Ball on pitch\nb = new Ball at 3 @ 4\n"
    (warning,) = check(parse(text), text, "p", 2)
    assert (warning.line, warning.hint) == (2, 'leave out the "new"')


def test_a_library_may_leave_its_monitors_to_others():
    assert findings("monitor M():\n  wait\nbehavior B():\n  wait\n") == []
    assert findings("monitor M():\n  wait\nego = new Ball\nrequire monitor M()\n") == []
    assert findings("monitor M:\n  wait\nego = Ball on pitch\n") == []


def test_a_finding_shows_its_line():
    text = "class A:\n    width: 2\n    width: 3  # again\n"
    (error,) = check(parse(text), text, "a.scenic")
    assert str(error) == (
        'a.scenic:3:5: the property "width" occurs twice in the class "A"\n        width: 3  # again\n        ^^^^^^^^'
    )
