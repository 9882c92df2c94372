"""A counterattack of two attackers against one back and two teammates who run back, empty goal.

theta: x, y of all but the keepers, who are placed far away.
"""

from attacks import *

LeftGK at 95 @ 40, with behavior HoldPosition()
LeftLB on get_reg_from_edges(-10, 0, 20, 30)
LeftCB on get_reg_from_edges(-70, -60, -10, 10)
LeftRM on get_reg_from_edges(-10, 0, -30, -20)

RightGK at 98 @ 40, with behavior HoldPosition()
carrier = RightCM on get_reg_from_edges(-50, -40, -5, 5)
winger = RightLM on get_reg_from_edges(-60, -50, -30, -20)

ego = Ball ahead of carrier by 2
