"""Pursuit, held out: the third of the striker's x farthest from the goal, and the fastest third of each pace."""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 2, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

RightCB at between(ego, Range(0.2, 0.35), Range(-10, 10)), with behavior Chase(Range(2 / 3, 1))
RightCB at between(ego, Range(0.4, 0.6), Range(-10, 10)), with behavior Chase(Range(2 / 3, 1))
RightCB at between(ego, Range(0.65, 0.8), Range(-10, 10)), with behavior Chase(Range(2 / 3, 1))

ball = Ball ahead of ego by 2
