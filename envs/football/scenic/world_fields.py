"""The columns of the tables that programs read: `FIELDS` of every object, then `FACTS` of the match.

Compiled code counts these names and sees nothing else of the language. Read next: `scenic.world`, what they mean.
"""

FIELDS = (
    "x",
    "y",
    "heading",  # where a player looks, where the ball rolls: [0, 2π)
    "vx",  # units per second
    "vy",
    "speed",
    "owns_ball",
    "is_controlled",  # the learner moves him in this step
    "tired_factor",
    "pressed",  # direction key, 1..8 as the player sees the pitch, 0 none
    "sprint",
    "dribble",
    "owned_team",  # of the ball: 0 left, 1 right, -1 nobody's
    "owned_player_idx",  # index within the team, -1 nobody
)
FACTS = ("time", "steps_left", "score_left", "score_right", "game_mode", "done")
