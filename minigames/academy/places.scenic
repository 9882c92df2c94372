"""Shared by the academy's programs: the settings of an episode, and positions in Google Research Football's units: x
from -1, the own goal line, to 1, and y downwards; positions of right players are in their own team's frame.

GRF scales the positions of players, but not of the ball; `left` and `right` do the same, so keepers stand behind the
line. With `-p jitter=1` each player is displaced by up to one unit in each level, and theta has these displacements;
otherwise theta is empty. As in GRF, an episode has one step more than the `game_duration` of GRF's scenario file.
"""

model football.model

param jitter = 0
param game_duration = 401
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

def left(x, y):
    return near(100 * x * 55 / 54.4, -100 * y * 84.96 / 83.6)

def right(x, y):
    return near(-100 * x * 55 / 54.4, 100 * y * 84.96 / 83.6)

def free(x, y):
    """The ball's position."""
    return (100 * x) @ (-100 * y)

def near(x, y):
    jitter = globalParameters.jitter
    if jitter > 0:
        return Range(x - jitter, x + jitter) @ Range(y - jitter, y + jitter)
    return x @ y
