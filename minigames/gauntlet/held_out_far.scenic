"""Gauntlet, held out: the third of the striker's x farthest from the goal, and the middle third of each reach."""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 0, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB at between(ego, Range(0.2, 0.35), Range(-6, 6)), with behavior Guard(Range(10, 20))
second = RightCB at between(ego, Range(0.4, 0.6), Range(-6, 6)), with behavior Guard(Range(10, 20))
third = RightCB at between(ego, Range(0.65, 0.8), Range(-6, 6)), with behavior Guard(Range(10, 20))

ball = Ball ahead of ego by 2
