"""Pass and shoot with a keeper, two agents: pass to the teammate near the goal, or go past the back and shoot."""

from skills import *

target = Point on right_goalRegion
wait = Range(68, 72) @ Range(-5, 0)
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
        do Receive()

behavior JustPass():
    while True:
        try:
            do MoveToPosition(target)
        interrupt when self.owns_ball:
            do ShortPassTo(mate)
        interrupt when self.owns_ball and canShoot(self, back, right_goal_midpoint, 10, 20):
            do AimGoalCornerAndShoot()

behavior RunAndShoot():
    try:
        do CloseIn()
    interrupt when (distance from self to right_goal_midpoint) < 10:
        take Shoot()

behavior CloseIn():
    while True:
        if self.owns_ball and canShoot(self, back, right_goal_midpoint, 10, 20):
            take ReleaseDribble()
            do AimGoalCornerAndShoot()
        else:
            if self.owns_ball:
                take Dribble()
            take MoveTowardsPoint(safeSpot(self, back, target), self.position)

behavior Receive():
    while True:
        try:
            do MoveToPosition(wait, sprint=True)
            do MoveToPosition(target)
        interrupt when self.owns_ball and (distance from self to right_goal_midpoint) < 20:
            do AimGoalCornerAndShoot()

ball = Ball at 70 @ 28
RightGK at 99 @ 0
back = RightCB at 75 @ 30
ego = LeftGK at -99 @ 0
mate = LeftCF at 70 @ 0, with behavior Mate()
LeftCB at 70 @ 30, with behavior Carrier()
