"""1v1 Free: a striker and a keeper, anywhere in the right half (thesis, Figure 4.1).

Joint spawn area 80 x 50 each, 16,000,000 in all. theta: striker x, y, keeper x, y, own keeper x, y.
"""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

spawn_area = get_reg_from_edges(0, 80, -25, 25)

ego = LeftCM on spawn_area
opponent = RightGK on spawn_area

LeftGK
ball = Ball ahead of ego by 2
