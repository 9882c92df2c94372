"""1v1 with two fresh ranges for each player (thesis, Figure 4.3); six draws, the own keeper's place among them."""

from scenic.simulators.gfootball.model import *

X1 = Range (0, 80)
Y1 = Range (-25, 25)
X2 = Range (0, 80)
Y2 = Range (-25, 25)

ego = LeftCM at (X1 @ Y1)
opponent = RightGK at (X2 @ Y2)

MyGK
ball = Ball ahead of ego by 2
