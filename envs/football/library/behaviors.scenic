"""Behaviors that need nothing but the player's own position and that of what he runs to or passes to.

Every `take` is one step of 0.1 s. Programs that import this also get the model and the actions. Read next:
actions.scenic.
"""

from football.model import *
from football.actions import *

behavior IdleBehavior():
    while True:
        take NoAction()

behavior HoldPosition():
    while True:
        take ReleaseSprint()
        take ReleaseDirection()

behavior BuiltinAIBot():
    while True:
        take BuiltinAIAction()

behavior RunRight():
    while True:
        take SetDirection(5)

behavior MoveToPosition(dest_point, reaction_dist=2, sprint=False):
    """Run to where the destination is now; with sprint the arrival is noticed from 10 away."""
    x = dest_point.x
    y = dest_point.y
    arrival = 10 if sprint else reaction_dist
    while (distance from self to (x @ y)) > arrival:
        take MoveTowardsPoint(x @ y, self.position, self.team == "right")
        if sprint:
            take Sprint()
    if sprint:
        take ReleaseSprint()
    take ReleaseDirection()

behavior FollowObject(object_to_follow, terminate_distance=1, sprint=False):
    """Run to where the object is at each step."""
    while (distance from self to object_to_follow) > terminate_distance:
        take MoveTowardsPoint(object_to_follow.position, self.position, self.team == "right")
        if sprint:
            take Sprint()
    if sprint:
        take ReleaseSprint()
    take ReleaseDirection()

behavior ShortPassTo(player):
    take MoveTowardsPoint(player.position, self.position, self.team == "right")
    take Pass("short")
    take ReleaseSprint()
    take ReleaseDirection()

behavior HighPassTo(player):
    take MoveTowardsPoint(player.position, self.position, self.team == "right")
    take Pass("high")
    take ReleaseSprint()
    take ReleaseDirection()

behavior LongPassTo(player):
    take MoveTowardsPoint(player.position, self.position, self.team == "right")
    take Pass("long")
    take ReleaseSprint()
    take ReleaseDirection()
