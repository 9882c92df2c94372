"""Three against one and both keepers; nothing ends the match but its duration."""

param game_duration = 3000
param end_episode_on_score = False
param end_episode_on_out_of_play = False
param end_episode_on_possession_change = False

ego = LeftCM at 60 @ 0
LeftCM at 70 @ 20
LeftCM at 70 @ -20
LeftGK at -99 @ 0
RightCB at 75 @ 0
RightGK at 99 @ 0
ball = Ball at 62 @ 0
