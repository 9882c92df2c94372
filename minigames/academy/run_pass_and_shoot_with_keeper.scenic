"""Academy run, pass and shoot with keeper: the ball carrier wide and open, a teammate in the middle marked."""

from places import *

ego = LeftGK at left(-1.0, 0.0), with regionContainedIn everywhere
LeftCB at left(0.7, 0.0)
LeftCB at left(0.7, -0.3)

RightGK at right(-1.0, 0.0), with regionContainedIn everywhere
RightCB at right(-0.75, 0.1)

Ball at free(0.7, -0.28)
