"""A free ball brought under control: how hard it is, and where the first touch sends it.

Nobody misses a ball that he reaches, but a hard one jumps off him, and goes on as it came if an opponent has only
just kicked it. The law and its numbers are those documented of Google Research Football. Read next: `skills.contacts`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import BUILTIN_AI, DIRECTION_X, DIRECTION_Y, NOBODY, STEP
from regista.envs.football.physics.bodies import PUSH
from regista.envs.football.physics.dribble import push_on
from regista.envs.football.physics.running import READY, START, SURE
from regista.envs.football.physics.vectors import length
from regista.envs.football.skills.touch import take
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform


class Control(NamedTuple):
    """What makes a ball hard to control, and where it goes then.

    The law and its numbers are those documented of Google Research Football; checked by `regista benchmark --suite
    grf`, families passes and matches.
    """

    fast_from: float = 10.0  # m/s relative to the player
    fast_range: float = 40.0  # m/s more
    fast_power: float = 1.5
    fast_weight: float = 5.0
    ahead: float = 0.2  # m ahead of the body, the place from which distance counts
    far_from: float = 0.7  # m from there
    far_range: float = 0.6  # m more
    far_weight: float = 2.0
    far_away_weight: float = 4.0  # of that, in how far the ball jumps
    surprise_time: float = 0.73  # s after an opponent's kick
    surprise_power: float = 0.6
    pushed_weight: float = 4.0  # of who has just been pushed, in how far it jumps; a quarter of it in how high
    surprise_weight: float = 5.0
    surprise_keep: float = 0.1  # of that, in how much the ball goes on as it came
    skill: float = 0.75  # 1 less half of the ball control that players have
    rest: float = 0.38  # m ahead of a standing player, where he wants the ball
    jump_scale: float = 0.215  # m of way to go, into m/s:
    jump_power: float = 0.7
    least_gap: float = 0.2  # m
    lift: float = 4.0  # m/s
    loose: float = 0.5  # a ball that jumps further off than this is anybody's
    slows: float = 0.9  # m/s that taking it along in the run costs where that leads aside, less straight on
    along_pace: float = 1.3  # times his speed after that touch
    along_more: float = 1.5  # m/s and this is the ball's,
    along_most: float = 0.93  # times the speed that he wants at most
    turns: float = 0.5  # share of a run elsewhere that this touch turns;
    back_speed: float = 2.3  # m/s of the ball where the keys lead back,
    back_keeps: float = 0.55  # and the share of his run that he keeps before he turns
    touch_again: float = 0.3  # s until he can play a ball that he has just stopped
    traps_for: float = 0.25  # s in which who stops it with no direction held answers no keys
    lying: float = 0.5  # m/s, a slower ball lies: who stands before it with keys sets off with it,
    set_off: float = 3.0  # m/s, so fast it goes;
    steps_up: float = 0.5  # m/s, who runs to it faster plays it in his stride,
    steps_round: float = -0.6  # cosine of that run to his keys, from where on they do not lead back:
    stride_ball: float = 4.3  # m/s, so fast it goes then;
    pace: float = 0.8  # m/s that he has his keys' way at once,
    pace_turned: float = 1.2  # m/s more, times that cosine,
    pace_kept: float = 0.3  # and so much of his run along them;
    aside_kept: float = 0.8  # of what led aside,
    aside_most: float = 2.9  # m/s of it at most
    stops: float = 0.82  # of his run is left to who runs to it with no direction: he stops with it,
    stops_ball: float = 0.12  # and of that the ball has so much,
    stops_for: float = 0.2  # s in which his keys lead nowhere


class BringDown(NamedTuple):
    """A ball that comes hard: who has keys lets it come to his body and brings it down ahead of his run.

    Fitted to 400 drawn passes of Google Research Football, checked on 60 others (`TRANSFER.md`).
    """

    hard: float = 7.0  # m/s relative to him: such a ball
    nearest: float = 0.3  # m before it is nearest to him, there he plays it,
    meets: float = 0.75  # m from him at most,
    ready: float = 0.12  # s before that, he no longer turns
    gains: float = 2.1  # m/s that he gets his keys' way with it,
    gains_less: float = 0.5  # less for each m/s of his run,
    gains_least: float = 0.5  # but at least
    back_from: float = 2.0  # m/s, a faster run where they lead back;
    back_slow: float = 0.75  # share that is left of a slower one
    back_left: float = 0.45  # share that is left of his run where they lead back,
    back_aside: float = 0.6  # and of what leads aside then,
    back_ball: float = 0.6  # m/s of the ball their way then,
    back_follows: float = 0.3  # and the share of what led aside that it keeps
    aside_left: float = 0.3  # and of what leads aside,
    aside_more: float = 0.09  # more for each m/s of it
    most: float = 4.1  # m/s that he runs on
    ahead: float = 2.4  # m/s more than he the ball has his keys' way,
    ahead_less: float = 0.8  # less for each m/s of his run,
    ahead_least: float = 1.2  # but at least
    rolls: float = 0.4  # s until he plays it again


CONTROL, BRING_DOWN = Control(), BringDown()


@kernel
def difficulty(match, player):
    """Return how hard a ball is to play: how far off it jumps, how high, and how much of its way it keeps, each 0 to
    1.
    """
    ball = match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    away = length(
        ball.x - player.x - CONTROL.ahead * player.facing_x, ball.y - player.y - CONTROL.ahead * player.facing_y
    )
    surprise = CONTROL.surprise_weight * surprised(match, player) ** CONTROL.surprise_power
    pushed = CONTROL.pushed_weight * player.pushed / PUSH.most
    if fast <= CONTROL.fast_from and away <= CONTROL.far_from and surprise == 0.0 and pushed == 0.0:
        return 0.0, 0.0, 0.0
    fast = (
        CONTROL.fast_weight * min(max((fast - CONTROL.fast_from) / CONTROL.fast_range, 0.0), 1.0) ** CONTROL.fast_power
    )
    away = CONTROL.far_weight * min(max((away - CONTROL.far_from) / CONTROL.far_range, 0.0), 1.0) ** 2.0
    skill = (1.0 - (1.0 - CONTROL.skill) * player.skill) * (0.5 + 0.5 * uniform(match))
    far_off = skill * (fast + CONTROL.far_away_weight * away + surprise + pushed)
    high_off = skill * (2.0 * fast + away + surprise + 0.25 * pushed)
    return min(far_off, 1.0), min(high_off, 1.0), skill * min(CONTROL.surprise_keep * surprise, 0.9)


@kernel
def surprised(match, player):
    """Return the share in [0, 1], falling with the time since an opponent's last touch, of what a player can be
    surprised.
    """
    if not match.was_kicked or match.last_touch == NOBODY or match.players[match.last_touch].team == player.team:
        return 0.0
    return max(1.0 - match.kick_age / CONTROL.surprise_time, 0.0)


@kernel
def take_along(ball, player):
    """Play a ball that is easy to control the way that a player's keys lead, in his run: it costs him some pace,
    but not straight on.

    The touch turns him: half of what led aside is gone, and half of his pace at least goes the new way; if that leads
    back he stops first.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    want, speed = length(player.desired_vx, player.desired_vy), length(player.vx, player.vy)
    player.desired_vx, player.desired_vy = want * ux, want * uy
    along = player.vx * ux + player.vy * uy
    keep = max(speed - CONTROL.slows * math.sqrt(max(1.0 - (along / speed) ** 2, 0.0)), 0.0) / max(speed, 1e-9)
    if along < -SURE:
        player.vx, player.vy = CONTROL.back_keeps * player.vx, CONTROL.back_keeps * player.vy
        player.turning = READY
        ball.vx, ball.vy = CONTROL.back_speed * ux, CONTROL.back_speed * uy
        return
    aside_x, aside_y = player.vx - along * ux, player.vy - along * uy
    along = keep * max(along, CONTROL.turns * speed)
    share = keep * (1.0 - CONTROL.turns)
    player.vx, player.vy = along * ux + share * aside_x, along * uy + share * aside_y
    player.turning, player.stride = READY, STEP  # this very moment
    push_on(ball, player, player.vx, player.vy, want)
    fast = min(CONTROL.along_pace * length(player.vx, player.vy) + CONTROL.along_more, CONTROL.along_most * want)
    share = fast / (length(ball.vx, ball.vy) + 1e-9)
    ball.vx, ball.vy = share * ball.vx, share * ball.vy
    player.stride = 0.0


@kernel
def lies(ball):
    """Return whether a ball does not roll."""
    return length(ball.vx, ball.vy) < CONTROL.lying


@kernel
def in_stride(ball, player):
    """Let who runs to a ball that lies, and whose keys lead aside or a little back, play it their way in the same
    stride; return whether he does: where they lead straight back, he turns first.

    It turns him whatever his run was, so that half a step later he goes at 1.5 to 2 m/s their way.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    speed, along = length(player.vx, player.vy), player.vx * ux + player.vy * uy
    if speed < CONTROL.steps_up or along < CONTROL.steps_round * speed or along > -SURE:
        return False
    aside_x, aside_y = player.vx - along * ux, player.vy - along * uy
    share = min(CONTROL.aside_most / (length(aside_x, aside_y) + 1e-9), CONTROL.aside_kept)
    pace = CONTROL.pace + CONTROL.pace_turned * along / speed + CONTROL.pace_kept * along
    player.vx, player.vy = pace * ux + share * aside_x, pace * uy + share * aside_y
    player.turning, player.stride = READY, 0.0
    ball.vx, ball.vy = CONTROL.stride_ball * ux, CONTROL.stride_ball * uy
    return True


@kernel
def comes_hard(ball, player):
    """Return whether a ball is fast, seen by a player."""
    return length(ball.vx - player.vx, ball.vy - player.vy) > BRING_DOWN.hard


@kernel
def still_to_come(ball, player):
    """Return how many s a ball that comes hard is still from where a player plays it; 0 for one that does not."""
    if not comes_hard(ball, player):
        return 0.0
    closing_x, closing_y = player.vx - ball.vx, player.vy - ball.vy
    closing = length(closing_x, closing_y)
    way = (closing_x * (ball.x - player.x) + closing_y * (ball.y - player.y)) / closing
    return max(way - BRING_DOWN.nearest, 0.0) / closing


@kernel
def idles(player):
    """Return whether a player is an agent's and has no direction held."""
    return player.direction == 0 and player.action != BUILTIN_AI


@kernel
def lets_come(ball, player):
    """Return whether a player lets a ball in his reach still come nearer; who stands idly or kicks it does not."""
    kicks = player.kick_ready and player.kick != 0
    return not kicks and not idles(player) and still_to_come(ball, player) > 0.0


@kernel
def is_about_to_play(ball, player):
    """Return whether a ball that comes hard is so near that a player turns no more before he plays it."""
    time = still_to_come(ball, player)
    if time == 0.0 or time > BRING_DOWN.ready:
        return False
    dx = ball.x - player.x + time * (ball.vx - player.vx)
    dy = ball.y - player.y + time * (ball.vy - player.vy)
    return length(dx, dy) < BRING_DOWN.meets


@kernel
def bring_down(ball, player):
    """Play a ball that comes hard a little ahead of a player's run, who goes on much as he ran until he is at it again.

    He keeps what leads his keys' way and gains some, loses most of what leads aside, and is a runner at most then.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    speed, along = length(player.vx, player.vy), player.vx * ux + player.vy * uy
    aside_x, aside_y = player.vx - along * ux, player.vy - along * uy
    player.brings_down, player.touch_wait = True, BRING_DOWN.rolls
    player.turning, player.stance_wait, player.stride = READY, 0.0, 0.0
    if along < -SURE and speed > BRING_DOWN.back_from:
        turn_back(ball, player, along, aside_x, aside_y)
        return
    share = BRING_DOWN.aside_left + BRING_DOWN.aside_more * speed
    aside_x, aside_y = share * aside_x, share * aside_y
    along *= BRING_DOWN.back_slow if along < 0.0 else 1.0
    along += max(BRING_DOWN.gains - BRING_DOWN.gains_less * speed, BRING_DOWN.gains_least)
    vx, vy = along * ux + aside_x, along * uy + aside_y
    keep = min(BRING_DOWN.most / (length(vx, vy) + 1e-9), 1.0)
    player.vx, player.vy = keep * vx, keep * vy
    ahead = max(BRING_DOWN.ahead - BRING_DOWN.ahead_less * speed, BRING_DOWN.ahead_least)
    ball.vx, ball.vy = player.vx + ahead * ux, player.vy + ahead * uy


@kernel
def turn_back(ball, player, along, aside_x, aside_y):
    """Send the ball the way that a player's keys lead, back from his run, of which he keeps a part.

    It led `along` m/s their way, which is negative, and aside.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    ball.vx = BRING_DOWN.back_ball * ux + BRING_DOWN.back_follows * aside_x
    ball.vy = BRING_DOWN.back_ball * uy + BRING_DOWN.back_follows * aside_y
    player.vx = BRING_DOWN.back_left * along * ux + BRING_DOWN.back_aside * aside_x
    player.vy = BRING_DOWN.back_left * along * uy + BRING_DOWN.back_aside * aside_y


@kernel
def stop_with_it(ball, player):
    """Let who runs to a ball that lies, with no direction held, stop with it."""
    player.vx, player.vy = CONTROL.stops * player.vx, CONTROL.stops * player.vy
    player.turning, player.stance_wait = 0, CONTROL.stops_for
    ball.vx, ball.vy = CONTROL.stops_ball * player.vx, CONTROL.stops_ball * player.vy
    player.touch_wait = CONTROL.touch_again


@kernel
def drop(ball, player, far_off):
    """Return the velocity of a ball that is to lie at a player's feet, or so far off as it jumps, 0 to 1."""
    to_x = player.x + (CONTROL.rest + far_off) * player.facing_x - ball.x
    to_y = player.y + (CONTROL.rest + far_off) * player.facing_y - ball.y
    gap = length(to_x, to_y) + 1e-9
    push = (max(gap, CONTROL.least_gap) / CONTROL.jump_scale) ** CONTROL.jump_power / gap
    return player.vx + push * to_x, player.vy + push * to_y


@kernel
def cushion(match, i):
    """Let player i stop a free ball: it drops at his feet, or jumps off him as hard as it is to control."""
    player, ball = match.players[i], match.ball
    far_off, high_off, kept = difficulty(match, player)
    vx, vy, vz, z = ball.vx, ball.vy, ball.vz, ball.z
    rests, has_keys = lies(ball), player.direction > 0 and player.kick == 0
    is_hard, was_played = comes_hard(ball, player), match.last_touch != NOBODY
    take(match, i)
    if match.carrier != i:
        return
    if rests and has_keys and in_stride(ball, player):
        return
    if is_hard and has_keys and not rests and far_off < CONTROL.loose:
        bring_down(ball, player)
        ball.z, ball.vz = z, high_off * (vz + CONTROL.lift)
        return
    runs = length(player.vx, player.vy) > START.jump
    if runs and far_off == 0.0 and high_off == 0.0 and has_keys:
        take_along(ball, player)
        return
    if not runs and has_keys and rests:
        ball.vx = CONTROL.set_off * DIRECTION_X[player.direction]
        ball.vy = CONTROL.set_off * DIRECTION_Y[player.direction]
        return
    if runs and rests and idles(player) and player.kick == 0:
        stop_with_it(ball, player)
        return
    to_vx, to_vy = drop(ball, player, far_off)
    ball.vx, ball.vy = (1.0 - kept) * to_vx + kept * vx, (1.0 - kept) * to_vy + kept * vy
    if far_off > CONTROL.loose:
        match.carrier = NOBODY
    ball.z, ball.vz = z, (1.0 - kept) * high_off * (vz + CONTROL.lift) + kept * vz
    player.touch_wait = CONTROL.touch_again
    if was_played and idles(player):
        player.brings_down, player.stance_wait = True, CONTROL.traps_for
