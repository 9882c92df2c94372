"""Two backs in their box against two attackers close together anywhere in that half. One sample in 27 is valid."""

from attacks import *

LeftGK at 90 @ 40, with behavior HoldPosition()
back = LeftCB in left_penaltyBox
other_back = LeftCB in left_penaltyBox

RightGK at 95 @ 40, with behavior HoldPosition()
carrier = RightCM in left_half_field
mate = RightAM in left_half_field

require (distance from back to other_back) > 3
require (distance from carrier to mate) < 10

ego = Ball ahead of carrier by 2
