"""The ball at the edge of the box, no opponent in the way. theta is empty."""

from episode import *

ego = Ball at 77 @ 0

LeftGK at -99 @ 0
LeftCB at 75 @ 0

RightGK at -99 @ -41
