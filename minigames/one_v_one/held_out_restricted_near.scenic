"""1v1 Restricted, held out: the keeper close to the striker's path."""

from places import *

ego = LeftCM on get_reg_from_edges(40, 60, -10, 10)
RightGK at beside(ego, Range(60, 80), Uniform(-1, 1) * Range(2, 6))

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
