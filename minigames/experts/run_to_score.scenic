"""Run to score with a keeper, one agent: sprint at the goal, pass the keeper on a random side, shoot in the box."""

from skills import *

param game_duration = 200
param agents_only = True

behavior Runner():
    evaded = False
    try:
        do MoveToPosition(99 @ 0, sprint=True)
    interrupt when not evaded and (distance from self to keeper) < 40:
        evaded = True
        do Evade()
    interrupt when right_penaltyBox.containsPoint(ball.position):
        do AimGoalCornerAndShoot()
    do IdleBehavior()

behavior Evade():
    turn = Uniform(1, -1) * Range(30, 50) deg
    spot = self.position offset along (self.heading + turn) by 0 @ Range(50, 60)
    while self.x <= keeper.x:
        take MoveTowardsPoint(spot, self.position)

ball = Ball at 2 @ 0
ego = LeftGK at -99 @ 0, with behavior IdleBehavior()
LeftCB at 0 @ 0, with behavior Runner()
keeper = RightGK at 99 @ 0
RightLB at -12 @ -20
RightCB at -12 @ -10
RightCM at -12 @ 0
RightCB at -12 @ 10
RightRB at -12 @ 20
