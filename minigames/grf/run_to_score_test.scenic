"""An empty goal ahead, runner and chasers anywhere across the pitch. theta: x, y of the runner and the chasers."""

from episode import *

behind = get_reg_from_edges(-15, -10, -40, 40)

LeftGK at -98 @ 0
runner = LeftCB on get_reg_from_edges(0, 5, -40, 40)

RightGK at -98 @ -41
RightLB on behind
RightCB on behind
RightCM on behind
RightCB on behind
RightRB on behind

ego = Ball ahead of runner by 2
