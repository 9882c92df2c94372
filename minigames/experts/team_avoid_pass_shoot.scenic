"""Avoid, pass and shoot, two agents: the carrier draws the back to one side, the forward waits behind the back."""

from skills import *

param game_duration = 200

first = Range(60, 65) @ Range(5, 15)
then = Point on right_goalRegion
wait = Range(80, 88) @ Range(-10, 0)

behavior PassAndWait():
    while True:
        try:
            do MoveToPosition(first, sprint=True)
            do MoveToPosition(then)
        interrupt when self.owns_ball and canShoot(forward, back, right_goal_midpoint, 8, 25):
            do ShortPassTo(forward)
        interrupt when self.owns_ball and canShoot(self, back, right_goal_midpoint, 8, 25):
            do AimGoalCornerAndShoot()

behavior Receive():
    while True:
        try:
            do MoveToPosition(wait)
            if self.x < back.x:
                take MoveTowardsPoint(safeSpot(self, back, right_goal_midpoint, 30 deg), self.position)
            else:
                take ReleaseDirection()
        interrupt when self.owns_ball:
            do AimGoalCornerAndShoot()

ego = Ball at 52 @ 0
LeftGK at -98 @ 0
LeftAM at 50 @ 0, with behavior PassAndWait()
forward = LeftCF at 80 @ -10, with behavior Receive()
RightGK at 98 @ 0
back = RightCB at 70 @ -5
