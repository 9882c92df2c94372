"""1v1 Rare Line: a keeper who has come out, well aside of the striker's way; in one level of fifty he is on his line.

theta: striker x, y; of the keeper who is out x, how far aside, to which side; his place on the line; where he is.
"""

from places import *

ego = LeftCM on get_reg_from_edges(40, 60, -10, 10)
aside = Discrete({Range(-25, -6): 1, Range(6, 25): 1})
RightGK at Discrete({beside(ego, Range(60, 80), aside): 50, 99 @ Range(-2, 2): 1})

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
