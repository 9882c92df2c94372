"""What both offside puzzles share: the settings, and forwards who wait in line with the last back but one."""

from episode import *

param offsides = True

LEFT_CROWD = ("CB", "LB", "RB", "CB", "CB", "CM", "RM")
RIGHT_CROWD = ("CB", "CB", "LB", "CB", "CM", "CM", "CM", "LM", "CF")

def offsideLine():
    """Where the last opponent but one stands who is still on the pitch."""
    last = sorted([player.x for player in simulation().game_ds.right_players if player.x < 100], reverse=True)
    return last[1]

behavior StayOnside():
    """Keep 2 to 5 before the offside line until the ball comes; then do no more."""
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
