"""A keeper alone against an attacker. theta: all players' x, y."""

from attacks import *

LeftGK

RightGK
attacker = RightAM on LeftReg_CM

ego = Ball ahead of attacker by 2
