"""Three lines, near: beyond the last line, within shooting distance of the goal."""

from guards import *

ego = LeftCM on get_reg_from_edges(70, 92, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB on get_reg_from_edges(10, 30, -15, 15), with behavior Guard(Range(0, 30))
second = RightCB on get_reg_from_edges(40, 60, -15, 15), with behavior Guard(Range(0, 30))
third = RightCB on get_reg_from_edges(65, 85, -15, 15), with behavior Guard(Range(0, 30))

ball = Ball ahead of ego by 2
