"""Gauntlet, awake: from the own half, guards who see the ball from afar."""

from guards import *

ego = LeftCM at -20 @ -10
course(ego, 18)
