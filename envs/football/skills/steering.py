"""Steering: the velocity that leads a player to a point, to a free ball or to a carrier's ball; and slides.

Read next: `skills.tackles`, the effects of a slide; `control.actions` and `ai.decide`, which steer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import NOBODY
from regista.envs.football.physics.motion import SLIDE
from regista.envs.football.physics.possession import ball_speed, look_ahead, time_needed, time_to_meet, travelled
from regista.envs.football.physics.vectors import apart, length
from regista.kernels.jit import kernel


class Await(NamedTuple):
    """How a player takes an approaching ball when clearly first at it."""

    in_time: float = 1.1  # ratio of the opponents' time to the player's, with `Pull.patience`, that leaves no hurry
    rolling: float = 1.0  # m/s; a slower ball does not approach
    longest: float = 3.0  # s until the ball passes, at most
    choices: int = 2  # intervals between the points compared, from the first reachable to the nearest one
    pace: float = 0.4  # weight of the similarity of the velocity to the desired one
    way: float = 0.6  # weight of the similarity of the direction to the desired one
    nearest: float = 0.1  # weight of the nearest point of the ball's path
    urgency: float = 2.6  # 1/s, velocity per m of distance
    fastest: float = 8.0  # m/s
    stands: float = 1.8  # m/s, below which the player stands


# Documented by Google Research Football; checked against its episodes, continued from the state after each step.
AWAIT = Await()
HUNT_LEAD = 1.2  # s at most by which a carrier's run is extrapolated
ROUND, OVERTAKE = 1.0, 0.4  # m beside an obstructing body, and s ahead of it
SLIDE_KEEPS = 0.9  # share of the run's speed


@kernel
def slide(match, i):
    """Start a slide of player i along the run; nothing happens while the own team has the ball."""
    player = match.players[i]
    if player.down_wait > 0.0 or match.game_mode != 0:
        return
    if match.carrier != NOBODY and match.players[match.carrier].team == player.team:
        return
    speed = SLIDE_KEEPS * length(player.vx, player.vy)
    player.vx, player.vy = speed * player.facing_x, speed * player.facing_y
    player.is_sliding, player.down_wait = True, SLIDE.time


@kernel
def chase(match, i, speed):
    """Desire a velocity of magnitude `speed` to the point where the player meets the ball."""
    player, ball, ahead = match.players[i], match.ball, look_ahead(match.ball)
    share = 0.0
    if ahead.speed > 0.5:
        share = travelled(ahead, time_to_meet(match, i, ahead)) / ahead.speed
    run_to(player, ball.x + share * ball.vx, ball.y + share * ball.vy, speed)


@kernel
def run_to(player, x, y, speed):
    """Desire a velocity to a point, slowing down over the last stride."""
    dx, dy = x - player.x, y - player.y
    distance = math.sqrt(dx * dx + dy * dy)
    if distance < 0.05:
        player.desired_vx, player.desired_vy = 0.0, 0.0
        return
    speed = min(speed, 4.0 * distance + 0.5)
    player.desired_vx, player.desired_vy = dx / distance * speed, dy / distance * speed


@kernel
def go_for_ball(match, i, speed):
    """Run to the expected position of a carrier's ball, around the carrier's body if it is in the way."""
    player, ball = match.players[i], match.ball
    carrier = match.players[match.carrier]
    distance = apart(ball, player)
    time = min(distance / 8.0, HUNT_LEAD)
    x, y = ball.x + time * ball.vx, ball.y + time * ball.vy
    ball_x, ball_y = ball.x - carrier.x, ball.y - carrier.y
    from_x, from_y = player.x - carrier.x, player.y - carrier.y
    if ball_x * from_x + ball_y * from_y < 0.0 and distance < 3.0:
        size = length(from_x, from_y) + 1e-9
        side = ROUND if from_x * ball_y - from_y * ball_x >= 0.0 else -ROUND
        x = carrier.x - side * from_y / size + OVERTAKE * carrier.vx
        y = carrier.y + side * from_x / size + OVERTAKE * carrier.vy
    dx, dy = x - player.x, y - player.y
    size = length(dx, dy) + 1e-9
    player.desired_vx, player.desired_vy = dx / size * speed, dy / size * speed


@kernel
def await_ball(ball, player, time, ux, uy):
    """Meet a ball, reachable in `time` s, at the point that suits the desired velocity and direction (ux, uy) best.

    Return whether the ball approaches.

    The point is between the first reachable one and the nearest one on its path; the player goes there as fast as
    needed.
    """
    speed = ball_speed(ball)
    if speed < AWAIT.rolling:
        return False
    ahead, way_x, way_y = look_ahead(ball), ball.vx / speed, ball.vy / speed
    first, last = travelled(ahead, time), (player.x - ball.x) * way_x + (player.y - ball.y) * way_y
    if last <= first:
        return False
    latest = last / speed
    for _ in range(2):
        latest *= last / travelled(ahead, latest)
    if latest > AWAIT.longest:
        return False
    best = -1.0
    wanted_x, wanted_y = player.desired_vx, player.desired_vy
    for part in range(AWAIT.choices + 1):
        share = part / AWAIT.choices
        way = first + share * (last - first)
        dx, dy = ball.x + way * way_x - player.x, ball.y + way * way_y - player.y
        rating = is_suitable(wanted_x, wanted_y, ux, uy, dx, dy) + AWAIT.nearest * share
        if rating > best:
            best = rating
            distance = length(dx, dy)
            pace = min(time_needed(player, dx, dy) / (time + share * (latest - time)), 1.0) * player.top_speed
            pace = pace / (distance + 1e-9) if pace > AWAIT.stands else 0.0
            player.desired_vx, player.desired_vy = pace * dx, pace * dy
    return True


@kernel
def is_suitable(wanted_x, wanted_y, ux, uy, dx, dy):
    """Rate how well going (dx, dy) m fits the desired velocity, whose direction is (ux, uy)."""
    distance = length(dx, dy) + 1e-9
    pace = min(AWAIT.urgency, AWAIT.fastest / distance)
    like = 1.0 - min(length(wanted_x - pace * dx, wanted_y - pace * dy) / AWAIT.fastest, 1.0)
    angle = math.acos(min(max((ux * dx + uy * dy) / distance, -1.0), 1.0))
    return AWAIT.pace * like + AWAIT.way * (1.0 - min(angle / (0.5 * math.pi), 1.0))
