"""The carrier wide on the other side and marked, a teammate open near the goal. theta: carrier x, y, the distance."""

from episode import *

LeftGK at -99 @ 0
LeftCB at 70 @ 0
carrier = LeftCB on get_reg_from_edges(65, 70, -35, -25)

RightGK at 99 @ 0
RightCB right of carrier by Range(5, 8)

ego = Ball ahead of carrier by 2
