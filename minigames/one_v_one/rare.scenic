"""1v1 Rare: a striker, and a keeper far from the striker's path; in about one level of fifty the keeper blocks it.

theta: the keeper's offset from the path, one range for the path itself and one for each side, and the choice among
them; striker x, y; keeper x.
"""

from places import *

aside = Discrete({Range(-2, 2): 1, Range(-25, -6): 25, Range(6, 25): 25})

ego = LeftCM on get_reg_from_edges(40, 60, -10, 10)
RightGK at beside(ego, Range(60, 80), aside)

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
