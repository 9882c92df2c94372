"""The rules: goals, the ball out of play, fouls, restarts, and the second half.

Read next: `simulator`, which ends a step with the rules; `rules.restarts`.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import (
    CORNER,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    GOAL_KICK,
    HALF_LENGTH,
    HALF_WIDTH,
    LEFT,
    NOBODY,
    NORMAL,
    OUT_MARGIN,
    RIGHT,
    STEP,
    THROW_IN,
)
from regista.envs.football.physics.possession import own_at_restart, update_possession
from regista.envs.football.rules.fouls import judge_foul, send_off
from regista.envs.football.rules.kick_offs import kick_off_again, second_half
from regista.envs.football.rules.restarts import set_up
from regista.envs.football.rules.whistle import off_pitch, stop_play
from regista.kernels.jit import kernel

GOAL_KICK_X = 0.92 * HALF_LENGTH
THROW_IN_X = HALF_LENGTH - 0.6  # m; throw-ins are taken at most this far from the middle


@kernel
def forget_events(match):
    """Clear the results of the rules in the last step."""
    match.goal = 0
    match.possession_changed = False


@kernel
def apply_rules(match):
    """Apply the rules to this step, and set up the restart if play has stopped."""
    match.step += 1
    match.line_wait = max(match.line_wait - STEP, 0.0)
    if match.game_mode == NORMAL:
        judge(match)
    if match.game_mode == NORMAL:
        update_possession(match)
    else:
        if match.taker == NOBODY and match.restart_wait == 0:
            set_up(match)
        own_at_restart(match)
    send_off(match)


@kernel
def judge(match):
    """Find a goal, a foul, a ball out of play, or the end of the first half, in this order."""
    if off_pitch(match):
        if in_goal(match.ball):
            score(match, LEFT if match.ball.x > 0.0 else RIGHT)
            return
        judge_foul(match, True)
        if match.game_mode == NORMAL:
            judge_out(match)
        return
    judge_foul(match, False)
    if match.half == 0 and match.step >= match.second_half and match.game_mode == NORMAL:
        second_half(match)


@kernel
def in_goal(ball):
    """Return whether a ball beyond the goal line crossed the line inside the frame."""
    beyond = abs(ball.x) - HALF_LENGTH - OUT_MARGIN
    time = beyond / abs(ball.vx) if abs(ball.vx) > 0.0 else 0.0
    y, z = ball.y - time * ball.vy, ball.z - time * ball.vz
    return beyond > 0.0 and abs(y) < GOAL_HALF_WIDTH and z < GOAL_HEIGHT


@kernel
def judge_out(match):
    """Give a throw-in, a goal kick or a corner."""
    ball = match.ball
    team = other_team(match)
    if abs(ball.x) <= HALF_LENGTH + OUT_MARGIN:
        x = min(max(ball.x, -THROW_IN_X), THROW_IN_X)
        stop_play(match, THROW_IN, team, x, math.copysign(HALF_WIDTH, ball.y))
    elif team == (RIGHT if ball.x > 0.0 else LEFT):
        stop_play(match, GOAL_KICK, team, math.copysign(GOAL_KICK_X, ball.x), 0.0)
    else:
        side = ball.y if ball.y != 0.0 else ball.x  # over the bar, exactly in the middle
        stop_play(match, CORNER, team, math.copysign(HALF_LENGTH, ball.x), math.copysign(HALF_WIDTH, side))


@kernel
def other_team(match):
    """Return the team that did not touch the ball last; without a touch, the team that defends this half."""
    if match.last_touch == NOBODY:
        return RIGHT if match.ball.x > 0.0 else LEFT
    return 1 - match.players[match.last_touch].team


@kernel
def score(match, team):
    """Count a goal for `team`; if play goes on, the other team kicks off at once."""
    match.goal = 1 if team == LEFT else -1
    match.score[team] += 1
    if not match.end_episode_on_score:
        kick_off_again(match, 1 - team, 0.0, 0.0)
