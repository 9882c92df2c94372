"""The keeper ahead, five chasers behind. theta is empty."""

from episode import *

ego = Ball at 2 @ 0

LeftGK at -99 @ 0
LeftCB at 0 @ 0

RightGK at 99 @ 0
RightLB at -12 @ -20
RightCB at -12 @ -10
RightCM at -12 @ 0
RightCB at -12 @ 10
RightRB at -12 @ 20
