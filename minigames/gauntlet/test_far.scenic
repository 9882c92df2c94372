"""Gauntlet, far: from the own half, guards with a short reach."""

from guards import *

ego = LeftCM at -20 @ 10
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB at between(ego, 0.27, 3), with behavior Guard(10)
second = RightCB at between(ego, 0.5, -3), with behavior Guard(10)
third = RightCB at between(ego, 0.72, 2), with behavior Guard(10)

ball = Ball ahead of ego by 2
