"""Set pieces: the taker of a restart decides, runs up, and kicks, throws or shoots; then play continues.

A restart is visible for the same number of steps as in Google Research Football: 2 or 3 at a throw-in, 5 or 6 at a goal
kick, corner or free kick, 6 or 7 at a penalty. This includes the step in which play stopped. An agent's taker waits for
a pass or a shot of the agent; after 20 steps the AI passes. Meanwhile all other players stand. Read next:
`rules.restarts`, which places the players.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    BUILTIN_AI,
    CORNER,
    FREE_KICK,
    GOAL_KICK,
    HIGH_PASS,
    NOBODY,
    NORMAL,
    PENALTY,
    RUN_SPEED,
    SHORT_PASS,
    SHOT,
    STEP,
    THROW_IN,
)
from regista.envs.football.control.actions import is_kick, release_sticky_actions, update_sticky_actions
from regista.envs.football.physics.pitch import attacked_goal_x, forward
from regista.envs.football.physics.possession import forget_kick, lose_ball
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.rules.offside import mark_offside
from regista.envs.football.rules.whistle import look_at
from regista.envs.football.skills.kicks import AFTER_KICK, aim, leave_foot
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Taker(NamedTuple):
    """How long a restart takes, and how its taker runs up."""

    quicker: float = 0.4  # probability that the built-in taker is one step quicker
    patience: int = 20  # steps that an agent's taker waits
    line_wait: float = 0.4  # s after a set piece in which side lines are ignored
    at_ball: float = 0.5  # m from taker to ball at the time of the kick


class Throw(NamedTuple):
    """A throw-in."""

    height: float = 2.0  # m
    least: float = 10.8  # m/s
    gain: float = 0.42  # m/s per m to the receiver
    most: float = 17.2  # m/s
    lift: float = 2.4  # m/s upwards
    lob_lift: float = 4.2  # m/s upwards, of a high throw


class Choice(NamedTuple):
    """Choices of the built-in taker."""

    shot_range: float = 28.0  # m from a free kick to the goal, at most, for a shot; and less than 45° off its middle
    corner: float = 3.0  # m from the middle of the goal to the target
    crowded: float = 2.0  # m to the nearest opponent, for the worst receiver
    free: float = 10.0  # m, for the best receiver
    gain: float = 0.01  # rating per m up the pitch
    throw_far: float = 25.0  # m, maximum distance of the receiver of a throw-in
    pass_far: float = 60.0  # m, maximum distance of other receivers
    high_from: float = 24.0  # m; passes to further receivers are high


# Timing is counted in GRF's matches, the choice is documented by GRF: `lab.benchmarks --suite grf`, family matches.
SHOWN = (0, 0, 6, 6, 6, 3, 7)  # maximum number of steps for which a restart is shown, by mode
TAKER, THROW, CHOICE = Taker(), Throw(), Choice()


@kernel
def wait_for_restart(match):
    """Spend a step of a restart: the taker decides, runs up, and in the last step kicks.

    Return whether play is still stopped.
    """
    taker = match.taker
    if taker == NOBODY:
        return False
    match.restart_wait += 1
    for i in range(match.num_players):
        if match.players[i].action == BUILTIN_AI:
            release_sticky_actions(match, i)
        else:
            update_sticky_actions(match.players[i], match.players[i].action)
    decide_restart(match, taker)
    if match.restart_kick == NOBODY:
        return True
    match.restart_kick -= 1
    if match.restart_kick > 0:
        approach(match, taker)
        return True
    put_in_play(match, taker)
    return False


@kernel
def decide_restart(match, taker):
    """Let the taker choose a kick: the built-in AI at once, an agent by its action, or the AI after a while."""
    player = match.players[taker]
    if player.action == BUILTIN_AI:
        if match.restart_kick == NOBODY:
            choose_kick(match, taker)
            quick = 1 if uniform(match) < TAKER.quicker else 0
            match.restart_kick = SHOWN[match.game_mode] - quick
    elif is_kick(player.action):
        if player.kick == player.action:
            player.kick_held += 1
        else:
            player.kick, player.kick_held, player.is_aimed = player.action, 1, False
        if match.restart_kick == NOBODY:
            match.restart_kick = SHOWN[match.game_mode]
    elif match.restart_kick == NOBODY and match.restart_wait > TAKER.patience:
        player.kick, player.kick_held, player.is_aimed = SHORT_PASS, 1, False
        match.restart_kick = SHOWN[match.game_mode]


@kernel
def approach(match, taker):
    """Let the taker run up and reach the ball at the time of the kick."""
    player, ball = match.players[taker], match.ball
    dx, dy = toward(ball.x - player.x, ball.y - player.y)
    speed = min(max(apart(ball, player) - TAKER.at_ball, 0.0) / (STEP * match.restart_kick), RUN_SPEED)
    player.vx, player.vy = speed * dx, speed * dy


@kernel
def put_in_play(match, taker):
    """Kick or throw the ball: play continues, and for a moment the side lines are ignored."""
    player, mode = match.players[taker], match.game_mode
    match.game_mode, match.restart_team, match.taker = NORMAL, NOBODY, NOBODY
    match.line_wait = TAKER.line_wait
    if not player.is_aimed:
        aim(match, taker)
    if mode == THROW_IN:
        throw(match, taker)
    else:
        leave_foot(match, taker, 1.0)
    if mode not in (THROW_IN, CORNER):  # without offside
        mark_offside(match, taker)


@kernel
def throw(match, i):
    """Throw the ball to player i's target, up to the maximum range of a throw."""
    player, ball = match.players[i], match.ball
    ux, uy = toward(player.aim_x - ball.x, player.aim_y - ball.y)
    distance = length(player.aim_x - ball.x, player.aim_y - ball.y)
    speed = min(THROW.least + THROW.gain * distance, THROW.most)
    ball.vx, ball.vy, ball.z = speed * ux, speed * uy, THROW.height
    ball.vz = THROW.lob_lift if player.kick in (HIGH_PASS, SHOT) else THROW.lift
    ball.spin_x, ball.spin_y = 0.0, 0.0
    look_at(player, player.aim_x, player.aim_y)
    match.receiver = player.kick_mate
    forget_kick(player)
    lose_ball(match)
    player.touch_wait = AFTER_KICK
    match.last_touch, match.was_kicked, match.kick_age = i, True, 0.0


@kernel
def choose_kick(match, taker):
    """Decide for the built-in taker: a shot at a penalty or from a good free kick, else a pass to the best teammate."""
    player, ball = match.players[taker], match.ball
    goal_x = attacked_goal_x(player.team)
    mode = match.game_mode
    if mode == PENALTY or (mode == FREE_KICK and in_shooting_place(goal_x - ball.x, ball.y)):
        player.kick = SHOT
        left = math.copysign(CHOICE.corner, goal_x)  # as the player sees it: rotated with the pitch
        player.aim_x, player.aim_y = goal_x, left if uniform(match) < 0.5 else -left
    else:
        mate = best_mate(match, taker, CHOICE.throw_far if mode == THROW_IN else CHOICE.pass_far)
        if mate == NOBODY:
            player.aim_x, player.aim_y = 0.5 * (ball.x + goal_x), 0.5 * ball.y
        else:
            player.aim_x, player.aim_y = match.players[mate].x, match.players[mate].y
        far = length(player.aim_x - ball.x, player.aim_y - ball.y) > CHOICE.high_from
        player.kick = HIGH_PASS if mode in (GOAL_KICK, CORNER, THROW_IN) or far else SHORT_PASS
        player.kick_mate = mate
    player.kick_held, player.kick_ready, player.is_aimed = 1, True, True


@kernel
def in_shooting_place(dx, y):
    """Return whether a free kick dx m in front of the goal line is near and central enough for a shot."""
    return length(dx, y) < CHOICE.shot_range and abs(y) < abs(dx)


@kernel
def best_mate(match, taker, farthest):
    """Return the teammate with the most room and the most ground gained, -1 if none is in reach."""
    team = match.players[taker].team
    ahead = forward(team)
    best, best_rating = NOBODY, -math.inf
    for j in range(match.num_players):
        mate = match.players[j]
        if j == taker or mate.team != team or mate.has_left or apart(match.ball, mate) > farthest:
            continue
        room = math.inf
        for k in range(match.num_players):
            if match.players[k].team != team:
                room = min(room, apart(match.players[k], mate))
        rating = min(max((room - CHOICE.crowded) / (CHOICE.free - CHOICE.crowded), 0.0), 1.0)
        rating += CHOICE.gain * ahead * (mate.x - match.ball.x)
        if rating > best_rating:
            best, best_rating = j, rating
    return best
