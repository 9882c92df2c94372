"""Eleven against a keeper, one agent: run at the goal, and shoot from directly in front of it."""

from skills import *

param game_duration = 200
param agents_only = True

behavior RunAndShoot():
    while True:
        if self.x >= 75 and abs(self.y) <= 10:
            take Shoot()
        elif (distance from self to keeper) < 7:
            take NoAction()
        else:
            take MoveTowardsPoint(80 @ 0, self.position)

ego = Ball at 0 @ 0
keeper = RightGK
LeftGK at -98 @ 0, with behavior RunAndShoot()
LeftLB at -60 @ 30, with behavior RunAndShoot()
LeftCB at -70 @ 12, with behavior RunAndShoot()
LeftCB at -70 @ -12, with behavior RunAndShoot()
LeftRB at -60 @ -30, with behavior RunAndShoot()
LeftLM at -25 @ 15, with behavior RunAndShoot()
LeftCM at -50 @ 10, with behavior RunAndShoot()
LeftCM at -50 @ -10, with behavior RunAndShoot()
LeftRM at -25 @ -15, with behavior RunAndShoot()
LeftAM at -15 @ -2, with behavior RunAndShoot()
LeftCF at -2 @ -1, with behavior RunAndShoot()
