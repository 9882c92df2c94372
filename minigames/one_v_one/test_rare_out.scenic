"""1v1 Rare Line, a test: the keeper off the line, far from the striker's path."""

from places import *

ego = LeftCM at 44 @ -6
RightGK at 70 @ 14

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
