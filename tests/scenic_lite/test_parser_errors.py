"""What is said about programs that cannot be read: the words, the place, the line with the culprit underlined."""

import pytest

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.parser import parse

# ruff: noqa: E501 (the messages stand as they are printed)

# Program, then what is printed (after "p.scenic:"); the culprit's line is the last of the program if none follows.
MESSAGES = """
behaviour Foo():
    take 3
>>> 1:1: unknown statement "behaviour" (it is spelled "behavior")
    behaviour Foo():
    ^^^^^^^^^
---
behavior Foo():
    wait
    invariant: True
>>> 3:5: "invariant" may only stand before the first statement
        invariant: True
        ^^^^^^^^^
---
behavior Foo()
    take 3
>>> 1:15: expected ":" after the behavior "Foo", found the end of the line
    behavior Foo()
                  ^
---
behavior Foo:
    take 3
>>> 1:13: expected "(" after the name of the behavior "Foo", found ":" (write "()" if it takes nothing)
    behavior Foo:
                ^
---
requier x > 3
>>> 1:1: unknown statement "requier" (did you mean "require"?)
    requier x > 3
    ^^^^^^^
---
ego = Ball ahed of ego by 2
>>> 1:12: unknown specifier "ahed" (did you mean "ahead of"?)
    ego = Ball ahed of ego by 2
               ^^^^
---
ego = new Ball at 3 @ 4, wiht behavior Foo()
>>> 1:26: unknown specifier "wiht" (did you mean "with"?)
    ego = new Ball at 3 @ 4, wiht behavior Foo()
                             ^^^^
---
ego = Ball ahead of ego 2
>>> 1:25: expected "by" before the distance of "ahead of" (write "ahead of X by 2")
    ego = Ball ahead of ego 2
                            ^
---
ego = Ball beyond a 3
>>> 1:21: expected "by" in "beyond", found "3" (write "beyond X by D [from Y]")
    ego = Ball beyond a 3
                        ^
---
ego = Ball at 3 @ 4 with behavior Foo()
>>> 1:21: expected a comma before the specifier "with"
    ego = Ball at 3 @ 4 with behavior Foo()
                        ^^^^
---
ego = Ball at 3 @ 4,
x = 3
>>> 1:20: a comma ends the line, but no indented specifier follows (take the comma away, or indent the next specifier)
    ego = Ball at 3 @ 4,
                       ^
---
ego = Ball at 3 @ 4
    with behavior Foo()
>>> 2:5: the line is indented deeper than the one before (a comma at the end of the line before lets its specifiers go on)
        with behavior Foo()
        ^^^^
---
ego = Ball with x = 3
>>> 1:19: "=" between a property and its value (write "with x value")
    ego = Ball with x = 3
                      ^
---
ego = Ball at
>>> 1:14: expected a value after "at", found the end of the line
    ego = Ball at
                 ^
---
if x = 3:
    pass
>>> 1:6: "=" assigns and cannot stand in a condition ("==" compares)
    if x = 3:
         ^
---
require x = 3
>>> 1:11: "=" assigns and cannot stand in a condition ("==" compares)
    require x = 3
              ^
---
require[1.5] x
>>> 1:9: the probability of a soft requirement must lie between 0 and 1, not 1.5
    require[1.5] x
            ^^^
---
require[p] x
>>> 1:9: the probability of a soft requirement must be a number between 0 and 1 (write "require[0.5] condition")
    require[p] x
            ^
---
x = (1 + [2, 3)
>>> 1:15: ")" does not match the "[" of line 1 (close it with "]" first)
    x = (1 + [2, 3)
                  ^
---
monitor M
    wait
>>> 1:10: expected ":" after the monitor "M", found the end of the line
    monitor M
             ^
---
try:
    do A()
x = 3
>>> 3:1: expected "interrupt when" after the block of "try", found "x"
    x = 3
    ^
---
interrupt when x:
    pass
>>> 1:1: "interrupt when" without "try" before it (indent it like the "try" to which it belongs)
    interrupt when x:
    ^^^^^^^^^
---
do Foo() untill x
>>> 1:10: unexpected "untill" after the behavior (did you mean "until"?)
    do Foo() untill x
             ^^^^^^
---
do Foo() for 3 second
>>> 1:16: unknown unit "second" (write "seconds")
    do Foo() for 3 second
                   ^^^^^^
---
take
>>> 1:5: expected an action after "take" (to do nothing for a step, write "wait")
    take
        ^
---
class = 3
>>> 1:1: "class" is a word of the language and cannot be the name of a variable
    class = 3
    ^^^^^
---
x = 90 degrees
>>> 1:8: unexpected "degrees" after the end of the statement (angles are written "90 deg")
    x = 90 degrees
           ^^^^^^^
---
x = distance a to b
>>> 1:14: unexpected "a" after the end of the statement (write "distance from X to Y")
    x = distance a to b
                 ^
---
x = a && b
>>> 1:8: expected a value, found "&" (it is written "and")
    x = a && b
           ^
---
if x:
    pass
else if y:
    pass
>>> 3:6: "else if" is written "elif"
    else if y:
         ^^
---
if x:
pass
>>> 2:1: expected an indented block after the condition of "if" in line 1, found "pass"
    pass
    ^^^^
---
class A:
    width[dynmic]: 3
>>> 2:11: unknown attribute "dynmic" of a property (did you mean "dynamic"?)
        width[dynmic]: 3
              ^^^^^^
---
class A:
    width 3
>>> 2:11: unexpected "3" after the end of the statement (a property is written "width: default")
        width 3
              ^
---
param time: 3
>>> 1:11: expected "=" after the name of the parameter "time", found ":" (write "param name = value")
    param time: 3
              ^
---
terminate if x
>>> 1:11: unexpected "if" after "terminate" (write "terminate when condition", "terminate after 10 seconds" or "terminate" alone)
    terminate if x
              ^^
---
x = f"{a"
>>> 1:7: a "{" in an f-string is never closed (write "{{" for the character)
    x = f"{a"
          ^
---
f(x) = 3
>>> 1:1: this cannot be assigned to
    f(x) = 3
    ^^^^
"""


def cases():
    for case in MESSAGES.strip("\n").split("\n---\n"):
        program, printed = case.split("\n>>> ")
        yield pytest.param(program + "\n", "p.scenic:" + printed, id=program.split("\n")[0].strip())


@pytest.mark.parametrize(("program", "printed"), list(cases()))
def test_messages(program, printed):
    with pytest.raises(ScenicError) as caught:
        parse(program, "p.scenic")
    assert caught.value.kind == "syntax"
    assert str(caught.value).rstrip() == printed.rstrip()


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("to = 3", '"to" is a word of the language and cannot be the name of a variable'),
        ("def new(): pass", '"new" is a word of Scenic 3 and cannot be the name of a function'),
        ("x = by 3", 'expected a value, found the word "by"'),
        ("x = 1 + distance to a", '"distance to" needs brackets here'),
        ("ego = new", 'expected a class name after "new", found the end of the line'),
    ],
)
def test_messages_of_scenic_3(program, message):
    with pytest.raises(ScenicError) as caught:
        parse(program, "p.scenic", 3)
    assert caught.value.message == message


def test_tabs_stay_in_the_margin():
    with pytest.raises(ScenicError) as caught:
        parse("if x:\n\ty = = 3\n", "p.scenic")
    assert str(caught.value) == 'p.scenic:2:6: expected a value, found "=" ("==" compares)\n    \ty = = 3\n    \t    ^'
