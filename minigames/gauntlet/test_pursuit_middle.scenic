"""Pursuit, middle: from the opponents' half, defenders with pace 0.4."""

from guards import *

ego = LeftCM at 30 @ -10
LeftGK at -99 @ 0
RightGK at 99 @ 0

RightCB at between(ego, 0.27, 3), with behavior Chase(0.4)
RightCB at between(ego, 0.5, -3), with behavior Chase(0.4)
RightCB at between(ego, 0.72, 2), with behavior Chase(0.4)

ball = Ball ahead of ego by 2
