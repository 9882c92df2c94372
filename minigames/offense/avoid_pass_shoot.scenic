"""Avoid, pass and shoot: a back between carrier and goal, a teammate behind the back. theta is empty."""

from episode import *

ego = Ball at 52 @ 0

LeftGK at -98 @ 0
carrier = LeftAM at 50 @ 0
forward = LeftCF at 80 @ -10

RightGK at 98 @ 0
back = RightCB at 70 @ -5
