"""Buildup, held out: the carrier's middle third of x, and of `awake`."""

from defenders import *

awake = Range(1.67, 3.33)

ego = LeftCM on get_reg_from_edges(-10, 40, -30, 30)
LeftLM on get_reg_from_edges(-60, 95, 0, 38)
LeftRM on get_reg_from_edges(-60, 95, -38, 0)
LeftGK at -99 @ 0

RightGK at 99 @ 0
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(0, awake)
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(1, awake)
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(2, awake)
RightCB on get_reg_from_edges(0, 95, -20, 20), with behavior Awake(3, awake)

ball = Ball ahead of ego by 2
