"""Three lines, near: beyond the last line, from where the goal is a shot away."""

from guards import *

ego = LeftCM on get_reg_from_edges(70, 92, -25, 25)
three_lines(ego, 0, 30)
