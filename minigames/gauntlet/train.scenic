"""Gauntlet: a striker far from the goal or near it, three guards on the path, each with its own reach, and a keeper.

A guard with reach 0 stands still; a guard with a long reach must be lured and passed. To score, the striker must pass
all three and the keeper. theta: striker x, y; for each guard share of the way, lateral offset, reach.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 80, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB at between(ego, Range(0.2, 0.35), Range(-6, 6)), with behavior Guard(Range(0, 30))
second = RightCB at between(ego, Range(0.4, 0.6), Range(-6, 6)), with behavior Guard(Range(0, 30))
third = RightCB at between(ego, Range(0.65, 0.8), Range(-6, 6)), with behavior Guard(Range(0, 30))

ball = Ball ahead of ego by 2
