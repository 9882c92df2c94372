"""Pass and shoot with a keeper, one agent: pass to the teammate near the goal, or go past the back and shoot."""

from skills import *

param agents_only = True

target = Point on right_goalRegion
plan = Uniform("pass", "shoot")

behavior Carrier():
    if plan == "pass":
        do JustPass()
    else:
        do RunAndShoot()

behavior Mate():
    if plan == "pass":
        do JustShoot()
    else:
        do RunAndShoot()

behavior JustPass():
    passed = False
    while True:
        if passed:
            passed = self.owns_ball
            take SetDirection(5)
        elif self.owns_ball:
            take Pass("short")
            take SetDirection(5)
            passed = True
        else:
            take MoveTowardsPoint(ball.position, self.position)

behavior RunAndShoot():
    try:
        do CloseIn()
    interrupt when (distance from self to right_goal_midpoint) < 8:
        take Shoot()

behavior CloseIn():
    while True:
        if not self.owns_ball:
            take ReleaseDirection()
        elif canShoot(self, back, target, 8, 20):
            take ReleaseDribble()
            take Shoot()
        else:
            take Dribble()
            take MoveTowardsPoint(safeSpot(self, back, target), self.position)

ball = Ball at 70 @ 28
RightGK at 99 @ 0
back = RightCB at 75 @ 30
ego = LeftGK at -99 @ 0, with behavior IdleBehavior()
LeftCF at 70 @ 0, with behavior Mate()
LeftCB at 70 @ 30, with behavior Carrier()
