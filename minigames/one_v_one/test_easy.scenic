"""1v1, the easy test: an open goal, the keeper far to the side."""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

ego = LeftCM at 57 @ 8
opponent = RightGK at 70 @ -20

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
