"""What the academy's programs share: the settings of an episode, and places as Google Research Football's scenarios
give them: x from -1, one's own goal line, to 1, y downwards; a right player's is in his team's own frame.

The engine spreads players a little, but not the ball: so do `left` and `right`, hence keepers stand behind the line.
With `-p jitter=1` everybody stands up to one unit off, drawn anew for every level: these draws are theta, which is empty
without. An episode has one step more than the `game_duration` of the original's file, as it has there.
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
    """The ball's place, which is nobody's."""
    return (100 * x) @ (-100 * y)

def near(x, y):
    jitter = globalParameters.jitter
    if jitter > 0:
        return Range(x - jitter, x + jitter) @ Range(y - jitter, y + jitter)
    return x @ y
