"""Gauntlet: a striker far from goal or near it, three guards on his way, each with a reach of his own, and a keeper.

A guard of no reach is a post to run past, one of a long reach must be lured and passed; all three, and the keeper, must
be passed for a goal. theta: striker x, y; of each guard share of the way, place aside, reach.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 80, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB at between(ego, Range(0.2, 0.35), Range(-6, 6)), with behavior Guard(Range(0, 30))
second = RightCB at between(ego, Range(0.4, 0.6), Range(-6, 6)), with behavior Guard(Range(0, 30))
third = RightCB at between(ego, Range(0.65, 0.8), Range(-6, 6)), with behavior Guard(Range(0, 30))

ball = Ball ahead of ego by 2
