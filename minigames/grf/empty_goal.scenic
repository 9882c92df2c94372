"""The ball in the middle, nobody in the way: the other keeper is parked beside ours. theta is empty."""

from episode import *

ego = Ball at 2 @ 0

LeftGK at -99 @ 0
LeftCB at 0 @ 0

RightGK at -99 @ -41
