"""Crossing wide: the hard crossing from either wing and any distance, teammates and backs anywhere near the goal.

theta: winger x, y, upper and lower teammate x, y, upper, middle and lower back x, y.
"""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

LeftGK at -98 @ 0
winger = LeftAM on get_reg_from_edges(10, 90, -38, 38)
upper_mate = LeftCF on get_reg_from_edges(50, 92, 0, 20)
lower_mate = LeftCF on get_reg_from_edges(50, 92, -20, 0)

RightGK at 98 @ 0
upper_back = RightCB on get_reg_from_edges(50, 95, 0, 20)
middle_back = RightCB on get_reg_from_edges(50, 95, -8, 8)
lower_back = RightCB on get_reg_from_edges(50, 95, -20, 0)

ego = Ball ahead of winger by 2
