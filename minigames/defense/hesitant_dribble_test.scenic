"""A back directly in front of an attacker in the inner half, empty goal. theta: attacker x, y, their distance."""

from attacks import *

LeftGK at 95 @ 40

RightGK at 98 @ 40
attacker = RightAM on left_bottom_half_field
LeftRB left of attacker by Range(5, 10)

ego = Ball ahead of attacker by 2
