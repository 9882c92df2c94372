"""Academy 3 vs 1 with keeper: three attackers at the edge of the box, one defender, and the keeper."""

from places import *

ego = LeftGK at left(-1.0, 0.0), with regionContainedIn everywhere
LeftCM at left(0.6, 0.0)
LeftCM at left(0.7, 0.2)
LeftCM at left(0.7, -0.2)

RightGK at right(-1.0, 0.0), with regionContainedIn everywhere
RightCB at right(-0.75, 0.0)

Ball at free(0.62, 0.0)
