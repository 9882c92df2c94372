"""What ends an episode: a goal, the ball out of play, the other team's possession, or time.

Read next: `control.reward`.
"""

from __future__ import annotations

import math

from envs.football.constants import DURATION, GOAL, NORMAL, NOT_A_NUMBER, OUT_OF_PLAY, POSSESSION, RUNNING
from scenic_lite.kernels.jit import kernel


@kernel
def end_episode(match):
    """Set what ended the episode, if anything did; an event goes before the duration."""
    if match.goal != 0 and match.end_episode_on_score:
        match.ended = GOAL
    elif match.game_mode != NORMAL and match.end_episode_on_out_of_play:
        match.ended = OUT_OF_PLAY
    elif match.possession_changed and match.end_episode_on_possession_change:
        match.ended = POSSESSION
    elif match.step >= match.game_duration:
        match.ended = DURATION
    match.terminated = match.ended != RUNNING and match.ended != DURATION
    match.truncated = match.ended == DURATION
    if not math.isfinite(match.ball.x + match.ball.y + match.ball.z):
        match.fault = NOT_A_NUMBER
