"""A counterattack of two attackers over the wing against two, empty goal. theta: x, y of all but the keepers."""

from attacks import *

LeftGK at 95 @ 40, with behavior HoldPosition()
LeftRB
LeftLM on get_reg_from_edges(-1, 5, 30, 35)

RightGK at 98 @ 40, with behavior HoldPosition()
winger = RightRM
RightAM on get_reg_from_edges(-40, -35, -5, 5)

ego = Ball ahead of winger by 2
