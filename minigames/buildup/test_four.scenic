"""Buildup, four: from the own half against four defenders."""

from defenders import *

awake = 4

ego = LeftCM at -40 @ 10
LeftLM at -20 @ 25
LeftRM at -20 @ -20
LeftGK at -99 @ 0

RightGK at 99 @ 0
RightCB at 20 @ 8, with behavior Awake(0, awake)
RightCB at 30 @ -8, with behavior Awake(1, awake)
RightCB at 60 @ 10, with behavior Awake(2, awake)
RightCB at 70 @ -10, with behavior Awake(3, awake)

ball = Ball ahead of ego by 2
