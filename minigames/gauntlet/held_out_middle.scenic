"""Gauntlet, held out: the middle third of the striker's x, and of each guard's reach."""

from guards import *

ego = LeftCM on get_reg_from_edges(0, 40, -25, 25)
random_course(ego, 10, 20)
