"""A back and a static keeper against an attacker who dribbles around opponents.

The attacker reacts at a distance of 15 to 20, as in Scenic4RL, whose program passes its 1 to 5 to another argument.
theta: all players' x, y.
"""

from attacks import *

LeftGK with behavior HoldPosition()
LeftCB

RightGK
attacker = RightCM on LeftReg_CM, with behavior Zigzag(-80 @ 0, 15, 20)

ego = Ball ahead of attacker by 2
