"""Eleven against a keeper: everybody runs at the goal and shoots from before it."""
# expect by 30: cf.owns_ball == 1
# expect by 120: cf.x > 40

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *
import random

param game_duration = 200
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

behavior GreedyRunAndShoot():
    lane = random.randint(-8, 8)
    while True:
        if self.x < 75 or abs(self.y) > 10:
            if (distance from self to keeper) < 7 and self.owns_ball:
                take Shoot()
            else:
                take MoveTowardsPoint(80 @ lane, self.position)
        else:
            take Shoot()

ego = Ball at 0 @ 0
keeper = RightGK
LeftGK at -98 @ 0, with behavior GreedyRunAndShoot()
LeftLB at -60 @ 30, with behavior GreedyRunAndShoot()
LeftCB at -70 @ 12, with behavior GreedyRunAndShoot()
LeftCB at -70 @ -12, with behavior GreedyRunAndShoot()
LeftRB at -60 @ -30, with behavior GreedyRunAndShoot()
lm = LeftLM at -25 @ 15, with behavior GreedyRunAndShoot()
LeftCM at -50 @ 10, with behavior GreedyRunAndShoot()
LeftCM at -50 @ -10, with behavior GreedyRunAndShoot()
LeftRM at -25 @ -15, with behavior GreedyRunAndShoot()
am = LeftAM at -15 @ -2, with behavior GreedyRunAndShoot()
cf = LeftCF at -2 @ -1, with behavior GreedyRunAndShoot()
