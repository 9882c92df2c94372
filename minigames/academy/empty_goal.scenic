"""Academy empty goal: the ball in midfield, no opponent in the way; the right keeper is at the other goal."""

from places import *

ego = LeftGK at left(-1.0, 0.0), with regionContainedIn everywhere, with allowCollisions True
LeftCB at left(0.0, 0.0)

RightGK at right(1.0, 0.0), with regionContainedIn everywhere, with allowCollisions True

Ball at free(0.02, 0.0)
