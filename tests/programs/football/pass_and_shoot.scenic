"""Two forwards against a back: one passes or keeps the ball, as the level says; a keeper in goal."""
# expect by 60: ball.x > 78
# expect always: ego.x < -90

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

danger_radius = 20
shoot_distance = 20
target = Point on right_goalRegion
choice = Uniform("pass", "shoot")

def can_shoot(me, opponent, goal):
    gap = distance from me to goal
    if gap < 8:
        return True
    way = angle from me to goal
    lane = SectorRegion(me.position, danger_radius, way, 40 deg)
    return gap < shoot_distance and not lane.containsPoint(opponent.position)

def safe_side(me, opponent, goal):
    """Of two points past the opponent the one nearer to the goal."""
    way = angle from me to opponent
    left = me.position offset along (way + 35 deg) by 0 @ 20
    right = me.position offset along (way - 35 deg) by 0 @ 20
    return left if (distance from left to goal) < (distance from right to goal) else right

behavior CloseInAndShoot(opponent, goal):
    while True:
        if not self.owns_ball:
            take MoveTowardsPoint(ball.position, self.position)
        elif can_shoot(self, opponent, goal):
            take ReleaseDribble()
            take Shoot()
        else:
            take Dribble()
            take MoveTowardsPoint(safe_side(self, opponent, goal), self.position)

behavior RunAndShoot(opponent, goal):
    try:
        do CloseInAndShoot(opponent, goal)
    interrupt when (distance from self to right_goal_midpoint) < 8:
        take Shoot()

behavior JustPass():
    passed = False
    while True:
        if passed:
            passed = self.owns_ball
            take SetDirection(5)
        elif self.owns_ball:
            do ShortPassTo(p2)
            passed = True
        else:
            take MoveTowardsPoint(ball.position, self.position)

behavior JustShoot():
    while True:
        if self.owns_ball and (distance from self to right_goal_midpoint) < 30:
            first = Uniform("down", "ahead", "nothing")
            if first == "down":
                take SetDirection(6)
            elif first == "ahead":
                take SetDirection(5)
            take Shoot()
        elif self.owns_ball:
            take MoveTowardsPoint(right_goal_midpoint, self.position)
        else:
            take ReleaseDirection()

behavior Carrier(opponent, goal):
    if choice == "pass":
        do JustPass()
    else:
        do RunAndShoot(opponent, goal)

behavior Receiver(opponent, goal):
    if choice == "pass":
        do JustShoot()
    else:
        do RunAndShoot(opponent, goal)

ball = Ball at 70 @ 28
RightGK at 99 @ 0
back = RightCB at 78 @ 8
ego = LeftGK at -99 @ 0, with behavior IdleBehavior()
p2 = LeftCF at 70 @ 0, with behavior Receiver(back, target)
p1 = LeftCB at 70 @ 30, with behavior Carrier(back, target)
