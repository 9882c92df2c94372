"""A keeper alone against an attacker. theta: everybody's x, y."""

from attacks import *

LeftGK

RightGK
attacker = RightAM on LeftReg_CM

ego = Ball ahead of attacker by 2
