"""The effect of a touch: the player takes the ball.

Read next: `skills.hands`, for keepers; `skills.contacts`, which decides on touches.
"""

from __future__ import annotations

from regista.envs.football.constants import BALL_RADIUS, NOBODY
from regista.envs.football.physics.possession import lose_ball
from regista.envs.football.rules.offside import whistled
from regista.kernels.jit import kernel


@kernel
def take(match, i):
    """Give player i the ball at the feet, moving along, unless the player is offside."""
    if whistled(match, i):
        return
    player, ball = match.players[i], match.ball
    lose_ball(match)
    ball.vx, ball.vy, ball.vz = player.vx, player.vy, 0.0
    ball.spin_x, ball.spin_y, ball.curl = ball.vx, ball.vy, 0.0
    ball.z = BALL_RADIUS
    match.saver = NOBODY
    match.carrier = i
    match.last_touch = i
    match.was_kicked = False
