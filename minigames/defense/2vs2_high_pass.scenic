"""A high pass from the wing to an attacker in front of the box, two against two and a static keeper.

theta: the destinations of attacker and winger, then all players' x, y.
"""

from attacks import *

before_the_box = get_reg_from_edges(-80, -75, -5, 5)
goal_of_attacker = Point on get_reg_from_edges(-80, -75, 0, 5)
first = Point on before_the_box
second = Point on before_the_box

LeftGK with behavior HoldPosition()
LeftRB
LeftLM on get_reg_from_edges(-1, 5, 30, 35)

RightGK
attacker = RightAM on get_reg_from_edges(-40, -35, -5, 5), with behavior GoAtGoal(goal_of_attacker)
winger = RightRM with behavior PassHighAndFollow(attacker, first, second)

ego = Ball ahead of winger by 2
