"""Gauntlet, held out: the farthest third of the striker's x, and the middle third of each guard's reach."""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 0, -25, 25)
random_course(ego, 10, 20)
