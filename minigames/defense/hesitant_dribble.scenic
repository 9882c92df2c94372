"""A back against a built-in attacker, empty goal. theta: back x, y, attacker x, y.

The name is Scenic4RL's; its attacker does not hesitate either. The keepers start far away and run back.
"""

from attacks import *

LeftGK at 95 @ 40
LeftRB

RightGK at 98 @ 40
attacker = RightAM on LeftReg_CM

ego = Ball ahead of attacker by 2
