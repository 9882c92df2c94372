"""A back and a keeper who holds his place against an attacker who goes round whoever comes near.

He reacts from 15 to 20 away, as in Scenic4RL, where the 1 to 5 that are written reach another argument. theta: all
x, y.
"""

from attacks import *

LeftGK with behavior HoldPosition()
LeftCB

RightGK
attacker = RightCM on LeftReg_CM, with behavior Zigzag(-80 @ 0, 15, 20)

ego = Ball ahead of attacker by 2
