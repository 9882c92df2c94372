"""Gauntlet, held out: the nearest third of the striker's x, and the least third of each guard's reach."""

from guards import *

ego = LeftCM on get_reg_from_edges(40, 80, -25, 25)
random_course(ego, 0, 10)
