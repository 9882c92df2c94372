"""Eleven against a keeper, everybody somewhere in the region of his role."""

from episode import *

ego = Ball at 0 @ 0

LeftGK
LeftLB
LeftCB
LeftCB
LeftRB
LeftLM
LeftCM
LeftCM
LeftRM
LeftAM
LeftCF

RightGK
