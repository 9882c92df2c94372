"""3v2, strategy B: the defender marks the owner of the ball."""

from strategies import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

ego = LeftCM at 74 @ 0
left_mate = LeftLM at 81 @ 14
right_mate = LeftRM at 81 @ -14

defender = RightCB at 88 @ 0, with behavior Defend(0.375)
RightGK at 99 @ 0

LeftGK at -99 @ 0
ball = Ball ahead of ego by 2
