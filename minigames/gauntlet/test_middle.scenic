"""Gauntlet, middle: from the opponents' half, guards who wake late."""

from guards import *

ego = LeftCM at 30 @ -10
course(ego, 8)
