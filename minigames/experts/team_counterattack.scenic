"""The easy counterattack, three agents: the carrier, the right winger and the forward midfielder."""

from skills import *

behavior Carrier():
    do StartCounterattack(winger, True)

ego = LeftGK at -99 @ 0
LeftLB at -67.2 @ 19.576
LeftCB at -75 @ 6.356
LeftCB at -75 @ -6.3559
LeftRB at -67.2 @ -19.576
LeftCM at -43.4 @ 10.568
LeftCM at -43.4 @ -10.568
LeftCM at 50 @ 31.61, with behavior CloseInAndShoot(True)
LeftLM at 25 @ 10, with behavior Carrier()
winger = LeftRM at 25 @ -10, with behavior CloseInAndShoot(True)
LeftCF at 35 @ -31.61

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
