"""Avoid, pass and shoot anywhere in the right half: carrier, back and teammate stand in a line of random direction.

Scenic4RL's interpreter samples this direction separately for back and teammate, so its published numbers are for
players that do not stand in a line.
"""

from episode import *

course = Range(-120, -60) deg

LeftGK
carrier = LeftAM on right_half_field
forward = LeftCF at carrier.position offset along course by 0 @ Range(15, 20)

RightGK
back = RightCB at carrier.position offset along course by 0 @ Range(5, 10)

ego = Ball ahead of carrier by 2
