"""Rare Wall, held out: the wall across the striker's way."""

from guards import *

aside = Range(-4, 4)
bend = Range(-8, 8)
reach = Range(4, 8)

ego = LeftCM on get_reg_from_edges(-10, 80, -8, 8)
LeftGK at -99 @ 0
RightGK at 99 @ 40, with behavior Guard(0)

wall = between(ego, Range(0.35, 0.6), aside)
def besides(place, on, aside):
    return (place.x + on) @ (place.y + aside)

RightCB at besides(wall, -bend, -10.5), with behavior Guard(reach)
RightCB at besides(wall, 0, -3.5), with behavior Guard(reach)
RightCB at besides(wall, 0, 3.5), with behavior Guard(reach)
RightCB at besides(wall, -bend, 10.5), with behavior Guard(reach)

ball = Ball ahead of ego by 2

terminate when (distance from ball to ego) > 10 and ball.position.x < 70
