"""Two backs against two attackers in front of an empty goal: both keepers are placed far away.

theta: both backs x, y, carrier x, y, teammate x, y.
"""

from attacks import *

LeftGK at 90 @ 40, with behavior HoldPosition()
back = LeftCB
other_back = LeftCB

RightGK at 95 @ 40, with behavior HoldPosition()
carrier = RightCM on LeftReg_CM
mate = RightAM on LeftReg_CM

require (distance from back to other_back) > 3
require (distance from carrier to mate) > 4

ego = Ball ahead of carrier by 2
