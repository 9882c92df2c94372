"""What the rare games and held-out scenes share: the settings of an episode, and places told from the way to the goal."""

model football.model

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

def beside(start, x, aside):
    """The place at this x so far aside of the straight way from a start to the middle of the goal."""
    return x @ (start.y * (100 - x) / (100 - start.x) + aside)
