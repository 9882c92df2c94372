"""A cross from the other side.

Scenic4RL has no such program: it tests this game on the side buildup's test, to which the published numbers refer.
"""

from attacks import *

param end_episode_on_possession_change = False

LeftGK with behavior HoldPosition()
LeftLB on get_reg_from_edges(-70, -60, -20, -15)
LeftCB on get_reg_from_edges(-70, -65, -10, 10)
LeftRM on get_reg_from_edges(-70, -65, 10, 20)

RightGK
centre = Point on get_reg_from_edges(-80, -70, -5, 5)
near_post = Point on get_reg_from_edges(-90, -85, 5, 10)
wing = Point on get_reg_from_edges(-80, -75, 25, 30)
outer = RightRM on get_reg_from_edges(-55, -50, -20, -15), with behavior ReceiveAndShoot(centre)
middle = RightAM on get_reg_from_edges(-65, -60, -5, 0), with behavior ReceiveAndShoot(near_post)
crosser = RightLM on get_reg_from_edges(-55, -50, 30, 35), with behavior Cross(wing, (middle, outer))

ego = Ball ahead of crosser by 2
