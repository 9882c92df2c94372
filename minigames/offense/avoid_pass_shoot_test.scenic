"""Avoid, pass and shoot anywhere on the right half: carrier, back and mate stand in one line, turned by a drawn course.

Scenic4RL's interpreter draws the course anew for back and mate: its published numbers are of players in no such line.
"""

from episode import *

course = Range(-120, -60) deg

LeftGK
carrier = LeftAM on right_half_field
forward = LeftCF at carrier.position offset along course by 0 @ Range(15, 20)

RightGK
back = RightCB at carrier.position offset along course by 0 @ Range(5, 10)

ego = Ball ahead of carrier by 2
