"""Gauntlet, near: the guards stand in a row in front of the box and hardly move."""

from guards import *

ego = LeftCM at 70 @ 10
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB at between(ego, 0.27, 3), with behavior Guard(6)
second = RightCB at between(ego, 0.5, -3), with behavior Guard(6)
third = RightCB at between(ego, 0.72, 2), with behavior Guard(6)

ball = Ball ahead of ego by 2
