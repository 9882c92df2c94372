"""Three lines, far: from the own half, three guards ahead, who see the ball from afar."""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 0, -20, 20)
three_lines(ego, 10, 30)
