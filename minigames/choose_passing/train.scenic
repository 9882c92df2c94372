"""Choose Passing: the path to the goal is blocked, one of two teammates is open (thesis, section 4.3).

theta: passer x, y, keeper x, y, defender x, y.
"""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

ego = LeftCM on get_reg_from_edges(58, 62, -3, 3)
top_mate = LeftCF at 88 @ 12
bottom_mate = LeftCF at 88 @ -12

opponent = RightGK on get_reg_from_edges(70, 76, -3, 3)
defender = RightCB on get_reg_from_edges(78, 90, -15, 15)

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
