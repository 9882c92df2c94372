"""A counterattack: the carrier passes to the winger, and whoever is threatened passes on."""
# expect by 12: carrier.pressed == 6
# expect by 35: ball.y < 5
# expect by 50: winger.owns_ball == 1
# expect by 120: ball.x > 60

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

def mates_outside(me, lane):
    mates = [p for p in simulation().game_ds.left_players if p is not me and not lane.containsPoint(p.position)]
    return sorted(mates, key=lambda p: distance from me to p)

behavior SafePass(radius, width):
    if not self.owns_ball:
        take ReleaseDirection()
    else:
        lane = SectorRegion(self.position, radius, self.heading, width)
        mates = mates_outside(self, lane)
        if len(mates) > 0:
            do ShortPassTo(mates[0])
        else:
            take SetDirection(5)

behavior CloseInAndShoot():
    try:
        do MoveToPosition(Point at 99 @ 0)
    interrupt when opponentInRunway(self, reactionDistance=8):
        do SafePass(20, 0.5)
    interrupt when right_penaltyBox.containsPoint(self.position):
        do AimGoalCornerAndShoot()
    do IdleBehavior()

behavior StartAttack():
    do FollowObject(ball, terminate_distance=0) until self.owns_ball
    for i in range(4):
        take SetDirection(6)
    take Pass("short")
    take ReleaseSprint()
    take ReleaseDirection()
    do CloseInAndShoot()

ego = LeftGK at -99 @ 0, with behavior IdleBehavior()
ball = Ball at 26 @ 11
carrier = LeftLM at 25 @ 10, with behavior StartAttack()
winger = LeftRM at 40 @ -10, with behavior CloseInAndShoot()
forward = LeftCM at 50 @ 31, with behavior CloseInAndShoot()
RightGK at 99 @ 0
RightCB at 40 @ 6
RightCB at -40 @ -6
