"""Shared by the buildup programs: the settings of an episode, and defenders of which only some are active."""

from football.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

behavior Awake(number, awake):
    """Defend like the built-in AI if `number` is below `awake`, else stand."""
    if number < awake:
        do BuiltinAIBot()
    else:
        do HoldPosition()
