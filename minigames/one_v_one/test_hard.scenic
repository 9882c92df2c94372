"""1v1, the hard test: farther from the goal, the keeper straight ahead."""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

ego = LeftCM at 42 @ 0
opponent = RightGK at 62 @ 0

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
