"""Eleven against a keeper, three agents: the forward dribbles and passes near the keeper, two teammates run wide."""

from skills import *

param game_duration = 200

target = Point on right_goalRegion

behavior Primary(dest):
    while True:
        try:
            do MoveToPosition(dest)
        interrupt when right_penaltyBox.containsPoint(ball.position):
            do AimGoalCornerAndShoot()
        interrupt when (distance from self to keeper) < Range(8, 20):
            take Pass("short")
            take MoveTowardsPoint(safeSpot(self, keeper, target), self.position)

behavior Secondary(dest):
    while True:
        try:
            do MoveToPosition(dest, sprint=True)
        interrupt when (distance from self to ball) < 2:
            do GreedyRun()

behavior GreedyRun():
    while True:
        if self.x >= 75 and abs(self.y) <= 15:
            take Shoot()
        elif (distance from self to keeper) < 7:
            take NoAction()
        else:
            take MoveTowardsPoint(Range(80, 90) @ Range(-5, 5), self.position)

ego = Ball at 0 @ 0
ball = ego
keeper = RightGK
LeftGK at -98 @ 0
LeftLB at -60 @ 30
LeftCB at -70 @ 12
LeftCB at -70 @ -12
LeftRB at -60 @ -30
LeftLM at -25 @ 15, with behavior Secondary(Range(70, 90) @ Range(15, 25))
LeftCM at -50 @ 10
LeftCM at -50 @ -10
LeftRM at -25 @ -15
LeftAM at -15 @ -2, with behavior Secondary(Range(70, 90) @ Range(-25, -15))
LeftCF at -2 @ -1, with behavior Primary(target)
