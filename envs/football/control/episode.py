"""The end of an episode (a goal, the ball out of play, a possession change, the time limit) and its success.

Read next: `control.reward`.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import (
    DURATION,
    GOAL,
    LEFT,
    NORMAL,
    NOT_A_NUMBER,
    OUT_OF_PLAY,
    POSSESSION,
    RIGHT,
    RUNNING,
)
from regista.kernels.jit import kernel


@kernel
def end_episode(match):
    """Set the reason for the end of the episode, if it has ended; events take precedence over the duration."""
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


@kernel
def has_succeeded(match, defending):
    """Return whether the agents' team succeeds: it has more goals than the other team, or when defending, concedes
    none.

    The agents' team is the left one unless only the right one has agents.
    """
    own = RIGHT if match.num_agents[LEFT] == 0 and match.num_agents[RIGHT] > 0 else LEFT
    if defending:
        return match.score[1 - own] == 0
    return match.score[own] > match.score[1 - own]
