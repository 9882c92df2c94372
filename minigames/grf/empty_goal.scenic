"""The ball in midfield, no opponent in the way: the right keeper is placed beside the left one. theta is empty."""

from episode import *

ego = Ball at 2 @ 0

LeftGK at -99 @ 0
LeftCB at 0 @ 0

RightGK at -99 @ -41
