"""The counterattack of two attackers over the other wing. theta: x, y of all but the keepers."""

from attacks import *

LeftGK at 95 @ 40, with behavior HoldPosition()
LeftRB
LeftLM on get_reg_from_edges(-1, 5, -35, -30)

RightGK at 98 @ 40, with behavior HoldPosition()
winger = RightRM on get_reg_from_edges(16, 20, -22, -18)
RightAM on get_reg_from_edges(-40, -35, -5, 5)

ego = Ball ahead of winger by 2
