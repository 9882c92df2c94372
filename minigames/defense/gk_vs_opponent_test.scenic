"""A keeper alone against an attacker anywhere in the keeper's half."""

from attacks import *

LeftGK

RightGK
attacker = RightAM on left_half_field

ego = Ball ahead of attacker by 2
