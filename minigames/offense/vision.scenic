"""The offside puzzle: two forwards stay level with the defense; one of them can receive a pass.

Sixteen players of both teams crowd beside the path; one distant back decides who is offside. theta: all players' x, y.
"""

from offside import *

forwards = get_reg_from_edges(70, 80, 0, 10)
beside = get_reg_from_edges(20, 65, 30, 40)

LeftGK
passer = LeftPlayer on get_reg_from_edges(10, 15, -5, 5), with role "LM"
LeftPlayer on forwards, with role "CF", with width 1.5, with length 1.5, with behavior StayOnside()
LeftPlayer on forwards, with role "RM", with width 1.5, with length 1.5, with behavior StayOnside()
for role in LEFT_CROWD:
    LeftPlayer on beside, with role role, with width 1.5, with length 1.5

RightGK
RightPlayer on get_reg_from_edges(80, 85, 30, 40), with role "RB"
for role in RIGHT_CROWD:
    RightPlayer on beside, with role role, with width 1.5, with length 1.5

ego = Ball right of passer by 2
