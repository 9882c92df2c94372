"""The easy counterattack, one agent: pass to the right wing, run at the goal, pass if an opponent is in the way."""

from skills import *

param agents_only = True

behavior Carrier():
    do StartCounterattack(winger, False)

ego = LeftGK at -99 @ 0, with behavior IdleBehavior()
LeftLB at -67.2 @ 19.576, with behavior CloseInAndShoot(False)
LeftCB at -75 @ 6.356, with behavior CloseInAndShoot(False)
LeftCB at -75 @ -6.3559, with behavior CloseInAndShoot(False)
LeftRB at -67.2 @ -19.576, with behavior CloseInAndShoot(False)
LeftCM at -43.4 @ 10.568, with behavior CloseInAndShoot(False)
LeftCM at -43.4 @ -10.568, with behavior CloseInAndShoot(False)
LeftCM at 50 @ 31.61, with behavior CloseInAndShoot(False)
LeftLM at 25 @ 10, with behavior Carrier()
winger = LeftRM at 25 @ -10, with behavior CloseInAndShoot(False)
LeftCF at 35 @ -31.61, with behavior CloseInAndShoot(False)

RightGK at 99 @ 0
RightLB at -12 @ -19
RightCB at -40 @ -6.356
RightCB at 40 @ 6.3559
RightRB at -13.5 @ -20.5
RightCM at -36.5 @ -10.568
RightCM at -28.2 @ 0
RightCM at -36.5 @ 10.568
RightLM at -54 @ -31.61
RightRM at -51 @ 0
RightCF at -54 @ 31.6102

Ball at 26 @ 11
