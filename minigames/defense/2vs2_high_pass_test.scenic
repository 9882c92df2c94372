"""The high pass from the other wing. theta: the destinations of attacker and winger, then all players' x, y."""

from attacks import *

before_the_box = get_reg_from_edges(-80, -75, -5, 5)
goal_of_attacker = Point on get_reg_from_edges(-80, -75, 0, 5)
first = Point on before_the_box
second = Point on before_the_box

LeftGK with behavior HoldPosition()
LeftRB
LeftLM on get_reg_from_edges(-1, 5, -35, -30)

RightGK
attacker = RightAM on get_reg_from_edges(-40, -35, -5, 5), with behavior GoAtGoal(goal_of_attacker)
winger = RightRM on get_reg_from_edges(16, 20, -22, -18),
    with behavior PassHighAndFollow(attacker, first, second)

ego = Ball ahead of winger by 2
