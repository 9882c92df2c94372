"""Crowd, held out: a wedge that is open to the striker, anywhere."""

from guards import *

ego = LeftCM on get_reg_from_edges(-20, 0, -15, 15)
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

wall = Range(20, 60) @ Range(-12, 12)
def besides(place, on, aside):
    return (place.x + on) @ (place.y + aside)

RightCB at besides(wall, -10, -16), with behavior Guard(7)
RightCB at besides(wall, 0, -9), with behavior Guard(7)
RightCB at besides(wall, 10, -3), with behavior Guard(7)
RightCB at besides(wall, 10, 3), with behavior Guard(7)
RightCB at besides(wall, 0, 9), with behavior Guard(7)
RightCB at besides(wall, -10, 16), with behavior Guard(7)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
