"""Shared by the offense games: an episode ends with a goal, a possession change, or the ball out of play."""

from football.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
