"""Choose Passing: the defender blocks the bottom teammate."""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

ego = LeftCM at 60 @ 0
top_mate = LeftCF at 88 @ 12
bottom_mate = LeftCF at 88 @ -12

opponent = RightGK at 73 @ 0
defender = RightCB at 86 @ -10

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
