"""An attacker who evades whoever comes near, and runs after a ball that got away."""
# expect at 30: distance(ego, ball) < 8
# expect always: abs(keeper.y) < 8

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = False
param right_team_difficulty = 1

behavior ZigzagAttack(goal):
    try:
        do dribbleToAndShoot(goal, reactionDistance=Range(1, 5))
    interrupt when (distance from self to ball) > 2:
        do FollowObject(ball, sprint=True)
    do IdleBehavior()

RightGK
ego = RightCM on get_reg_from_edges(-50, 0, 38, -38), with behavior ZigzagAttack(-80 @ 0)
ball = Ball ahead of ego by 2

keeper = LeftGK with behavior HoldPosition()
LeftCB left of ego by Range(5, 10)
