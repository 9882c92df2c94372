"""The forms that Scenic adds: precedence, instances, specifiers, statements, the differences of the dialects."""

import ast

import pytest
from tree_sketch import sketch, statements, value

from scenic_lite.errors import ScenicError
from scenic_lite.syntax import nodes
from scenic_lite.syntax.parser import parse

# Expression, tree in dialect 3. Brackets mark Scenic's operators, operations with one of them inside, and instances.
PRECEDENCE = [
    ("1 + 2 @ 3", "1 + 2 @ 3"),
    ("(1 + 2) @ -(3 - 8)", "(1 + 2) @ -(3 - 8)"),
    ("2 * 3 @ 4", "2 * 3 @ 4"),
    ("2 * 45 deg", "(deg 2 * 45)"),
    ("10 + 80 deg", "(+ 10 (deg 80))"),
    ("-90 deg", "(deg -90)"),
    ("180 / 2 deg", "(deg 180 / 2)"),
    ("3 @ 4 deg", "(deg 3 @ 4)"),
    ("30 deg relative to 40 deg", "(relative to (deg 30) (deg 40))"),
    ("45 deg relative to ego.heading + 1", "(relative to (deg 45) ego.heading + 1)"),
    ("Range(30, 50) deg relative to h", "(relative to (deg Range(30, 50)) h)"),
    ("a relative to b relative to c", "(relative to (relative to a b) c)"),
    ("self offset along (45 deg relative to h) by 0 @ 3", "(offset along self (relative to (deg 45) h) 0 @ 3)"),
    ("self offset along 45 deg relative to h by 0 @ 3", "(offset along self (relative to (deg 45) h) 0 @ 3)"),
    ("a offset by 1 @ 2 relative to c", "(relative to (offset by a 1 @ 2) c)"),
    ("distance from a to b + 1", "(distance a b + 1)"),
    ("distance to b from a", "(distance a b)"),
    ("distance to a", "(distance - a)"),
    ("distance from a", "(distance a -)"),
    ("(distance from a to b) > 3 and x < 2", "(and (> (distance a b) 3) x < 2)"),
    ("distance from a to b > 3", "(> (distance a b) 3)"),
    ("distance from a to b @ c", "(distance a b @ c)"),
    ("distance from x if y else z to b", "(distance x if y else z b)"),
    ("distance from a relative to b to c", "(distance (relative to a b) c)"),
    ("distance to x offset by 3 @ 4", "(offset by (distance - x) 3 @ 4)"),
    ("distance to distance to a", "(distance - (distance - a))"),
    ("abs(distance from a to (3 @ 4)) / 2", "(/ (abs (distance a 3 @ 4)) 2)"),
    ("angle from a to b", "(angle a b)"),
    ("angle to front of ego", "(angle - (front of ego))"),
    ("relative heading of a from b < 3", "(< (relative heading of a b) 3)"),
    ("apparent heading of a from 1 @ 2", "(apparent heading of a 1 @ 2)"),
    ("relative position of a", "(relative position of a -)"),
    ("distance past 3 @ 1 of b", "(distance past 3 @ 1 b)"),
    ("a can see b or c", "(or (can see a b) c)"),
    ("not a can see b", "(not (can see a b))"),
    ("x intersects y", "(intersects x y)"),
    ("x in visible region", "(in x (visible region))"),
    ("x in not visible region", "(in x (not visible region))"),
    ("not x in visible region", "(not (in x (visible region)))"),
    ("not visible region", "(not visible region)"),
    ("not visible", "not visible"),
    ("not visible.x and visible", "not visible.x and visible"),
    ("visible relative position of a", "(visible (relative position of a -))"),
    ("region visible from ego", "(visible from region ego)"),
    ("region not visible from ego", "(not visible from region ego)"),
    ("field at 3 @ 4 + 1", "(at field 3 @ 4 + 1)"),
    ("follow f from 1 @ 2 for 3 + 4", "(follow f 1 @ 2 3 + 4)"),
    ("front left of ego", "(front left of ego)"),
    ("left of ego offset by 3 @ 4", "(offset by (left of ego) 3 @ 4)"),
    ("a if distance to b < 3 else c", "(if (< (distance - b) 3) a c)"),
    ("f(1 @ 2, b=3 deg)", "(f 1 @ 2 b=(deg 3))"),
    ("(field relative to 30 deg) relative to g", "(relative to (relative to field (deg 30)) g)"),
    ("initial scenario", "(initial scenario)"),
]


@pytest.mark.parametrize(("text", "tree"), PRECEDENCE)
def test_precedence(text, tree):
    assert value(text) == tree


SCENIC_2 = [
    ("distance to x offset by 3 @ 4", "(distance - (offset by x 3 @ 4))"),
    ("angle from a to b relative to c", "(angle a (relative to b c))"),
    ("1 + distance to a", "(+ 1 (distance - a))"),
    ("distance from a to b > 3", "(> (distance a b) 3)"),
    ("-distance to a", "(- (distance - a))"),
]


@pytest.mark.parametrize(("text", "tree"), SCENIC_2)
def test_word_operators_reach_further_in_scenic_2(text, tree):
    assert value(text, 2) == tree


INSTANCES = [
    ("new Ball", "Ball<>"),
    ("new Ball at 1 @ 2, facing 30 deg relative to ego", "Ball<at 1 @ 2, facing (relative to (deg 30) ego)>"),
    ("new Ball ahead of Uniform(a, b) by 1 @ 2", "Ball<ahead of Uniform(a, b) 1 @ 2>"),
    (
        "new Car left of a offset by 3 @ 4 by 2, with x 3 if y else 4",
        "Car<left of (offset by a 3 @ 4) 2, with 'x' 3 if y else 4>",
    ),
    ("new Car beyond a by 3 @ 4 from 1 @ 1, facing toward b", "Car<beyond a 3 @ 4 1 @ 1, facing toward b>"),
    ("new football.Ball in r", "football.Ball<in r>"),
    ("Ball on r", "Ball<on r>"),
    ("ball on r", "ball<on r>"),
    ("Ball contained in r", "Ball<contained in r>"),
    ("Ball right of a", "Ball<right of a ->"),
    ("Ball behind a by 2", "Ball<behind a 2>"),
    ("Ball above a by 2, below b", "Ball<above a 2, below b ->"),
    ("Ball visible", "Ball<visible ->"),
    ("Ball not visible", "Ball<not visible ->"),
    ("Ball following f for 3", "Ball<following f - 3>"),
    ("Ball following f from v for 3", "Ball<following f v 3>"),
    ("Ball facing away from v", "Ball<facing away from v>"),
    ("Ball facing directly toward v", "Ball<facing directly toward v>"),
    ("Ball facing directly away from v", "Ball<facing directly away from v>"),
    ("Ball facing toward", "Ball<facing toward>"),
    ("Ball apparently facing 3 deg from v", "Ball<apparently facing (deg 3) v>"),
    ("Ball apparently facing h", "Ball<apparently facing h ->"),
    ("Ball with width 2, offset along h by v", "Ball<with 'width' 2, offset along h v>"),
    # One specifier that is also an operator: both readings, as precedence would group each.
    ("Ball at x", "Ball<at x>?(at Ball x)"),
    ("Ball in r", "Ball<in r>?Ball in r"),
    ("Ball offset by v", "Ball<offset by v>?(offset by Ball v)"),
    ("Ball offset along h by v", "Ball<offset along h v>?(offset along Ball h v)"),
    ("Ball visible from v", "Ball<visible v>?(visible from Ball v)"),
    ("Ball not visible from v", "Ball<not visible v>?(not visible from Ball v)"),
    ("Ball at x relative to y", "Ball<at (relative to x y)>"),
    ("Ball at x if a else y", "Ball<at x if a else y>"),
    ("Ball in r and b", "Ball in r and b"),
    ("Ball in r < s", "(Ball in r) < s"),
    ("a.Ball at x", "a.Ball<at x>?(at a.Ball x)"),
    ("Ball at x, with y 3", "Ball<at x, with 'y' 3>"),
    # In brackets a comma belongs to the instance as long as a specifier follows.
    ("f(A at 1 @ 2, with y 3, z)", "(f A<at 1 @ 2, with 'y' 3> z)"),
    ("f(A on r, facing=3)", "(f A<on r> facing=3)"),
    ("field at x", "(at field x)"),
    ("X + A at x", "(at X + A x)"),
]


@pytest.mark.parametrize(("text", "tree"), INSTANCES)
def test_instances(text, tree):
    assert value(text) == tree


def test_a_capitalised_name_alone_may_be_an_instance_in_scenic_2():
    alone, assigned, called = statements("LeftGK\nx = LeftCB\nf(LeftCB)\n")
    assert sketch(alone.value) == "LeftGK<>?name" and sketch(assigned.value) == "LeftCB<>?name"
    assert sketch(called.value) == "f(LeftCB)"
    assert all(isinstance(each.value, ast.Name) for each in statements("LeftGK\nx = LeftCB\n", 3))


def test_conditions_begin_with_no_instance():
    (statement,) = statements("if Left in teams: pass")
    assert isinstance(statement.test, ast.Compare)
    (statement,) = statements("assert 3 < f(Left at x)")
    assert sketch(statement.test) == "(< 3 (f Left<at x>?(at Left x)))"


MULTILINE = """
ego = Ball ahead of ego by 2,   # the first one
    with x 3,

# a comment between
      with y (4,
 5),
    facing 3
team = [A at 1 @ 2,
with y 3, B on r]
A on r,
    with z 1
"""


def test_specifiers_over_several_lines():
    ego, team, last = statements(MULTILINE)
    assert sketch(ego.value) == "Ball<ahead of ego 2, with 'x' 3, with 'y' (4, 5), facing 3>"
    assert [sketch(each) for each in team.value.elts] == ["A<at 1 @ 2, with 'y' 3>", "B<on r>"]
    assert sketch(last.value) == "A<on r, with 'z' 1>"


def test_specifiers_over_several_lines_at_the_end_of_a_block():
    (statement,) = statements("if x:\n    A on r,\n        with y 3\nelse:\n    pass\n")
    assert sketch(statement.body[0].value) == "A<on r, with 'y' 3>" and statement.orelse


STATEMENTS = [
    ("model a.b.c", "Model 'a.b.c'"),
    ("param time = 3, 'a b' = x", "Param ['time' 'a b'] [3 x]"),
    ("require x > 3", "Require x > 3 - -"),
    ("require (x) > 3 as safe", "Require x > 3 - 'safe'"),
    ("require[0.5] x as 'soft one'", "Require x 0.5 'soft one'"),
    ("require relative heading of a from b < 3", "Require (< (relative heading of a b) 3) - -"),
    ("require visible region", "Require (visible region) - -"),
    ("require not visible", "Require not visible - -"),
    ("require not a can see b", "Require (not (can see a b)) - -"),
    ("require always x", "Require (always x) - -"),
    ("require (a < 6) until (b >= 8)", "Require (until a < 6 b >= 8) - -"),
    ("require (a > 9) implies (next b > 1)", "Require (implies a > 9 (next b > 1)) - -"),
    ("require always a and b implies c", "Require (always (implies a and b c)) - -"),
    ("require not eventually x or y", "Require (not (eventually x or y)) - -"),
    ("require f(next(x), implies)", "Require f(next(x), implies) - -"),
    ("require monitor M(3)", "RequireMonitor M(3)"),
    ("mutate", "Mutate [] -"),
    ("mutate a, b by 2", "Mutate [a b] 2"),
    ("mutate by 2", "Mutate [] 2"),
    ("record x as y", "Record x 'each' 'y' - - - - -"),
    ("record initial x", "Record x 'initial' - - - - - -"),
    ("record final x every 2 steps after 3 seconds to 'f'", "Record x 'final' - 2 'steps' 3 'seconds' 'f'"),
    ("record initial scenario", "Record (initial scenario) 'each' - - - - - -"),
    ("simulator Football(timestep=0.1)", "Simulator Football(timestep=0.1)"),
    ("terminate when x > 3", "TerminateWhen x > 3 'scenario' -"),
    ("terminate simulation when x as done", "TerminateWhen x 'simulation' 'done'"),
    ("terminate after 10 seconds", "TerminateAfter 10 'seconds'"),
    ("terminate", "Terminate 'scenario'"),
    ("terminate simulation", "Terminate 'simulation'"),
    ("take a, b", "Take [a b]"),
    ("take (a, b)", "Take [(a, b)]"),
    ("take x if y else z", "Take [x if y else z]"),
    ("take -x", "Take [-x]"),
    ("wait", "Wait - - -"),
    ("wait for 3 steps", "Wait 3 'steps' -"),
    ("wait until x > 3", "Wait - - x > 3"),
    ("do A()", "Do [A()] 'all' - - - -"),
    ("do A(), B()", "Do [A() B()] 'all' - - - -"),
    ("do A() until x > 3", "Do [A()] 'all' - - - x > 3"),
    ("do A() for 3 seconds", "Do [A()] 'all' - 3 'seconds' -"),
    ("do choose A(), B()", "Do [A() B()] 'choose' - - - -"),
    ("do shuffle {A(): 1, B(): 2}", "Do [A() B()] 'shuffle' [1 2] - - -"),
    ("do choose {A(): 1} until x", "Do [A()] 'choose' [1] - - x"),
    ("abort", "Abort"),
    ("override ego with x 3, with y 4", "Override ego [with 'x' 3 with 'y' 4]"),
    ("override cars[0].driver with x 3", "Override cars[0].driver [with 'x' 3]"),
]


@pytest.mark.parametrize("dialect", [2, 3])
@pytest.mark.parametrize(("text", "tree"), STATEMENTS)
def test_statements(text, tree, dialect):
    (statement,) = statements(text, dialect)
    assert sketch(statement) == tree


NAMES = """
distance = distance from p to q
position = heading = angle = left = right = front = visible = 3
facing.toward = ahead[behind]
take = wait(model, record)
param = simulator + mutate
monitor, behavior = scenario.setup, compose
initial = final; always = next(eventually)
interrupt = abort or terminate
model.x = override(x)
follow(x)
relative = apparent * past
"""


def test_soft_words_are_names_elsewhere():
    body = statements(NAMES, 3)
    assert all(isinstance(each, ast.Assign | ast.Expr) for each in body)
    assert sketch(body[0].value) == "(distance p q)"
    without_first = NAMES.split("\n", 2)[2]
    assert ast.dump(ast.Module(body[1:], [])) == ast.dump(ast.parse(without_first))


HARD = ["at", "by", "do", "new", "of", "on", "require", "to", "until"]


@pytest.mark.parametrize("word", HARD)
def test_hard_words_of_scenic_3(word):
    text = f"{word} = {word} + 1\nx = f({word}, y={word}[0])\n"
    assert ast.dump(parse(text, dialect=2)) == ast.dump(ast.parse(text))
    with pytest.raises(ScenicError) as caught:
        parse(text, dialect=3)
    assert f'"{word}" is a word of the language' in str(caught.value)


def test_durations_have_a_unit_in_scenic_3():
    (statement,) = statements("do A() for 3", 2)
    assert sketch(statement) == "Do [A()] 'all' - 3 'seconds' -"
    with pytest.raises(ScenicError, match='expected "seconds" or "steps"'):
        parse("do A() for 3", dialect=3)


BEHAVIOR = '''
behavior Run(goal, speed=3 deg):
    """Run there."""
    precondition: self.x < 3
    invariant: goal
    try:
        do Move(goal) until self.x > 3
    interrupt when distance to ball < 2:
        take Shoot()
        abort
    interrupt when x:
        wait
'''


def test_behavior():
    (node,) = statements(BEHAVIOR)
    assert isinstance(node, nodes.Behavior) and node.kind == "behavior" and node.docstring == "Run there."
    assert [each.arg for each in node.args.args] == ["goal", "speed"]
    assert [sketch(each) for each in (*node.preconditions, *node.invariants)] == ["self.x < 3", "goal"]
    (attempt,) = node.body
    assert isinstance(attempt, nodes.TryInterrupt)
    assert [sketch(each.condition) for each in attempt.interrupts] == ["(< (distance - ball) 2)", "x"]
    assert [sketch(each) for each in attempt.interrupts[0].body] == ["Take [Shoot()]", "Abort"]


def test_monitors_with_and_without_brackets():
    for dialect in (2, 3):
        bare, bracketed = statements("monitor M:\n  wait\nmonitor N(x):\n  wait\n", dialect)
        assert (bare.kind, bare.started, bare.args.args) == ("monitor", True, [])
        assert (bracketed.kind, bracketed.started, bracketed.args.args[0].arg) == ("monitor", False, "x")


def test_scenarios():
    text = (
        "scenario S(x):\n  'doc'\n  precondition: x\n  setup:\n    y = 1\n  compose:\n    do A(), B()\n"
        "scenario T:\n  z = 2\n"
    )
    first, second = statements(text)
    assert (first.docstring, len(first.preconditions), len(first.setup)) == ("doc", 1, 1)
    assert sketch(first.compose[0]) == "Do [A() B()] 'all' - - - -"
    assert len(second.setup) == 1 and second.compose == []


def test_properties_of_classes():
    text = "class A(B):\n  width: 3\n  x[dynamic, final]: Point on r\n  behavior: None\n  def f(self):\n    pass\n"
    (node,) = statements(text)
    assert [sketch(each) for each in node.body[:3]] == [
        "PropertyDefault 'width' [] 3",
        "PropertyDefault 'x' ['dynamic' 'final'] Point<on r>",
        "PropertyDefault 'behavior' [] None",
    ]


# What the published football programs write that must not break.
CURIOSITIES = [
    ("LeftRM at - 10 @ 20", "LeftRM<at -10 @ 20>?(at LeftRM -10 @ 20)"),
    ("LeftGK at 95 @ 40, with HoldPosition()", "LeftGK<at 95 @ 40, with 'HoldPosition' ()>"),
    ("Range (0, 80)", "Range(0, 80)"),
    ("Ball with bahavior B(), on r #, with behavior C()", "Ball<with 'bahavior' B(), on r>"),
    ("90 @ Uniform(-1, 1)", "90 @ Uniform(-1, 1)"),
    (
        "Point at self offset along (30 deg) by 0 @ 2",
        "Point<at (offset along self (deg 30) 0 @ 2)>",
    ),
    (
        "team.append(LeftPlayer with role r, at -40 @ (10 * i - 15))",
        "(team.append LeftPlayer<with 'role' r, at -40 @ (10 * i - 15)>)",
    ),
    ("do_it(Point on r, sprint=True)", "(do_it Point<on r> sprint=True)"),
]


@pytest.mark.parametrize(("text", "tree"), CURIOSITIES)
def test_curiosities_of_football_programs(text, tree):
    assert value(text, 2) == tree


def test_tabs_in_one_block_and_blanks_in_another():
    text = (
        'behavior A():\n\t"""doc"""\n\ttake x\nbehavior B():\n    while True:\n        interrupted = 1\n        take y'
    )
    assert [len(each.body) for each in statements(text)] == [1, 1]


def test_docstring_and_forward_references_need_no_order():
    text = "behavior A():\n    do B(ball)\nego = LeftGK with behavior A()\nball = Ball ahead of ego by 2\n"
    assert len(statements(text)) == 3


def test_interrupt_condition_with_a_draw():
    text = "behavior A():\n  try: do B()\n  interrupt when (distance from self to op) < Range(8, 20): take C()\n"
    (node,) = statements(text)
    assert sketch(node.body[0].interrupts[0].condition) == "(< (distance self op) Range(8, 20))"


def test_every_node_has_its_place():
    text = "\n".join(text for text, _ in STATEMENTS) + BEHAVIOR + MULTILINE
    tree = parse(text)
    kinds = set()
    lines = text.split("\n")
    for node in ast.walk(tree):
        kinds.add(type(node))
        if isinstance(node, ast.expr | ast.stmt):
            assert 1 <= node.lineno <= node.end_lineno <= len(lines)
            assert (node.lineno, node.col_offset) < (node.end_lineno, node.end_col_offset)
            assert node.end_col_offset <= len(lines[node.end_lineno - 1])
    assert {nodes.New, nodes.Specifier, nodes.Operator, nodes.TryInterrupt} <= kinds


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        ("x = distance from é to b + 1", "distance from é to b + 1"),
        ("x = (a) relative to (b)", "(a) relative to (b)"),
        ("x = Ball at 3 @ 4, with y 3", "Ball at 3 @ 4, with y 3"),
        ("x = 'é' + front of ego", "'é' + front of ego"),
    ],
)
def test_places_in_the_text(text, culprit):
    (statement,) = statements(text)
    assert text[statement.value.col_offset : statement.value.end_col_offset] == culprit


def test_params_know_the_places_of_their_names():
    (statement,) = statements("param time = 3, 'a b' = x")
    assert [(each.col_offset, each.end_col_offset) for each in statement.places] == [(6, 10), (16, 21)]
