from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

monitor CustomRewardMonitor:
    sim = simulation()
    while True:
        ball_x = sim.game_ds.ball.position.x
        ball_y = sim.game_ds.ball.position.y
        if ball_y > 70 and abs(ball_y) < 50:
            sim.scenic_reward = 0.1
        else:
            sim.scenic_reward = 0

        wait

ego = LeftCM at 60 @ 0
RightGK
LeftGK
ball = Ball ahead of ego by 2
