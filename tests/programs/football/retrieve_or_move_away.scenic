"""One back goes for the ball, the other makes room on a side drawn while he runs."""
# expect by 150: abs(away.y) > 36 and abs(away.x - 90) < 4
# expect by 120: distance(ego, ball) < 4

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

param game_duration = 200
param end_episode_on_score = False
param end_episode_on_out_of_play = False
param end_episode_on_possession_change = False

behavior Retrieve(what):
    while True:
        do MoveToPosition(what.position, reaction_dist=1)

behavior MoveAway():
    do MoveToPosition(Uniform(90 @ -40, 90 @ 40))
    do HoldPosition()

LeftGK with behavior HoldPosition()
RightGK with behavior HoldPosition()
a = LeftCF on get_reg_from_edges(50, 70, 20, -20), with behavior HoldPosition()
b = LeftCF on get_reg_from_edges(50, 70, 20, -20), with behavior HoldPosition()
ball = Ball ahead of Uniform(a, b) by 2
ego = RightCB in right_penaltyBox, with behavior Retrieve(ball)
away = RightCB in right_penaltyBox, with behavior MoveAway()
