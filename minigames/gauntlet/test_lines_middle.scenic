"""Three lines, middle: two guards ahead, who see the ball from afar."""

from guards import *

ego = LeftCM on get_reg_from_edges(30, 60, -20, 20)
three_lines(ego, 10, 30)
