"""Shared by the rare games and held-out scenes: the settings of an episode, and positions relative to the path."""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

def beside(start, x, aside):
    """The point at `x` with offset `aside` in y from the straight line from a start to the middle of the goal."""
    return x @ (start.y * (100 - x) / (100 - start.x) + aside)
