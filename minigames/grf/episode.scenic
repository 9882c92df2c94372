"""Shared by these games: an episode ends with a goal, a possession change, or the ball out of play."""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
