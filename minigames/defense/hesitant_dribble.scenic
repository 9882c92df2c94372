"""A back against an attacker who is the built-in AI, the goal empty. theta: back x, y, attacker x, y.

The name is Scenic4RL's, where nobody hesitates; the keepers begin far away and run home.
"""

from attacks import *

LeftGK at 95 @ 40
LeftRB

RightGK at 98 @ 40
attacker = RightAM on LeftReg_CM

ego = Ball ahead of attacker by 2
