"""3v2: three attackers near the goal, a keeper, and a defender with one of four strategies (thesis, section 4.3).

theta: carrier x, y, left teammate x, y, right teammate x, y, defender x, y, and the selector of the strategy.
"""

from strategies import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

ego = LeftCM on get_reg_from_edges(72, 78, -6, 6)
left_mate = LeftLM on get_reg_from_edges(76, 86, 8, 20)
right_mate = LeftRM on get_reg_from_edges(76, 86, -20, -8)

defender = RightCB on get_reg_from_edges(84, 92, -8, 8), with behavior Defend(Range(0, 1))
RightGK at 99 @ 0

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
