"""The rules: goals, the ball out of play, restarts, possession, and what ends an episode.

Read next: `simulator`, where they close a step.
"""

from __future__ import annotations

import math

from envs.football.ball import BALL_RADIUS
from envs.football.constants import (
    CORNER,
    DURATION,
    GOAL,
    GOAL_HALF_WIDTH,
    GOAL_HEIGHT,
    GOAL_KICK,
    HALF_LENGTH,
    HALF_WIDTH,
    LEFT,
    NOBODY,
    NORMAL,
    NOT_A_NUMBER,
    OUT_MARGIN,
    OUT_OF_PLAY,
    POSSESSION,
    RIGHT,
    RUNNING,
    THROW_IN,
)
from envs.football.possession import forget_kick, lose_ball, update_possession
from envs.football.vectors import apart, toward
from scenic_lite.jit import kernel

GOAL_KICK_X = 0.92 * HALF_LENGTH
WAIT_THROW_IN, WAIT_OTHERS = 3, 6  # steps
TAKER_BEHIND = 0.5  # m from the taker to the ball


@kernel
def begin_step(match):
    """Forget the events of the step before."""
    match.goal = 0
    match.checkpoint_reward[:] = 0.0
    match.program_reward = 0.0
    match.possession_changed = False


@kernel
def apply_rules(match):
    """Judge what the frames of this step have brought."""
    match.step += 1
    if match.restart_wait > 0:
        wait_for_restart(match)
    elif match.game_mode == NORMAL:
        judge_ball(match)
    update_possession(match)
    end_episode(match)


@kernel
def judge_ball(match):
    """Find a goal or a ball out of play."""
    ball = match.ball
    if abs(ball.x) > HALF_LENGTH + OUT_MARGIN:
        if abs(ball.y) < GOAL_HALF_WIDTH and ball.z < GOAL_HEIGHT:
            score(match, LEFT if ball.x > 0.0 else RIGHT)
        else:
            behind_goal_line(match)
    elif abs(ball.y) > HALF_WIDTH + OUT_MARGIN:
        stop_play(match, THROW_IN, other_team(match), ball.x, math.copysign(HALF_WIDTH, ball.y))


@kernel
def other_team(match):
    """Team that did not touch the ball last."""
    if match.last_touch == NOBODY:
        return LEFT
    return 1 - match.players[match.last_touch].team


@kernel
def behind_goal_line(match):
    """Give a goal kick or a corner."""
    ball = match.ball
    defenders = RIGHT if ball.x > 0.0 else LEFT
    team = other_team(match)
    if team == defenders:
        stop_play(match, GOAL_KICK, team, math.copysign(GOAL_KICK_X, ball.x), 0.0)
    else:
        corner_x, corner_y = math.copysign(HALF_LENGTH, ball.x), math.copysign(HALF_WIDTH, ball.y)
        stop_play(match, CORNER, team, corner_x, corner_y)


@kernel
def score(match, team):
    """Count a goal for `team`; if play goes on, the others kick off at once."""
    match.goal = 1 if team == LEFT else -1
    match.score[team] += 1
    if match.end_episode_on_score:
        return
    for i in range(match.num_players):
        player = match.players[i]
        player.x, player.y = player.start_x, player.start_y
        stand_still(player)
    put_ball(match, 0.0, 0.0)
    match.last_touch = NOBODY
    match.last_owned_team = NOBODY


@kernel
def stand_still(player):
    """Stop a player and clear what he was about to do."""
    player.vx, player.vy = 0.0, 0.0
    player.want_x, player.want_y = 0.0, 0.0
    player.down, player.touch_wait, player.turning, player.sliding = 0.0, 0.0, 0, False
    forget_kick(player)


@kernel
def put_ball(match, x, y):
    """Lay the ball down still at (x, y), free."""
    ball = match.ball
    ball.x, ball.y, ball.z = x, y, BALL_RADIUS
    ball.vx, ball.vy, ball.vz, ball.spin_x, ball.spin_y = 0.0, 0.0, 0.0, 0.0, 0.0
    lose_ball(match)
    match.saver = NOBODY


@kernel
def stop_play(match, mode, team, x, y):
    """Stop play for a restart by `team` at (x, y). When the episode ends on it the ball stays where it is."""
    match.game_mode = mode
    match.restart_team = team
    match.offside_bits = 0
    match.restart_wait = WAIT_THROW_IN if mode == THROW_IN else WAIT_OTHERS
    if not match.end_episode_on_out_of_play:
        put_ball(match, x, y)


@kernel
def wait_for_restart(match):
    """Count the restart down; then put its taker at the ball and play on."""
    match.restart_wait -= 1
    if match.restart_wait > 0:
        return
    taker = nearest_of(match, match.restart_team)
    if taker != NOBODY:
        player, ball = match.players[taker], match.ball
        stand_still(player)
        goal_x = HALF_LENGTH if player.team == LEFT else -HALF_LENGTH
        player.facing_x, player.facing_y = toward(goal_x - ball.x, -ball.y)
        player.x, player.y = ball.x - TAKER_BEHIND * player.facing_x, ball.y - TAKER_BEHIND * player.facing_y
        match.carrier = taker
        match.last_touch = taker
    match.game_mode = NORMAL
    match.restart_team = NOBODY


@kernel
def nearest_of(match, team):
    """Return the player of `team` nearest to the ball, -1 if it has none."""
    nearest, best = math.inf, NOBODY
    for i in range(match.num_players):
        player = match.players[i]
        distance = apart(match.ball, player)
        if player.team == team and distance < nearest:
            nearest, best = distance, i
    return best


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
