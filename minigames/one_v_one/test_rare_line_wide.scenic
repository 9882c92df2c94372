"""1v1 Rare Line, a test: the keeper on the goal line, the striker near and at the edge of the training area."""

from places import *

ego = LeftCM at 58 @ 9
RightGK at 99 @ 1.5

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
