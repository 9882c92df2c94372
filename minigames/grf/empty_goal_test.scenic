"""The ball anywhere in the right half, no opponent in the way. theta: runner x, y."""

from episode import *

LeftGK at -99 @ 0
runner = LeftCB on right_half_field

RightGK at -99 @ -41

ego = Ball ahead of runner by 2
