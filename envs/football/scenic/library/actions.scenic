"""What a player can do in one step; an action is the number that Google Research Football gives it.

Directions are 1 left, 2 top left, 3 top, 4 top right, 5 right, 6 bottom right, 7 bottom, 8 bottom left, as the player
sees the pitch: the right team sees it turned by half a turn, so that 5 leads every player towards the goal that he attacks.

`take SetDirection(5), Sprint(), Shoot()` presses all these keys in one step. Of actions that exclude each other (two
directions, a key and its release, two kicks) the first counts; with BuiltinAIAction() the built-in AI alone decides.
In Scenic4RL the first action of a `take` alone counts.

Unlike in Scenic4RL the sectors of `lookup_direction` are 45 degrees wide and centred on the compass points (there due
west gave top left), an action is its number (it has no `.code`), and `get_closest_player_info` of a player leaves out
himself and not whoever stands exactly where he does. Read next: behaviors.scenic.
"""

import math

from football.constants import *

def NoAction():
    return 0

def SetDirection(direction):
    """Run in one of the eight directions until told otherwise."""
    return direction

def lookup_direction(dx, dy):
    """The direction nearest to an offset; each takes a sector of 45 degrees."""
    return (round(atan2(dx, dy) / (45 deg)) + 10) % 8 + 1

def MoveTowardsPoint(target, position, rightTeam=False):
    """Run towards a point; for a right player the offset is turned into his view."""
    side = -1 if rightTeam else 1
    return lookup_direction(side * (target.x - position.x), side * (target.y - position.y))

def Pass(pass_type="short"):
    """The kick goes the way the player runs."""
    return {"long": 9, "high": 10, "short": 11}[pass_type]

def Shoot():
    return 12

def Sprint():
    return 13

def ReleaseDirection():
    return 14

def ReleaseSprint():
    return 15

def Slide():
    return 16

def Dribble():
    return 17

def ReleaseDribble():
    return 18

def BuiltinAIAction():
    return 19

# Helpers that Scenic4RL's programs find beside the actions.

def player_with_ball(ds, ball, team=None):
    """The player who owns the ball, of one team ("left" or 0, "right" or 1) if it is given, or None.

    ds is simulation().game_ds.
    """
    for player in ds.players:
        if player.owns_ball and team in (None, player.team, 1 if player.team == "right" else 0):
            return player
    return None

def get_closest_player_info(player, players):
    """Who of some players is closest to this one (himself aside), and how far away: (None, infinity) if nobody is.

    In place of the player it may be a position; whoever stands exactly there is left out.
    """
    closest = None
    shortest = math.inf
    for other in players:
        if other is not player:
            gap = distance from player to other
            if gap < shortest and not (isinstance(player, Vector) and gap == 0):
                shortest = gap
                closest = other
    return closest, shortest
