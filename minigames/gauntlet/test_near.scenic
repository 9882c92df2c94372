"""Gauntlet, near: the guards stand in a row before the box, and hardly move."""

from guards import *

ego = LeftCM at 70 @ 10
course(ego, 6)
