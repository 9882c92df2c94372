"""Pursuit: a striker far from the goal or near it, three defenders on the path who run at the ball, and a keeper.

A defender with pace 0 stands still; the faster defenders run, the wider the striker must go around them, so difficulty
grows in small steps. theta: striker x, y; for each defender share of the way, lateral offset, pace.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 85, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

RightCB at between(ego, Range(0.2, 0.35), Range(-10, 10)), with behavior Chase(Range(0, 1))
RightCB at between(ego, Range(0.4, 0.6), Range(-10, 10)), with behavior Chase(Range(0, 1))
RightCB at between(ego, Range(0.65, 0.8), Range(-10, 10)), with behavior Chase(Range(0, 1))

ball = Ball ahead of ego by 2
