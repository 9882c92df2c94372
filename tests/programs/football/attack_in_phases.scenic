"""Two wingers attack in phases that scenarios put together: they wait, press up the wing, then whoever has the ball shoots.

The defender marks one of them, drawn anew in each phase.
"""
# expect at 5: abs(upper.x - 40) < 2
# expect at 60: upper.x > 42

from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *
from scenic.simulators.gfootball.simulator import GFootBallSimulator

param game_duration = 400
param deterministic = False
param offsides = False
param end_episode_on_score = True
param end_episode_on_out_of_play = True

behavior Run(direction):
    while True:
        take SetDirection(direction)

behavior Finish():
    try:
        do Run(5)
    interrupt when self.owns_ball and self.x > 70:
        take Shoot()

behavior Mark(player, tightness):
    while True:
        if (distance from self to player) > tightness:
            do MoveToPosition(player.position)
        else:
            take ReleaseDirection()

monitor Pay(amount):
    while True:
        simulation().scenic_reward = amount
        wait

scenario Up(player, target):
    setup:
        override player with behavior Run(Uniform(4, 5))
        record player.x as advance
        terminate when player.x > target

scenario Marking(player):
    setup:
        tightness = Range(2, 6)
        override stopper with behavior Mark(player, tightness)
        record tightness as tightness
        require monitor Pay(0.01)

scenario Attack(target):
    precondition: upper.x < 90
    compose:
        do Up(upper, target), Up(lower, target), Uniform(Marking(upper), Marking(lower))

scenario Shot():
    setup:
        override upper with behavior Finish()
        override lower with behavior Finish()
    compose:
        wait for 3 seconds

ego = LeftGK
upper = LeftPlayer at 40 @ Range(10, 20), with role "LM", with behavior HoldPosition()
lower = LeftPlayer at Range(35, 40) @ -15, with role "RM", with behavior HoldPosition()
RightGK with behavior HoldPosition()
stopper = RightPlayer at 60 @ 0, with role "CB", with behavior HoldPosition()
ball = Ball right of upper by 2

scenario Main():
    setup:
        record initial upper.y as side
        record final ball.position as end
        terminate simulation when ball.position.x < -20
    compose:
        wait for 1 seconds
        try:
            while True:
                do Attack(55) for 8 seconds
                do shuffle {Attack(75): 1, Shot(): 2} for 6 seconds
        interrupt when upper.owns_ball and upper.x > 80:
            do Shot()
            abort
