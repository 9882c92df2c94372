"""Two forwards wait in line with the last defender but one; whoever gets the ball idles."""
# expect at 60: abs(upper.x - 60) < 8
# expect at 60: abs(lower.x - 60) < 8
# expect at 60: upper.x < 75

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *
from scenic.simulators.gfootball.simulator import GFootBallSimulator

param game_duration = 400
param deterministic = False
param offsides = True
param end_episode_on_score = True
param end_episode_on_out_of_play = True
param end_episode_on_possession_change = True

def offside_line():
    defenders = sorted([p.x for p in simulation().game_ds.right_players if p.x < 100], reverse=True)
    return defenders[1]

behavior stay_onside():
    while True:
        if self.owns_ball:
            do IdleBehavior()
        line = offside_line()
        if self.x >= line - 2:
            take SetDirection(1)
        elif self.x < line - 5:
            take SetDirection(5)
        else:
            take ReleaseDirection()

ego = LeftGK
passer = LeftPlayer at -20 @ 0, with role "LM", with behavior IdleBehavior()
upper = LeftPlayer on get_reg_from_edges(70, 80, 5, 15), with role "CF", with width 1.5, with length 1.5,
    with behavior stay_onside()
lower = LeftPlayer on get_reg_from_edges(70, 80, -15, -5), with role "RM", with width 1.5, with length 1.5,
    with behavior stay_onside()

RightGK with behavior HoldPosition()
crowd = []
for place in (60 @ 30, 45 @ -30, 40 @ 20):
    crowd.append(RightPlayer at place, with role "CB", with behavior HoldPosition())

ball = Ball right of passer by 2
