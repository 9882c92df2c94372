"""The whistle: when the ball is out, how play stops for a restart, and putting ball and players to rest.

Read next: `rules.restarts`, which resumes play.
"""

from __future__ import annotations

from regista.envs.football.constants import BALL_RADIUS, FREE_KICK, HALF_LENGTH, HALF_WIDTH, NOBODY, OUT_MARGIN
from regista.envs.football.physics.possession import forget_kick, lose_ball
from regista.envs.football.physics.vectors import toward
from regista.kernels.jit import kernel

KICK_WITHIN = 0.95  # share of the pitch within which free kicks are taken


@kernel
def off_pitch(match):
    """Return whether the ball's center is beyond a line; just after a set piece, side lines are ignored."""
    ball = match.ball
    beside = abs(ball.y) > HALF_WIDTH + OUT_MARGIN and match.line_wait <= 1e-9
    return beside or abs(ball.x) > HALF_LENGTH + OUT_MARGIN


@kernel
def stop_play(match, mode, team, x, y):
    """Stop play for a restart of this mode by `team` from (x, y); `rules` sets it up when the step ends.

    Free kicks are not taken too near a line.
    """
    if mode == FREE_KICK:
        x = min(max(x, -KICK_WITHIN * HALF_LENGTH), KICK_WITHIN * HALF_LENGTH)
        y = min(max(y, -KICK_WITHIN * HALF_WIDTH), KICK_WITHIN * HALF_WIDTH)
    match.game_mode = mode
    match.restart_team = team
    match.restart_wait = 0
    match.taker = NOBODY
    match.offside_bits = 0
    match.foul_player = NOBODY
    put_ball(match, x, y)


@kernel
def put_ball(match, x, y):
    """Put the free ball down at rest at (x, y)."""
    ball = match.ball
    ball.x, ball.y, ball.z = x, y, BALL_RADIUS
    ball.vx, ball.vy, ball.vz, ball.spin_x, ball.spin_y = 0.0, 0.0, 0.0, 0.0, 0.0
    lose_ball(match)
    match.saver, match.receiver, match.was_kicked = NOBODY, NOBODY, False


@kernel
def stand_still(player):
    """Stop a player and cancel a requested kick."""
    player.vx, player.vy = 0.0, 0.0
    player.desired_vx, player.desired_vy = 0.0, 0.0
    player.down_wait, player.touch_wait, player.turning = 0.0, 0.0, 0
    player.brings_down, player.is_sliding = False, False
    forget_kick(player)


@kernel
def move_to(match, i, x, y):
    """Put player i at (x, y), at rest and facing the ball, unless the player has left the pitch."""
    player = match.players[i]
    if player.has_left:
        return
    stand_still(player)
    player.x, player.y = x, y
    look_at(player, match.ball.x, match.ball.y)


@kernel
def look_at(player, x, y):
    """Turn a player's body to (x, y), unless the player stands exactly there."""
    if x != player.x or y != player.y:
        player.facing_x, player.facing_y = toward(x - player.x, y - player.y)
