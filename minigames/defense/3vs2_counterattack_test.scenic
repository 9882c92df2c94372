"""The same counterattack with the winger on the other side. theta: x, y of all but the keepers."""

from attacks import *

LeftGK at 95 @ 40, with behavior HoldPosition()
LeftLB on get_reg_from_edges(-10, 0, 20, 30)
LeftCB on get_reg_from_edges(-70, -60, -10, 10)
LeftRM on get_reg_from_edges(-10, 0, -30, -20)

RightGK at 98 @ 40, with behavior HoldPosition()
carrier = RightCM on get_reg_from_edges(-50, -40, -5, 5)
winger = RightLM on get_reg_from_edges(-60, -50, 20, 30)

ego = Ball ahead of carrier by 2
