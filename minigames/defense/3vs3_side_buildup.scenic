"""An attack from the side, three against three, empty goal. theta: x, y of all but the keepers."""

from attacks import *

LeftGK at 95 @ 40, with behavior HoldPosition()
LeftLB on get_reg_from_edges(-70, -60, 15, 20)
LeftCB on get_reg_from_edges(-70, -65, -10, 10)
LeftRM on get_reg_from_edges(-70, -65, -25, -20)

RightGK at 98 @ 40, with behavior HoldPosition()
RightRM on get_reg_from_edges(-55, -50, 15, 20)
RightAM on get_reg_from_edges(-55, -50, -20, -10)
carrier = RightLM on get_reg_from_edges(-55, -50, -40, -30)

ego = Ball ahead of carrier by 2
