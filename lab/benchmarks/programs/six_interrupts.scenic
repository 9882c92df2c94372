"""Six players, three a side, each with a behavior that two interrupts may take over."""

from football.behaviors import *

param game_duration = 400
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = False

behavior PlayFrom(home, goal):
    try:
        while True:
            do MoveToPosition(home)
            do HoldPosition() for 5 steps
    interrupt when (distance from self to ball) < 15:
        do FollowObject(ball, terminate_distance=1, sprint=True)
    interrupt when self.owns_ball:
        take MoveTowardsPoint(goal, self.position, self.team == "right")
        if (distance from self to goal) < 20:
            take Shoot()

ego = LeftCM at -10 @ 0, with behavior PlayFrom(-5 @ 0, 100 @ 0)
LeftCB at -40 @ 15, with behavior PlayFrom(-30 @ 15, 100 @ 0)
LeftCB at -40 @ -15, with behavior PlayFrom(-30 @ -15, 100 @ 0)
RightCM at 10 @ 4, with behavior PlayFrom(5 @ 0, -100 @ 0)
RightCB at 40 @ 15, with behavior PlayFrom(30 @ 15, -100 @ 0)
RightCB at 40 @ -15, with behavior PlayFrom(30 @ -15, -100 @ 0)
ball = Ball at 0 @ 2
