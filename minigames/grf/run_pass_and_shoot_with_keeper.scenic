"""The ball carrier wide and open, a back between the carrier and a teammate near the goal. theta is empty."""

from episode import *

ego = Ball at 70 @ 28

LeftGK at -99 @ 0
LeftCB at 70 @ 0
LeftCB at 70 @ 30

RightGK at 99 @ 0
RightCB at 75 @ 10
