"""Easy crossing: the ball is wide in the box, a teammate stands on the other side, one back between them.

theta: carrier x, y, teammate x, y, back x, y.
"""

from episode import *

ego = Ball at 77 @ -13

LeftGK at -98 @ 0
carrier = LeftAM on get_reg_from_edges(73, 77, -17, -13)
mate = LeftCF on get_reg_from_edges(73, 77, 13, 17)

RightGK at 98 @ 0
back = RightCB on get_reg_from_edges(73, 77, -2, 2)
