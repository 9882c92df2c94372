"""The zigzag attacker anywhere in the inner half, the back directly in front; the attacker reacts at 1 to 5."""

from attacks import *

LeftGK with behavior HoldPosition()

RightGK
attacker = RightCM on left_bottom_half_field, with behavior Zigzag(-80 @ 0, 1, 5)
LeftCB left of attacker by Range(5, 10)

ego = Ball ahead of attacker by 2
