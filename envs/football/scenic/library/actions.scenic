"""The actions of a player in one step; an action is its number in Google Research Football.

Directions are 1 left, 2 top left, 3 top, 4 top right, 5 right, 6 bottom right, 7 bottom, 8 bottom left, as the player
sees the pitch: rotated by 180 degrees for the right team, so that 5 leads every player towards the goal that it attacks.

`take SetDirection(5), Sprint(), Shoot()` executes all these actions in one step. Of actions that exclude each other (two
directions, an action and its release, two kicks) the first counts; with BuiltinAIAction() only the built-in AI decides.
In Scenic4RL only the first action of a `take` counts.

Unlike in Scenic4RL, the sectors of `lookup_direction` are 45 degrees wide and centered on the compass points (in
Scenic4RL due west gives top left), an action is its number (it has no `.code`), and `get_closest_player_info` of a player
excludes that player instead of all players at the same position. Read next: behaviors.scenic.
"""

import math

from football.constants import *

def NoAction():
    return 0

def SetDirection(direction):
    """Run in one of the eight directions; it stays active until it is changed or released."""
    return direction

def lookup_direction(dx, dy):
    """The direction nearest to an offset; each takes a sector of 45 degrees."""
    return (round(atan2(dx, dy) / (45 deg)) + 10) % 8 + 1

def MoveTowardsPoint(target, position, rightTeam=False):
    """Run towards a point; for a right player the offset is rotated into the player's view."""
    side = -1 if rightTeam else 1
    return lookup_direction(side * (target.x - position.x), side * (target.y - position.y))

def Pass(pass_type="short"):
    """A pass in the direction of the run."""
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

# Helper functions that Scenic4RL's programs import with the actions.

def player_with_ball(ds, ball, team=None):
    """The player who owns the ball, or None; `team` ("left" or 0, "right" or 1) restricts it to one team.

    ds is simulation().game_ds.
    """
    for player in ds.players:
        if player.owns_ball and team in (None, player.team, 1 if player.team == "right" else 0):
            return player
    return None

def get_closest_player_info(player, players):
    """The closest of some players to a player, who is excluded, and its distance; (None, infinity) without one.

    The player may be a position instead; a player who stands exactly at it is excluded.
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
