"""What the buildup's programs share: the settings of an episode, and defenders of whom only so many defend."""

from football.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

behavior Awake(number, awake):
    """Defend like the built-in AI if the number is below how many are awake; else stand."""
    if number < awake:
        do BuiltinAIBot()
    else:
        do HoldPosition()
