"""Eleven against a keeper, each player anywhere in the region of its role."""

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
