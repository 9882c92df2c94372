"""Avoid, pass and shoot, one agent: go around the back, pass if the back comes near, shoot in front of the goal."""

from skills import *

param game_duration = 200
param agents_only = True

behavior Play():
    goal = 80 @ DiscreteRange(8, 12)
    limit = DiscreteRange(75, 77)
    threshold = DiscreteRange(7, 8)
    passed = False
    while True:
        ahead = self.position offset along (angle from self to goal) by 0 @ 0.5
        if not self.owns_ball:
            passed = False
            take MoveTowardsPoint(ball.position, self.position)
        elif self.x > limit and abs(self.y) < 10:
            take MoveTowardsPoint(99 @ -5, self.position)
            take Shoot()
        elif passed:
            take NoAction()
        elif (distance from ahead to back) < threshold and back.x > self.x:
            passed = True
            take Pass("short")
        else:
            take MoveTowardsPoint(goal, self.position)

ego = Ball at 52 @ 0
ball = ego
LeftGK at -98 @ 0, with behavior Play()
LeftAM at 50 @ 0, with behavior Play()
LeftCF at 80 @ -10, with behavior Play()
RightGK at 98 @ 0
back = RightCB at 70 @ -5
