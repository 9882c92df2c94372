"""Hard crossing from the other wing.

theta: winger x, y, upper and lower teammate x, y, upper, middle and lower back x, y.
"""

from episode import *

LeftGK at -98 @ 0
winger = LeftAM on get_reg_from_edges(78, 82, 33, 37), facing -90 deg
upper_mate = LeftCF on get_reg_from_edges(68, 72, 4, 8)
lower_mate = LeftCF on get_reg_from_edges(68, 72, -8, -4)

RightGK at 98 @ 0
upper_back = RightCB on get_reg_from_edges(68, 72, 10, 14)
middle_back = RightCB on get_reg_from_edges(68, 72, -2, 2)
lower_back = RightCB on get_reg_from_edges(68, 72, -14, -10)

ego = Ball ahead of winger by 2
