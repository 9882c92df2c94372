"""Academy counterattack, easy: five attackers ahead of most of eleven opponents, two of which share a position."""

from places import *

ego = LeftGK at left(-1.0, 0.0), with regionContainedIn everywhere
LeftLB at left(-0.672, -0.19576)
LeftCB at left(-0.75, -0.06356)
LeftCB at left(-0.75, 0.063559)
LeftRB at left(-0.672, 0.19576)
LeftCM at left(-0.434, -0.10568)
LeftCM at left(-0.434, 0.10568)
LeftCM at left(0.5, -0.3161)
LeftLM at left(0.25, -0.1)
LeftRM at left(0.25, 0.1)
LeftCF at left(0.35, 0.316102)

RightGK at right(-1.0, 0.0), with regionContainedIn everywhere
RightLB at right(0.128, -0.19576), with allowCollisions True
RightCB at right(0.4, -0.06356)
RightCB at right(-0.4, 0.063559)
RightRB at right(0.128, -0.19576), with allowCollisions True
RightCM at right(0.365, -0.10568)
RightCM at right(0.282, 0.0)
RightCM at right(0.365, 0.10568)
RightLM at right(0.54, -0.3161)
RightRM at right(0.51, 0.0)
RightCF at right(0.54, 0.316102)

Ball at free(0.26, -0.11)
