"""Two against two: the right mid passes high to the attacking mid, and both go on from there."""
# expect at 1: winger.pressed in (4, 5)
# expect by 12: ball.speed > 10 or ball.x < winger.x - 8

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True
param right_team_difficulty = 1

attack_region = get_reg_from_edges(-80, -75, 5, -5)

behavior AttackingMid(destination):
    passed = False
    try:
        do dribbleToAndShoot(destination)
    interrupt when left_penaltyBox.containsPoint(self.position):
        do AimGoalCornerAndShoot()
    interrupt when passed and teammateHasBallPossession(self):
        fallback = Point on get_reg_from_edges(-70, -60, 5, -5)
        do MoveToPosition(fallback, sprint=True)
        do HoldPosition() until self.owns_ball
    interrupt when opponentTeamHasBallPossession(self):
        do FollowObject(ball, sprint=True)
    do HoldPosition()

behavior RightMid(destination):
    try:
        do HighPassTo(ego)
        do MoveToPosition(destination, sprint=True)
        second = Point on attack_region
        do AttackingMid(second)
    interrupt when opponentTeamHasBallPossession(self):
        do FollowObject(ball, sprint=True)
    do HoldPosition()

LeftGK with behavior HoldPosition()
LeftRB
LeftLM on get_reg_from_edges(-1, 5, 35, 30)

RightGK
first = Point on attack_region
winger = RightRM with behavior RightMid(Point on attack_region)
ego = RightAM on get_reg_from_edges(-40, -35, 5, -5), with behavior AttackingMid(first)
ball = Ball ahead of winger by 2
