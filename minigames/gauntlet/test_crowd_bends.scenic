"""Crowd, bends: two walls of three, one to the left and one to the right."""

from guards import *

ego = LeftCM at -10 @ 0
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

RightCB at 20 @ -12, with behavior Guard(7)
RightCB at 20 @ -5, with behavior Guard(7)
RightCB at 20 @ 2, with behavior Guard(7)
RightCB at 50 @ 18, with behavior Guard(7)
RightCB at 50 @ 11, with behavior Guard(7)
RightCB at 50 @ 4, with behavior Guard(7)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
