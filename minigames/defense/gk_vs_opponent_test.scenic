"""A keeper alone against an attacker from anywhere on his half."""

from attacks import *

LeftGK

RightGK
attacker = RightAM on left_half_field

ego = Ball ahead of attacker by 2
