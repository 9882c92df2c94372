"""Eleven against eleven, from the kick-off; nothing ends the match but its duration."""

param game_duration = 3000
param offsides = True
param end_episode_on_score = False
param end_episode_on_out_of_play = False
param end_episode_on_possession_change = False
LeftGK at -99 @ 0
ego = LeftRM at 0 @ -2
LeftCF at -1 @ 2
LeftLB at -42.2 @ 19.576
LeftCB at -50 @ 6.356
LeftCB at -50 @ -6.356
LeftRB at -42.2 @ -19.576
LeftCM at -18.4 @ 10.568
LeftCM at -26.7 @ 0
LeftCM at -18.4 @ -10.568
LeftLM at -1 @ 21.6
RightGK at 99 @ 0
RightRM at 5 @ 0
RightCF at 5 @ -21.6
RightLB at 42.2 @ -19.576
RightCB at 50 @ -6.356
RightCB at 50 @ 6.356
RightRB at 42.2 @ 19.576
RightCM at 18.4 @ -10.568
RightCM at 26.7 @ 0
RightCM at 18.4 @ 10.568
RightLM at 5 @ 21.6
ball = Ball at 0 @ 0
