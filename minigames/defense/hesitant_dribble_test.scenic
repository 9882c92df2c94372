"""A back right before an attacker somewhere on the inner half, the goal empty. theta: attacker x, y, the gap."""

from attacks import *

LeftGK at 95 @ 40

RightGK at 98 @ 40
attacker = RightAM on left_bottom_half_field
LeftRB left of attacker by Range(5, 10)

ego = Ball ahead of attacker by 2
