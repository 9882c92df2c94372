"""Academy run to score with keeper: the keeper is ahead, five opponents are behind."""

from places import *

ego = LeftGK at left(-1.0, 0.0), with regionContainedIn everywhere
LeftCB at left(0.0, 0.0)

RightGK at right(-1.0, 0.0), with regionContainedIn everywhere
RightLB at right(0.12, 0.2)
RightCB at right(0.12, 0.1)
RightCM at right(0.12, 0.0)
RightCB at right(0.12, -0.1)
RightRB at right(0.12, -0.2)

Ball at free(0.02, 0.0)
