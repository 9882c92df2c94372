"""Buildup: the ball anywhere from the own half to the penalty spot, two teammates, four defenders and a keeper.

`awake` sets how many of the four defend; the others stand. `-p right_team_difficulty=1` makes them better.
theta: awake; carrier x, y; teammates x, y; defenders x, y.
"""

from defenders import *

awake = Range(0, 5)

ego = LeftCM on get_reg_from_edges(-60, 89, -30, 30)
LeftLM on get_reg_from_edges(-60, 95, 0, 38)
LeftRM on get_reg_from_edges(-60, 95, -38, 0)
LeftGK at -99 @ 0

RightGK at 99 @ 0
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(0, awake)
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(1, awake)
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(2, awake)
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(3, awake)

ball = Ball ahead of ego by 2
