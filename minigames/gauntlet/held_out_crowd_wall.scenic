"""Crowd, held out: six guards side by side, anywhere."""

from guards import *

ego = LeftCM on get_reg_from_edges(-20, 0, -15, 15)
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

wall = Range(20, 60) @ Range(-12, 12)
def besides(place, on, aside):
    return (place.x + on) @ (place.y + aside)

RightCB at besides(wall, 0, -17.5), with behavior Guard(7)
RightCB at besides(wall, 0, -10.5), with behavior Guard(7)
RightCB at besides(wall, 0, -3.5), with behavior Guard(7)
RightCB at besides(wall, 0, 3.5), with behavior Guard(7)
RightCB at besides(wall, 0, 10.5), with behavior Guard(7)
RightCB at besides(wall, 0, 17.5), with behavior Guard(7)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
