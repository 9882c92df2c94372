"""Three lines: a striker anywhere from the own half to the goal, a guard in each of three lines across the pitch.

A striker who starts nearer to the goal must pass fewer guards. theta: striker x, y; for each guard x, y, reach.
"""

from guards import *

ego = LeftCM on get_reg_from_edges(-40, 92, -25, 25)
LeftGK at -99 @ 0
RightGK at 99 @ 0

first = RightCB on get_reg_from_edges(10, 30, -15, 15), with behavior Guard(Range(0, 30))
second = RightCB on get_reg_from_edges(40, 60, -15, 15), with behavior Guard(Range(0, 30))
third = RightCB on get_reg_from_edges(65, 85, -15, 15), with behavior Guard(Range(0, 30))

ball = Ball ahead of ego by 2
