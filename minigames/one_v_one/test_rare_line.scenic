"""1v1 Rare Line, a test: the keeper on the goal line."""

from places import *

ego = LeftCM at 50 @ 0
RightGK at 99 @ 0

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
