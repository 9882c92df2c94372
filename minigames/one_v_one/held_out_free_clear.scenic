"""1v1 Free, held out: the keeper far from the striker's path."""

from places import *

ego = LeftCM on get_reg_from_edges(0, 60, -15, 15)
RightGK at beside(ego, ego.x + Range(0.2, 0.5) * (100 - ego.x), Uniform(-1, 1) * Range(6, 13))

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
