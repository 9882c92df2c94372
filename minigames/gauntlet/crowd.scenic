"""Crowd: a striker must dribble past six guards, who may stand anywhere, and score into an empty goal.

Most random levels leave a free path; levels with all guards side by side are very rare. theta: striker x, y; the reach of
all guards; x, y of each guard.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(-20, 90, -28, 28)
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

ground = get_reg_from_edges(0, 80, -30, 30)
reach = Range(2, 10)
RightCB on ground, with behavior Guard(reach)
RightCB on ground, with behavior Guard(reach)
RightCB on ground, with behavior Guard(reach)
RightCB on ground, with behavior Guard(reach)
RightCB on ground, with behavior Guard(reach)
RightCB on ground, with behavior Guard(reach)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
