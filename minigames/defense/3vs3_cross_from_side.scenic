"""A cross from the side (thesis, Figure 2.1): a winger crosses to one of two attackers in front of the goal.

Three players and a keeper defend. An episode does not end at a possession change. theta: all players' x, y, and the
destinations of the three attackers.
"""

from attacks import *

param end_episode_on_possession_change = False

LeftGK with behavior HoldPosition()
LeftLB on get_reg_from_edges(-70, -60, 15, 20)
LeftCB on get_reg_from_edges(-70, -65, -10, 10)
LeftRM on get_reg_from_edges(-70, -65, -20, -10)

RightGK
centre = Point on get_reg_from_edges(-80, -70, -5, 5)
near_post = Point on get_reg_from_edges(-90, -85, -10, -5)
wing = Point on get_reg_from_edges(-80, -75, -30, -25)
outer = RightRM on get_reg_from_edges(-55, -50, 15, 20), with behavior ReceiveAndShoot(centre)
middle = RightAM on get_reg_from_edges(-65, -60, 0, 5), with behavior ReceiveAndShoot(near_post)
crosser = RightLM on get_reg_from_edges(-55, -50, -35, -30), with behavior Cross(wing, (middle, outer))

ego = Ball ahead of crosser by 2
