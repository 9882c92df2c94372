"""The numbers of Google Research Football's actions and sticky actions. Read next: actions.scenic."""

class ActionCode:
    """Each action's number; the eight directions are as the player sees the pitch."""

    noop = 0
    idle = 0
    left = 1
    top_left = 2
    top = 3
    top_right = 4
    right = 5
    bottom_right = 6
    bottom = 7
    bottom_left = 8
    long_pass = 9
    high_pass = 10
    short_pass = 11
    shot = 12
    sprint = 13
    release_direction = 14
    release_sprint = 15
    sliding = 16
    dribble = 17
    release_dribble = 18
    builtin_ai = 19

    def sticky_direction(sticky_actions):
        """The direction that stays pressed, 1 to 8, or None; of a player's sticky_actions."""
        for index in range(8):
            if sticky_actions[index] == 1:
                return index + 1
        return None
