"""A counterattack by two over the wing against two, the goal empty. theta: everybody's x, y, but the keepers'."""

from attacks import *

LeftGK at 95 @ 40, with behavior HoldPosition()
LeftRB
LeftLM on get_reg_from_edges(-1, 5, 30, 35)

RightGK at 98 @ 40, with behavior HoldPosition()
winger = RightRM
RightAM on get_reg_from_edges(-40, -35, -5, 5)

ego = Ball ahead of winger by 2
