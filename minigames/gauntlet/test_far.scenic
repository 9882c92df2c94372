"""Gauntlet, far: from the own half, guards who wake late."""

from guards import *

ego = LeftCM at -20 @ 10
course(ego, 10)
