"""First touches: how hard a free ball is to control, and where the touch sends it.

No player misses a ball in reach. A ball that is hard to control bounces off, and keeps its direction if an opponent has
just kicked it. The law and its numbers are documented by Google Research Football. Read next: `skills.contacts`.
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
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Difficulty(NamedTuple):
    """The difficulty of controlling a free ball: speed, distance, surprise and pushes, each with a weight.

    Law and numbers are documented by Google Research Football and checked by `lab.benchmarks --suite grf`,
    families passes and matches.
    """

    speed_from: float = 10.0  # m/s relative to the player, up to which a ball is easy
    speed_range: float = 40.0  # m/s more, at which it is hardest
    speed_power: float = 1.5
    speed_weight: float = 5.0  # weight in the distance of the bounce
    speed_weight_high: float = 2.0  # factor of this weight in the height of the bounce
    ahead: float = 0.2  # m ahead of the body, from where the distance to the ball is measured
    distance_from: float = 0.7  # m, up to which a ball is easy
    distance_range: float = 0.6  # m more, at which it is hardest
    distance_weight: float = 2.0  # weight in the height of the bounce
    distance_weight_far: float = 4.0  # factor of this weight in the distance of the bounce
    surprise_time: float = 0.73  # s after an opponent's kick, in which surprise fades
    surprise_power: float = 0.6
    surprise_weight: float = 5.0
    surprise_kept: float = 0.1  # share of its velocity that the ball keeps, per unit of surprise
    push_weight: float = 4.0  # weight of the hardest push in the distance of the bounce
    push_weight_high: float = 0.25  # factor of this weight in the height of the bounce
    skill: float = 0.75  # difficulty left at skill 1: 1 minus half of the players' ball control


class Drop(NamedTuple):
    """A stopped ball drops at the feet, or bounces off by its difficulty; as documented."""

    rest: float = 0.38  # m ahead of the body, the ball's target
    jump_scale: float = 0.215  # m to the target, at which the ball has 1 m/s,
    jump_power: float = 0.7  # and exponent of the distance
    least_gap: float = 0.2  # m
    lift: float = 4.0  # m/s upwards, of the hardest ball
    loose: float = 0.5  # difficulty above which the ball is free
    touch_again: float = 0.3  # s until the player can touch it again
    traps_for: float = 0.25  # s in which a player with no direction held ignores a new direction


class TakeAlong(NamedTuple):
    """An easy ball is played in the held direction without breaking the run."""

    slows: float = 0.9  # m/s of the run lost in a touch at a right angle; otherwise times the sine of the angle
    turns: float = 0.5  # share of the lateral run that the touch removes
    pace: float = 1.3  # factor of the player's speed after the touch in the ball's speed,
    more: float = 1.5  # m/s, added to it
    most: float = 0.93  # maximum of it, as a share of the desired speed
    back_speed: float = 2.3  # m/s of the ball, if the held direction leads back
    back_keeps: float = 0.55  # share of the run that the player then keeps


class AtRest(NamedTuple):
    """A ball at rest: a standing start with it, a touch within a stride, or a stop."""

    below: float = 0.5  # m/s; slower balls are at rest
    set_off: float = 3.0  # m/s of the ball at a standing start
    stride_from: float = 0.5  # m/s; faster players play the ball within their stride,
    stride_cosine: float = -0.6  # unless the cosine between run and held direction is below this
    stride_ball: float = 4.3  # m/s of the ball in this case
    pace: float = 0.8  # m/s of the player in the held direction, in this case,
    pace_turned: float = 1.2  # m/s added to it, times that cosine, which is negative,
    pace_kept: float = 0.3  # and this share of the run in that direction
    aside_kept: float = 0.8  # share of the lateral run that the player keeps
    aside_most: float = 2.9  # m/s of it, at most
    stops: float = 0.82  # share of the run left to a player with no direction held, who stops with the ball
    stops_ball: float = 0.12  # share of that run which the ball gets
    stops_for: float = 0.2  # s in which a new direction has no effect after such a stop


class BringDown(NamedTuple):
    """A ball that comes hard: with a held direction, the player lets it come and brings it down ahead of the run.

    Fitted to 400 drawn passes of Google Research Football, checked on 60 others.
    """

    hard: float = 7.0  # m/s relative to the player, of a hard ball
    nearest: float = 0.3  # m before its nearest point, where the ball is played
    meets: float = 0.75  # m from the player to that point, at most
    ready: float = 0.12  # s before that, in which the player no longer turns
    gains: float = 2.1  # m/s gained in the held direction,
    gains_less: float = 0.5  # less this per m/s of the run,
    gains_least: float = 0.5  # but at least
    back_from: float = 2.0  # m/s; a faster run is turned back if the held direction leads back
    back_slow: float = 0.75  # share of a slower run that is left
    back_left: float = 0.45  # share of the run left, when turned back
    back_aside: float = 0.6  # share of the lateral run left, when turned back
    back_ball: float = 0.6  # m/s of the ball in the held direction, when turned back
    back_follows: float = 0.3  # share of the lateral run that the ball then gets
    aside_left: float = 0.3  # share of the lateral run left otherwise,
    aside_more: float = 0.09  # and this more per m/s of the run
    most: float = 4.1  # m/s of the run, at most
    ahead: float = 2.4  # m/s by which the ball is faster in the held direction,
    ahead_less: float = 0.8  # less this per m/s of the run,
    ahead_least: float = 1.2  # but at least
    rolls: float = 0.4  # s until the ball is played again


HARD, DROP, ALONG = Difficulty(), Drop(), TakeAlong()
AT_REST, BRING_DOWN = AtRest(), BringDown()


@kernel
def difficulty(match, player):
    """Return the difficulty of a ball: how far and how high it bounces, and how much velocity it keeps, in [0, 1]."""
    ball = match.ball
    fast = length(ball.vx - player.vx, ball.vy - player.vy)
    away = length(ball.x - player.x - HARD.ahead * player.facing_x, ball.y - player.y - HARD.ahead * player.facing_y)
    surprise = HARD.surprise_weight * surprised(match, player) ** HARD.surprise_power
    pushed = HARD.push_weight * player.pushed / PUSH.most
    if fast <= HARD.speed_from and away <= HARD.distance_from and surprise == 0.0 and pushed == 0.0:
        return 0.0, 0.0, 0.0
    fast = HARD.speed_weight * min(max((fast - HARD.speed_from) / HARD.speed_range, 0.0), 1.0) ** HARD.speed_power
    away = HARD.distance_weight * min(max((away - HARD.distance_from) / HARD.distance_range, 0.0), 1.0) ** 2.0
    skill = (1.0 - (1.0 - HARD.skill) * player.skill) * (0.5 + 0.5 * uniform(match))
    far_off = skill * (fast + HARD.distance_weight_far * away + surprise + pushed)
    high_off = skill * (HARD.speed_weight_high * fast + away + surprise + HARD.push_weight_high * pushed)
    return min(far_off, 1.0), min(high_off, 1.0), skill * min(HARD.surprise_kept * surprise, 0.9)


@kernel
def surprised(match, player):
    """Return a player's possible surprise in [0, 1]; it fades after an opponent's last touch."""
    if not match.was_kicked or match.last_touch == NOBODY or match.players[match.last_touch].team == player.team:
        return 0.0
    return max(1.0 - match.kick_age / HARD.surprise_time, 0.0)


@kernel
def take_along(ball, player):
    """Play an easy ball in the held direction without breaking the run; a change of direction costs some speed.

    The touch turns the player: half of the lateral run is lost, and at least half of the speed goes in the new
    direction. If that leads back, a stop comes first.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    want, speed = length(player.desired_vx, player.desired_vy), length(player.vx, player.vy)
    player.desired_vx, player.desired_vy = want * ux, want * uy
    along = player.vx * ux + player.vy * uy
    keep = max(speed - ALONG.slows * math.sqrt(max(1.0 - (along / speed) ** 2, 0.0)), 0.0) / max(speed, 1e-9)
    if along < -SURE:
        player.vx, player.vy = ALONG.back_keeps * player.vx, ALONG.back_keeps * player.vy
        player.turning = READY
        ball.vx, ball.vy = ALONG.back_speed * ux, ALONG.back_speed * uy
        return
    aside_x, aside_y = player.vx - along * ux, player.vy - along * uy
    along = keep * max(along, ALONG.turns * speed)
    share = keep * (1.0 - ALONG.turns)
    player.vx, player.vy = along * ux + share * aside_x, along * uy + share * aside_y
    player.turning, player.stride = READY, STEP  # immediately
    push_on(ball, player, player.vx, player.vy, want)
    fast = min(ALONG.pace * length(player.vx, player.vy) + ALONG.more, ALONG.most * want)
    share = fast / (length(ball.vx, ball.vy) + 1e-9)
    ball.vx, ball.vy = share * ball.vx, share * ball.vy
    player.stride = 0.0


@kernel
def is_at_rest(ball):
    """Return whether a ball is at rest."""
    return length(ball.vx, ball.vy) < AT_REST.below


@kernel
def in_stride(ball, player):
    """Let a runner play a ball at rest aside or slightly back within the stride; return whether it is played.

    If the held direction leads straight back, the player turns first. The touch turns the player independent of the
    run: half a step later the player moves at 1.5 to 2 m/s in the held direction.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    speed, along = length(player.vx, player.vy), player.vx * ux + player.vy * uy
    if speed < AT_REST.stride_from or along < AT_REST.stride_cosine * speed or along > -SURE:
        return False
    aside_x, aside_y = player.vx - along * ux, player.vy - along * uy
    share = min(AT_REST.aside_most / (length(aside_x, aside_y) + 1e-9), AT_REST.aside_kept)
    pace = AT_REST.pace + AT_REST.pace_turned * along / speed + AT_REST.pace_kept * along
    player.vx, player.vy = pace * ux + share * aside_x, pace * uy + share * aside_y
    player.turning, player.stride = READY, 0.0
    ball.vx, ball.vy = AT_REST.stride_ball * ux, AT_REST.stride_ball * uy
    return True


@kernel
def comes_hard(ball, player):
    """Return whether a ball is fast relative to a player."""
    return length(ball.vx - player.vx, ball.vy - player.vy) > BRING_DOWN.hard


@kernel
def still_to_come(ball, player):
    """Return the time in s until a player plays a ball that comes hard; 0 for a slower ball."""
    if not comes_hard(ball, player):
        return 0.0
    closing_x, closing_y = player.vx - ball.vx, player.vy - ball.vy
    closing = length(closing_x, closing_y)
    way = (closing_x * (ball.x - player.x) + closing_y * (ball.y - player.y)) / closing
    return max(way - BRING_DOWN.nearest, 0.0) / closing


@kernel
def idles(player):
    """Return whether a player is moved by an agent that holds no direction."""
    return player.direction == 0 and player.action != BUILTIN_AI


@kernel
def lets_come(ball, player):
    """Return whether a player waits for a ball in reach to come nearer; an idle player or a kicker does not."""
    kicks = player.kick_ready and player.kick != 0
    return not kicks and not idles(player) and still_to_come(ball, player) > 0.0


@kernel
def is_about_to_play(ball, player):
    """Return whether a ball that comes hard is so near that the player no longer turns before playing it."""
    time = still_to_come(ball, player)
    if time == 0.0 or time > BRING_DOWN.ready:
        return False
    dx = ball.x - player.x + time * (ball.vx - player.vx)
    dy = ball.y - player.y + time * (ball.vy - player.vy)
    return length(dx, dy) < BRING_DOWN.meets


@kernel
def bring_down(ball, player):
    """Play a ball that comes hard a little ahead of the run, which hardly changes until the next touch.

    The player keeps the run in the held direction and gains some speed, loses most of the lateral run, and is limited
    to running speed.
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
    """Play the ball back in the held direction, against the run; the player keeps a part of the run.

    The run has the component `along` in m/s in the held direction, which is negative, and (aside_x, aside_y) across it.
    """
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    ball.vx = BRING_DOWN.back_ball * ux + BRING_DOWN.back_follows * aside_x
    ball.vy = BRING_DOWN.back_ball * uy + BRING_DOWN.back_follows * aside_y
    player.vx = BRING_DOWN.back_left * along * ux + BRING_DOWN.back_aside * aside_x
    player.vy = BRING_DOWN.back_left * along * uy + BRING_DOWN.back_aside * aside_y


@kernel
def stop_with_it(ball, player):
    """Let a runner with no direction held stop with a ball at rest."""
    player.vx, player.vy = AT_REST.stops * player.vx, AT_REST.stops * player.vy
    player.turning, player.stance_wait = 0, AT_REST.stops_for
    ball.vx, ball.vy = AT_REST.stops_ball * player.vx, AT_REST.stops_ball * player.vy
    player.touch_wait = DROP.touch_again


@kernel
def drop(ball, player, far_off):
    """Return the velocity of a stopped ball, which drops at the player's feet or bounces off by `far_off`, 0 to 1."""
    to_x = player.x + (DROP.rest + far_off) * player.facing_x - ball.x
    to_y = player.y + (DROP.rest + far_off) * player.facing_y - ball.y
    gap = length(to_x, to_y) + 1e-9
    push = (max(gap, DROP.least_gap) / DROP.jump_scale) ** DROP.jump_power / gap
    return player.vx + push * to_x, player.vy + push * to_y


@kernel
def cushion(match, i):
    """Let player i stop a free ball: it drops at the feet, or bounces off by its difficulty."""
    player, ball = match.players[i], match.ball
    far_off, high_off, kept = difficulty(match, player)
    vx, vy, vz, z = ball.vx, ball.vy, ball.vz, ball.z
    rests, has_direction = is_at_rest(ball), player.direction > 0 and player.kick == 0
    is_hard, was_played = comes_hard(ball, player), match.last_touch != NOBODY
    take(match, i)
    if match.carrier != i:
        return
    if rests and has_direction and in_stride(ball, player):
        return
    if is_hard and has_direction and not rests and far_off < DROP.loose:
        bring_down(ball, player)
        ball.z, ball.vz = z, high_off * (vz + DROP.lift)
        return
    runs = length(player.vx, player.vy) > START.jump
    if runs and far_off == 0.0 and high_off == 0.0 and has_direction:
        take_along(ball, player)
        return
    if not runs and has_direction and rests:
        ball.vx = AT_REST.set_off * DIRECTION_X[player.direction]
        ball.vy = AT_REST.set_off * DIRECTION_Y[player.direction]
        return
    if runs and rests and idles(player) and player.kick == 0:
        stop_with_it(ball, player)
        return
    to_vx, to_vy = drop(ball, player, far_off)
    ball.vx, ball.vy = (1.0 - kept) * to_vx + kept * vx, (1.0 - kept) * to_vy + kept * vy
    if far_off > DROP.loose:
        match.carrier = NOBODY
    ball.z, ball.vz = z, (1.0 - kept) * high_off * (vz + DROP.lift) + kept * vz
    player.touch_wait = DROP.touch_again
    if was_played and idles(player):
        player.brings_down, player.stance_wait = True, DROP.traps_for
