"""The ball anywhere in the box, no opponent in the way. theta: runner x, y."""

from episode import *

LeftGK at -99 @ 0
runner = LeftCB on right_penaltyBox

RightGK at -99 @ -41

ego = Ball ahead of runner by 2
