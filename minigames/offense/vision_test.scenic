"""The offside puzzle, mirrored. theta: all players' x, y."""

from offside import *

forwards = get_reg_from_edges(70, 80, -10, 0)
beside = get_reg_from_edges(20, 65, -40, -30)

LeftGK
passer = LeftPlayer on get_reg_from_edges(10, 15, -5, 5), with role "RM"
LeftPlayer on forwards, with role "CF", with width 1.5, with length 1.5, with behavior StayOnside()
LeftPlayer on forwards, with role "LM", with width 1.5, with length 1.5, with behavior StayOnside()
for role in LEFT_CROWD:
    LeftPlayer on beside, with role role, with width 1.5, with length 1.5

RightGK
RightPlayer on get_reg_from_edges(80, 85, -40, -30), with role "LB"
for role in RIGHT_CROWD:
    RightPlayer on beside, with role role, with width 1.5, with length 1.5

ego = Ball right of passer by 2
