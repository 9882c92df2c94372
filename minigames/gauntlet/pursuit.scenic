"""Pursuit: a striker far from goal or near it, three defenders on his way who run at the ball, and a keeper.

A defender of no pace is a post; the faster they run, the wider the striker must go around them, from the slowest up in
small steps. theta: striker x, y; of each defender share of the way, place aside, pace.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 85, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

RightCB at between(ego, Range(0.2, 0.35), Range(-10, 10)), with behavior Chase(Range(0, 1))
RightCB at between(ego, Range(0.4, 0.6), Range(-10, 10)), with behavior Chase(Range(0, 1))
RightCB at between(ego, Range(0.65, 0.8), Range(-10, 10)), with behavior Chase(Range(0, 1))

ball = Ball ahead of ego by 2
