"""Three attackers in front of the box against a back and the keeper. theta is empty."""

from episode import *

ego = Ball at 62 @ 0

LeftGK at -99 @ 0
LeftCM at 60 @ 0
LeftCM at 70 @ 20
LeftCM at 70 @ -20

RightGK at 99 @ 0
RightCB at 75 @ 0
