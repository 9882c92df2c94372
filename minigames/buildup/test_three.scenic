"""Buildup, three: from midfield against three defenders."""

from defenders import *

awake = 3

ego = LeftCM at 0 @ 0
LeftLM at 10 @ 20
LeftRM at 10 @ -20
LeftGK at -99 @ 0

RightGK at 99 @ 0
RightCB at 40 @ 8, with behavior Awake(0, awake)
RightCB at 45 @ -8, with behavior Awake(1, awake)
RightCB at 70 @ 0, with behavior Awake(2, awake)
RightCB at 95 @ -19, with behavior Awake(3, awake)

ball = Ball ahead of ego by 2
