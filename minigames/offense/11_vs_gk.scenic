"""Eleven against a keeper: dribble over half the pitch and beat the keeper. theta: keeper x, y."""

from episode import *

ego = Ball at 0 @ 0

LeftGK at -98 @ 0
LeftLB at -60 @ 30
LeftCB at -70 @ 12
LeftCB at -70 @ -12
LeftRB at -60 @ -30
LeftLM at -25 @ 15
LeftCM at -50 @ 10
LeftCM at -50 @ -10
LeftRM at -25 @ -15
LeftAM at -15 @ -2
LeftCF at -2 @ -1

RightGK
