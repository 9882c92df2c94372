"""Rare Wall, trap: a wedge that is open to the striker."""

from guards import *

ego = LeftCM at 0 @ 0
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

RightCB at 35 @ -10, with behavior Guard(7)
RightCB at 42 @ -3.5, with behavior Guard(7)
RightCB at 42 @ 3.5, with behavior Guard(7)
RightCB at 35 @ 10, with behavior Guard(7)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
