"""The columns of the tables that programs read: `FIELDS` of every object, then `FACTS` of the match.

Compiled code depends on the number of these names, and on no other part of the language. Read next: `scenic.world`,
their meaning.
"""

FIELDS = (
    "x",
    "y",
    "heading",  # direction of a player's body, or of the ball's velocity: [0, 2π)
    "vx",  # units per second
    "vy",
    "speed",
    "owns_ball",
    "is_controlled",  # whether an agent moves the player in this step
    "tired_factor",
    "pressed",  # direction action, 1..8 as the player sees the pitch, 0 for none
    "sprint",
    "dribble",
    "owned_team",  # of the ball: 0 left, 1 right, -1 none
    "owned_player_idx",  # index within the team, -1 none
)
FACTS = ("time", "steps_left", "score_left", "score_right", "game_mode", "done")
