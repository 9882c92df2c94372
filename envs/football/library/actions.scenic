"""What a player can do in one step; an action is the number that Google Research Football gives it.

Directions are 1 left, 2 top left, 3 top, 4 top right, 5 right, 6 bottom right, 7 bottom, 8 bottom left, as the player
sees the pitch: the right team sees it turned by half a turn.
"""

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
