"""Rare Wall, open: the wall is elsewhere."""

from guards import *

ego = LeftCM at 0 @ 0
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

RightCB at 40 @ 12, with behavior Guard(7)
RightCB at 40 @ 19, with behavior Guard(7)
RightCB at 40 @ 26, with behavior Guard(7)
RightCB at 40 @ 33, with behavior Guard(7)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
