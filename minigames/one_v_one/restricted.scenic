"""1v1 Restricted: a striker in front of the goal, with the keeper in between (thesis, section 4.3).

Joint spawn area 400 x 1,000 = 400,000. theta: striker x, y, keeper x, y, own keeper x, y.
"""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

striker_area = get_reg_from_edges(40, 60, -10, 10)
keeper_area = get_reg_from_edges(60, 80, -25, 25)

ego = LeftCM on striker_area
opponent = RightGK on keeper_area

LeftGK
ball = Ball ahead of ego by 2
