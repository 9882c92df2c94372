"""Buildup, two: from before the box against two defenders."""

from defenders import *

awake = 2

ego = LeftCM at 60 @ 0
LeftLM at 70 @ 18
LeftRM at 70 @ -18
LeftGK at -99 @ 0

RightGK at 99 @ 0
RightCB at 78 @ 5, with behavior Awake(0, awake)
RightCB at 82 @ -6, with behavior Awake(1, awake)
RightCB at 95 @ 19, with behavior Awake(2, awake)
RightCB at 95 @ -19, with behavior Awake(3, awake)

ball = Ball ahead of ego by 2
