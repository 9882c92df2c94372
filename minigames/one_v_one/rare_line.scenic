"""1v1 Rare Line: a keeper off the line, far from the striker's path; in one level of fifty the keeper is on the line.

theta: striker x, y; for a keeper off the line x, offset, side; for a keeper on the line y; which of the two.
"""

from places import *

ego = LeftCM on get_reg_from_edges(40, 60, -10, 10)
aside = Discrete({Range(-25, -6): 1, Range(6, 25): 1})
RightGK at Discrete({beside(ego, Range(60, 80), aside): 50, 99 @ Range(-2, 2): 1})

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
