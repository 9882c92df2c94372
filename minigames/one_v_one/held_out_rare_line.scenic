"""1v1 Rare Line, held out: the keeper on the goal line."""

from places import *

ego = LeftCM on get_reg_from_edges(40, 60, -10, 10)
RightGK at 99 @ Range(-2, 2)

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
