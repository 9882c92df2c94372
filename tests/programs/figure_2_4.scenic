from scenic.simulators.gfootball.model import *
from scenic.simulators.gfootball.behaviors import *

monitor CustomTerminationMonitor:
    sim = simulation()
    while True:
        ball_x = sim.game_ds.ball.position.x
        if ball_x > 0:
            terminate

        wait

ego = LeftCM at -10 @ 0
RightGK
LeftGK
ball = Ball ahead of ego by 2
