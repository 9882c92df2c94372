"""The carrier wide on the other side, a back beside the passing lane. theta: carrier x, y, back x, y."""

from episode import *

LeftGK at -99 @ 0
LeftCB at 70 @ 0
carrier = LeftCB on get_reg_from_edges(65, 70, -35, -25)

RightGK at 99 @ 0
RightCB on get_reg_from_edges(75, 80, -30, -20)

ego = Ball ahead of carrier by 2
