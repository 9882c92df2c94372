"""Shared by both offside puzzles: the settings, and forwards who wait level with the second-last opponent."""

from episode import *

param offsides = True

LEFT_CROWD = ("CB", "LB", "RB", "CB", "CB", "CM", "RM")
RIGHT_CROWD = ("CB", "CB", "LB", "CB", "CM", "CM", "CM", "LM", "CF")

def offsideLine():
    """The x of the second-last opponent on the pitch."""
    last = sorted([player.x for player in simulation().game_ds.right_players if player.x < 100], reverse=True)
    return last[1]

behavior StayOnside():
    """Stay 2 to 5 in front of the offside line until the ball arrives; then stand."""
    while True:
        if self.owns_ball:
            do IdleBehavior()
        line = offsideLine()
        if self.x >= line - 2:
            take SetDirection(1)
        elif self.x < line - 5:
            take SetDirection(5)
        else:
            take ReleaseDirection()
