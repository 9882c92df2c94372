"""Leading the ball with the feet: touches that send it a little ahead.

A touch gives the ball the velocity that brings it to its place ahead of the player; between touches it rolls
free, and anybody can take it. Read next: `contacts`, where others do.
"""

from __future__ import annotations

import math

from envs.football.ball import GROUND_DRAG, GROUND_FRICTION
from envs.football.constants import BALL_RADIUS, NOBODY, STEP
from envs.football.vectors import toward
from scenic_lite.jit import kernel

TOUCH_REACH = 1.15  # m from the body to a ball that the foot can still play
TOUCH_BELOW = 0.9  # m
WALKING = 0.5  # m/s, slower players keep the ball at the foot
AHEAD_STANDING, AHEAD_RUNNING, AHEAD_SPRINTING, AHEAD_KNOCKED_ON = 0.38, 0.49, 0.98, 2.3  # m
TOUCH_TIME, TOUCH_TIME_SPRINTING, TOUCH_TIME_KNOCKED_ON = 0.1, 0.2, 0.6  # s
SPRINTING = 5.8  # m/s
TOUCH_SPEED = 3.0  # m/s at most, relative to the player


@kernel
def lead_ball(match):
    """Let the carrier touch the ball if it is his turn to; return whether he did."""
    i = match.carrier
    if i == NOBODY or match.holder != NOBODY or match.game_mode != 0:
        return False
    player, ball = match.players[i], match.ball
    if (player.touch_wait > 0.0 and match.kicker != i) or player.down > 0.0 or ball.z > TOUCH_BELOW:
        return False
    away_x, away_y = ball.x - player.x, ball.y - player.y
    if away_x * away_x + away_y * away_y > TOUCH_REACH * TOUCH_REACH:
        return False
    touch(ball, player, match.kicker == i)
    return True


@kernel
def touch(ball, player, kicking):
    """Play the ball to its place ahead of a player, or to the foot that is about to kick it."""
    vx, vy = player.vx, player.vy
    speed = math.sqrt(vx * vx + vy * vy)
    want = math.sqrt(player.want_x * player.want_x + player.want_y * player.want_y)
    ahead, time = AHEAD_RUNNING, TOUCH_TIME
    ux, uy = player.facing_x, player.facing_y
    if kicking:
        ux, uy = toward(player.aim_x - player.x, player.aim_y - player.y)
    elif speed > SPRINTING and want > SPRINTING:
        ux, uy = vx / speed, vy / speed
        ahead, time = AHEAD_SPRINTING, TOUCH_TIME_SPRINTING
        if player.dribble and player.sprint:
            ahead, time = AHEAD_KNOCKED_ON, TOUCH_TIME_KNOCKED_ON
    elif want > WALKING:
        ux, uy = player.want_x / want, player.want_y / want
    else:
        ahead = AHEAD_STANDING
    push_x = (player.x + ahead * ux - ball.x) / time
    push_y = (player.y + ahead * uy - ball.y) / time
    push = math.sqrt(push_x * push_x + push_y * push_y)
    if push > TOUCH_SPEED:
        push_x, push_y = push_x / push * TOUCH_SPEED, push_y / push * TOUCH_SPEED
    ball.vx, ball.vy, ball.vz = vx + push_x, vy + push_y, 0.0
    ball.z = BALL_RADIUS
    against_drag(ball, time)
    ball.spin_x, ball.spin_y = ball.vx, ball.vy
    player.touch_wait = time - 0.5 * STEP


@kernel
def against_drag(ball, time):
    """Add what a rolling ball loses to the ground in half this time."""
    speed = math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy)
    if speed > 0.1:
        gain = 1.0 + 0.5 * time * (GROUND_FRICTION + GROUND_DRAG * speed * speed) / speed
        ball.vx *= gain
        ball.vy *= gain
