"""Pursuit, far: from the own half, defenders with pace 0.6."""

from guards import *

ego = LeftCM at -10 @ 10
LeftGK at -99 @ 0
RightGK at 99 @ 0

RightCB at between(ego, 0.27, 3), with behavior Chase(0.6)
RightCB at between(ego, 0.5, -3), with behavior Chase(0.6)
RightCB at between(ego, 0.72, 2), with behavior Chase(0.6)

ball = Ball ahead of ego by 2
