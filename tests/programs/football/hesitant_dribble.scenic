"""An attacker who stops every few steps on his way to goal, a defender who waits, two parked keepers."""
# expect at 10: ego.x > -32
# expect always: abs(keeper.x - 95) < 4
# expect by 150: ego.x < -40
# expect by 120: ego.speed < 2 and ego.x < -28

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
param right_team_difficulty = 1

behavior HesitantDribble(goal, stride, rest):
    try:
        while True:
            do MoveToPosition(goal) for stride steps
            do HoldPosition() for rest steps
    interrupt when left_penaltyBox.containsPoint(self.position):
        do AimGoalCornerAndShoot()
    interrupt when (distance from self to ball) > 3:
        do FollowObject(ball, terminate_distance=1.5, sprint=True)

keeper = LeftGK at 95 @ 40, with behavior HoldPosition()
defender = LeftRB at -90 @ -38, with behavior HoldPosition()
RightGK at 98 @ 38, with behavior HoldPosition()
ego = RightAM on get_reg_from_edges(-26, -22, 5, -5), with behavior HesitantDribble(-80 @ 0, 12, 6)
ball = Ball ahead of ego by 2
