"""Academy pass and shoot with keeper: the ball carrier wide and marked, a teammate open in the middle."""

from places import *

ego = LeftGK at left(-1.0, 0.0), with regionContainedIn everywhere
LeftCB at left(0.7, 0.0)
LeftCB at left(0.7, -0.3)

RightGK at right(-1.0, 0.0), with regionContainedIn everywhere
RightCB at right(-0.75, 0.3)

Ball at free(0.7, -0.28)
