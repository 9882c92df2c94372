"""What a player can do in one step: each action is the number that Google Research Football gives it.

Directions count from 1 (left) clockwise to 8 (bottom left), as the player sees the pitch.
"""



def NoAction():
    return 0

def SetDirection(direction):
    return direction

def Pass(pass_type="short"):
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
