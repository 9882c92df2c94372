"""1v1 Rare Line, a test: the keeper has come out, well aside of the striker's way."""

from places import *

ego = LeftCM at 44 @ -6
RightGK at 70 @ 14

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
