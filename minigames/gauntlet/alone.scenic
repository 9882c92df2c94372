"""Alone: a striker and the keeper, three defenders far behind the ball; a first lesson for Pursuit and Gauntlet.

theta: striker x, y; for each defender y, pace.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(40, 85, -20, 20)
LeftGK at -99 @ 0
RightGK at 99 @ 0

RightCB at -60 @ Range(-30, -20), with behavior Chase(Range(0, 1))
RightCB at -60 @ Range(-5, 5), with behavior Chase(Range(0, 1))
RightCB at -60 @ Range(20, 30), with behavior Chase(Range(0, 1))

ball = Ball ahead of ego by 2
