"""Easy crossing from the other side: the forward has the ball. theta: all players' x, y."""

from episode import *

LeftGK
mate = LeftAM on get_reg_from_edges(73, 77, -17, -13)
carrier = LeftCF on get_reg_from_edges(73, 77, 13, 17)

RightGK
back = RightCB on get_reg_from_edges(73, 77, -2, 2)

ego = Ball ahead of carrier by 2
