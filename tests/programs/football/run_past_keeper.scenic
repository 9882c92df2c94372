"""A runner alone before the keeper: he evades once, to a side drawn at that moment, and shoots from the box."""
# expect by 40: runner.sprint == 1
# expect by 180: runner.x > 60
# expect always: distance(ego, ego_start) < 1

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *
import random

param game_duration = 200
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

behavior dribble_evasive_zigzag(keeper):
    side = Uniform(1, -1)
    goal = self.position offset along (self.heading + side * Range(30, 50) deg) by 0 @ Range(30, 40)
    while self.x <= keeper.x and (distance from self to goal) > 2:
        take MoveTowardsPoint(goal, self.position)

behavior Runner():
    keeper = None
    for p in simulation().game_ds.right_players:
        if p.role == "GK":
            keeper = p
    evaded = False
    try:
        do MoveToPosition(99 @ 0, sprint=True)
    interrupt when not evaded and (distance from self to keeper) < 40:
        evaded = True
        do dribble_evasive_zigzag(keeper)
    interrupt when ball in right_penaltyBox:
        do AimGoalCornerAndShoot()
    do IdleBehavior()

ball = Ball at 2 @ 0
ego = LeftGK at -99 @ 0, with behavior IdleBehavior()
runner = LeftCB at 0 @ 0, with behavior Runner()
RightGK at 99 @ 0
RightLB at -12 @ 20
RightCB at -12 @ 0
RightRB at -12 @ -20
