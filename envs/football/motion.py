"""How players run: from the velocity a command asks for to the velocity of one step.

A body answers late (it finishes the stride), brakes hard across and against the new direction, and gathers
speed along it; with the ball at the feet everything is gentler, and a sprint turns only in a wide arc. The
numbers are fitted to traces of Google Research Football. Read next: `physics`.
"""

from __future__ import annotations

import math

from envs.football.constants import APRON, BODY_RADIUS, DT, HALF_LENGTH, HALF_WIDTH, LEFT, NOBODY, RUN_SPEED, STEP
from envs.football.vectors import toward
from scenic_lite.jit import kernel

SETTLED = 0.2  # m/s, command and velocity this close are the same
AT_REST = 0.3  # m/s
# Share of full effort in the steps since command and velocity differ: the body's lag.
LAG_FROM_REST = (0.0, 1.0, 1.0, 1.0)
LAG_RUNNING = (0.0, 0.0, 0.25, 1.0)
LAG_SPRINTING = (0.0, 0.15, 0.75, 1.0)
LAG_WITH_BALL = (0.4, 0.6, 0.8, 1.0)
LAG_SPRINTING_WITH_BALL = (0.0, 0.1, 0.5, 1.0)
SPRINTING = 6.0  # m/s
BRAKING = 30.0  # m/s²
BRAKING_WITH_BALL, STOPPING_WITH_BALL = 11.5, 14.0
ACCELERATION_START, START_SPEED = 13.3, 2.6  # m/s² up to this speed in m/s
ACCELERATION = 8.2  # m/s² from there to RUN_SPEED
ACCELERATION_SPRINT, ACCELERATION_TIME = 5.0, 0.47  # m/s² and s, from there on: approach to top speed
ARC = 0.5 * STEP  # rad turned in a step when sprinting with the ball
ARC_COS, ARC_SIN = math.cos(ARC), math.sin(ARC)
TURN = 0.4  # rad turned in a step on the spot
TURN_COS, TURN_SIN = math.cos(TURN), math.sin(TURN)
ARC_SPEED = 5.5  # m/s, slower players turn on the spot
SLIDE_TIME, SLIDE_GLIDE = 1.8, 1.4  # s on the ground; he glides until this much of it is left
SLIDE_FRICTION = 14.0  # m/s²
FALL_FRICTION = 9.0  # m/s² for a keeper who has dived
TIRING = 6.3e-4  # per metre run
TIRED_OUT = 0.99
SAME_PLACE = 1e-3  # m between bodies that were in the same place
BODIES_NEAR = 2.6  # m, pairs further apart than this cannot meet within a step


@kernel
def plan_motion(match, i):
    """Set player i's velocity for this step, and where he looks."""
    player = match.players[i]
    speed = math.sqrt(player.vx * player.vx + player.vy * player.vy)
    if player.down > 0.0:
        vx, vy = slowed(player, speed)
    elif match.saver == i:
        vx, vy = thrown(player)
    else:
        vx, vy = pursued(match, i, speed)
    player.vx, player.vy = vx, vy
    player.tired = min(player.tired + TIRING * speed * STEP, TIRED_OUT)
    new_speed = math.sqrt(vx * vx + vy * vy)
    if new_speed > AT_REST and player.kick_wait <= 0.0:
        player.facing_x, player.facing_y = vx / new_speed, vy / new_speed
    elif match.carrier == i and player.kick == 0:
        turn_to_goal(player)


@kernel
def turn_to_goal(player):
    """Turn the body of a player who stands with the ball some way towards the goal that he attacks."""
    goal_x = HALF_LENGTH if player.team == LEFT else -HALF_LENGTH
    ux, uy = toward(goal_x - player.x, -player.y)
    if player.facing_x * ux + player.facing_y * uy >= TURN_COS:
        player.facing_x, player.facing_y = ux, uy
        return
    sine = TURN_SIN if player.facing_x * uy - player.facing_y * ux >= 0.0 else -TURN_SIN
    x, y = player.facing_x, player.facing_y
    player.facing_x, player.facing_y = x * TURN_COS - y * sine, x * sine + y * TURN_COS


@kernel
def slowed(player, speed):
    """Velocity after a step on the ground, in a slide or after a dive."""
    player.turning = 0
    if speed < 1e-6:
        return 0.0, 0.0
    if player.sliding and player.down > SLIDE_GLIDE:
        loss = 0.0
    else:
        loss = (SLIDE_FRICTION if player.sliding else FALL_FRICTION) * STEP
    keep = max(speed - loss, 0.0) / speed
    return player.vx * keep, player.vy * keep


@kernel
def thrown(player):
    """Velocity after a step of a keeper who throws himself where he wants to be: no lag, double effort."""
    dx, dy = player.want_x - player.vx, player.want_y - player.vy
    size = math.sqrt(dx * dx + dy * dy)
    keep = min(1.0, 2.0 * BRAKING * STEP / size) if size > 0.0 else 1.0
    return player.vx + keep * dx, player.vy + keep * dy


@kernel
def pursued(match, i, speed):
    """Velocity after a step of ordinary running towards the wanted velocity."""
    player = match.players[i]
    dx, dy = player.want_x - player.vx, player.want_y - player.vy
    if dx * dx + dy * dy < SETTLED * SETTLED:
        player.turning = 0
        return player.want_x, player.want_y
    with_ball = match.carrier == i and match.holder == NOBODY
    effort = effort_now(player.turning, speed, with_ball)
    player.turning += 1
    if effort == 0.0:
        return player.vx, player.vy
    want = math.sqrt(player.want_x * player.want_x + player.want_y * player.want_y)
    if with_ball and speed > ARC_SPEED and want > ARC_SPEED:
        along = player.vx * player.want_x + player.vy * player.want_y
        if along > -0.2 * speed * want:
            return arc(player, speed, want, along / (speed * want))
    braking = (BRAKING_WITH_BALL if with_ball else BRAKING) * effort * STEP
    if want < 1e-6:
        if with_ball and speed < SPRINTING:
            braking = STOPPING_WITH_BALL * STEP
        keep = max(speed - braking, 0.0) / speed
        return player.vx * keep, player.vy * keep
    return redirect(player, want, braking, effort)


@kernel
def effort_now(steps, speed, with_ball):
    """Share of full effort after so many steps of turning."""
    steps = min(steps, 3)
    if speed < START_SPEED:
        return LAG_FROM_REST[steps]
    if with_ball:
        return LAG_SPRINTING_WITH_BALL[steps] if speed > SPRINTING else LAG_WITH_BALL[steps]
    return LAG_SPRINTING[steps] if speed > SPRINTING else LAG_RUNNING[steps]


@kernel
def redirect(player, want, braking, effort):
    """Gather speed along the wanted direction while braking what is across or against it."""
    ux, uy = player.want_x / want, player.want_y / want
    along = player.vx * ux + player.vy * uy
    across_x, across_y = player.vx - along * ux, player.vy - along * uy
    across = math.sqrt(across_x * across_x + across_y * across_y)
    keep = max(across - braking, 0.0) / across if across > 1e-9 else 0.0
    if along < -1e-6:
        along = min(along + braking, 0.0)
    elif along < want:
        along = min(along + acceleration(along, player.top_speed) * effort * effort * STEP, want)
    else:
        along = max(along - braking, want)
    return along * ux + across_x * keep, along * uy + across_y * keep


@kernel
def acceleration(speed, top_speed):
    """Acceleration in m/s² of a player who runs straight as hard as he can."""
    if speed < START_SPEED:
        return ACCELERATION_START
    if speed < RUN_SPEED:
        return ACCELERATION
    return min(ACCELERATION_SPRINT, max(top_speed - speed, 0.0) / ACCELERATION_TIME)


@kernel
def arc(player, speed, want, cosine):
    """Velocity after a step of a sprint with the ball: a wide arc at little loss of speed."""
    change = acceleration(speed, player.top_speed) * STEP if speed < want else -BRAKING_WITH_BALL * STEP
    new = min(speed + change, want) if speed < want else max(speed + change, want)
    if cosine >= ARC_COS:
        return player.want_x / want * new, player.want_y / want * new
    turn = player.vx * player.want_y - player.vy * player.want_x
    sine = ARC_SIN if turn >= 0.0 else -ARC_SIN
    vx = (player.vx * ARC_COS - player.vy * sine) / speed
    vy = (player.vx * sine + player.vy * ARC_COS) / speed
    return vx * new, vy * new


@kernel
def advance_player(player):
    """Move a player on by one frame of 10 ms."""
    player.x += player.vx * DT
    player.y += player.vy * DT


@kernel
def keep_on_pitch(player):
    """Stop a player at the edge of the grass, a little beyond the lines."""
    if player.off:
        return
    if abs(player.x) > HALF_LENGTH + APRON:
        player.x = math.copysign(HALF_LENGTH + APRON, player.x)
        player.vx = 0.0
    if abs(player.y) > HALF_WIDTH + APRON:
        player.y = math.copysign(HALF_WIDTH + APRON, player.y)
        player.vy = 0.0


@kernel
def crowded(match):
    """Tell whether any two players could meet within this step."""
    for i in range(1, match.num_players):
        a = match.players[i]
        for j in range(i):
            b = match.players[j]
            if abs(a.x - b.x) < BODIES_NEAR and abs(a.y - b.y) < BODIES_NEAR:
                return True
    return False


@kernel
def part_bodies(match):
    """Push overlapping players apart and take away the speed with which they close in.

    Who runs faster gives way more, so that nobody is shoved about the pitch; one can jump over who lies down.
    """
    for i in range(1, match.num_players):
        a = match.players[i]
        for j in range(i):
            b = match.players[j]
            dx, dy = a.x - b.x, a.y - b.y
            squared = dx * dx + dy * dy
            if squared < 4.0 * BODY_RADIUS * BODY_RADIUS and a.down <= 0.0 and b.down <= 0.0:
                if squared == 0.0:  # one steps back towards his goal
                    dx, squared = -SAME_PLACE if a.team == LEFT else SAME_PLACE, SAME_PLACE * SAME_PLACE
                part(a, b, dx, dy, math.sqrt(squared))


@kernel
def part(a, b, dx, dy, distance):
    """Part two overlapping bodies; (dx, dy) leads from b to a."""
    nx, ny = dx / distance, dy / distance
    toward_b, toward_a = a.vx * nx + a.vy * ny, b.vx * nx + b.vy * ny  # only these, or energy could be gained
    energy_a, energy_b = toward_b * toward_b + 1e-9, toward_a * toward_a + 1e-9
    share = energy_a / (energy_a + energy_b)
    push = 2.0 * BODY_RADIUS - distance
    a.x += share * push * nx
    a.y += share * push * ny
    b.x -= (1.0 - share) * push * nx
    b.y -= (1.0 - share) * push * ny
    closing = (a.vx - b.vx) * nx + (a.vy - b.vy) * ny
    if closing < 0.0:
        a.vx -= share * closing * nx
        a.vy -= share * closing * ny
        b.vx += (1.0 - share) * closing * nx
        b.vy += (1.0 - share) * closing * ny
