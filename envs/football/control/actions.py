"""From actions to desired velocities: the 19 actions, sticky actions, kick buttons and the pull of a free ball.

It also converts back: from a program's command (`main_action`) or the built-in AI's decision (`desired_action`) to the
nearest of the 19 actions. Read next: `control.magnet`; `ai.decide`, which decides for all players without a command,
and `skills.kicks`, which executes kicks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.constants import (
    BUILTIN_AI,
    DIRECTION_X,
    DIRECTION_Y,
    DRIBBLE,
    DRIBBLE_SPEED,
    HIGH_PASS,
    IDLE,
    KICK_PATIENCE,
    LONG_PASS,
    NO_ACTION,
    NOBODY,
    NORMAL,
    NUM_COMMANDS,
    RELEASE_DIRECTION,
    RELEASE_DRIBBLE,
    RELEASE_SPRINT,
    RUN_SPEED,
    SHORT_PASS,
    SHOT,
    SLIDING,
    SPRINT,
)
from regista.envs.football.control.magnet import PULL, follow_magnet, in_time_by, is_ours
from regista.envs.football.physics.dribble import TOUCH
from regista.envs.football.physics.motion import SLIDE
from regista.envs.football.physics.possession import ball_speed, forget_kick, look_ahead, owns, time_to_meet
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.skills.first_touch import is_about_to_play
from regista.envs.football.skills.steering import slide
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Ask(NamedTuple):
    """When a button requests a kick for a player without the ball: the player must reach the ball not much after the
    opponents.
    """

    in_time: float = 0.85  # minimum of the opponents' time divided by the player's time, with `Pull.patience`
    high_pass: float = 1.0  # the same for a high pass
    high: float = 1.5  # m; for a ball above this height,
    high_ease: float = 0.2  # the minimum ratio is lower by this
    slide_from: float = 1.2  # m; a player nearer to an opponent's led ball than this tackles standing
    slide: float = 1.15  # at a free ball, a player whose ratio of times is higher does not slide


class Turns(NamedTuple):
    """How long a carrier runs on after a new direction: until the current touch has ended, or not at all."""

    at_once: float = 0.1  # s; a turn is immediate with probability at_once / (at_once + longest wait)
    runner: float = 0.15  # s at most
    dribbler: float = 0.2  # s at most
    sprinter: float = 0.4  # s at most
    slow: float = 2.0  # m/s; a sprinter who has slowed down to this leaves the arc
    sets_off: float = 0.3  # s, for a player who begins to dribble from standing or after stopping the ball


# Fitted to 600 drawn turns of Google Research Football: `lab.benchmarks --suite grf`, family motion.
TURNS = Turns()
ASK = Ask()  # documented by Google Research Football
HELD_LONGEST = 6  # steps after which a held button kicks by itself
CARRY_RUN, CARRY_DRIBBLE = 4.93, 3.879  # m/s with the ball, without the effect of touches (`dribble`)
SETTING_OFF = 4  # steps of possession in which a carrier who has requested a pass still completes the first turn
STOPPED = 2.0  # m/s of the ball, below which a carrier can stop with it
PASSING_PACE = 2.9  # m/s up to which a carrier who has requested a pass still accelerates
STANDS, SPRINTS = 0.5, 5.5  # m/s: a lower desired speed is a stop, a higher one a sprint
PACE_EVERY = 4  # steps: how often the recorded action expresses the pace instead of the direction


@kernel
def apply_action(match, i, actions):
    """Apply one action of player i, or several: update sticky actions, kick or slide, and set the desired velocity.

    Several actions are digits in base NUM_COMMANDS, the first action is the highest digit. Of actions that exclude each
    other (two directions, an action and its release, kicks and slides), the first one applies.
    """
    player = match.players[i]
    button, direction, dribble = IDLE, player.direction, player.dribble
    while actions > 0:  # from the last to the first
        action = actions % NUM_COMMANDS
        update_sticky_actions(player, action)
        if is_button(action):
            button = action
        actions //= NUM_COMMANDS
    if player.kick != 0 or not is_kick(button) or may_ask(match, i, button):
        hold_kick(player, button)
    if button == SLIDING and may_slide(match, i):
        slide(match, i)
    if match.carrier == i and match.keeper_holding != i:
        begin_turn(match, player, direction, dribble)
    steer(match, i)


@kernel
def begin_turn(match, player, direction, dribble):
    """Let a carrier whose direction changes from `direction` complete the present touch first.

    The duration is random. A turn that begins in a sprint goes in an arc. A player who stands, or stops with the ball,
    and begins to dribble touches the ball again before setting off.
    """
    speed = length(player.vx, player.vy)
    if speed > STANDS and player.direction != direction and player.direction > 0 and direction > 0:
        longest = TURNS.sprinter if player.sprint else TURNS.dribbler if player.dribble else TURNS.runner
        drawn = uniform(match) * (longest + TURNS.at_once) - TURNS.at_once
        player.stance_wait = max(player.stance_wait, player.start_lag * drawn)
        player.turns_wide = player.sprint
        return
    if speed < TURNS.slow:
        player.turns_wide = False
    if (speed <= STANDS or player.stance_wait > 0.0) and player.dribble and not dribble:
        player.stance_wait = max(player.stance_wait, player.start_lag * TURNS.sets_off)


@kernel
def update_sticky_actions(player, action):
    """Update the sticky direction, sprint and dribble."""
    if 1 <= action <= 8:
        player.direction = action
    elif action == RELEASE_DIRECTION:
        player.direction = 0
    elif action == SPRINT:
        player.sprint = True
    elif action == RELEASE_SPRINT:
        player.sprint = False
    elif action == DRIBBLE:
        player.dribble = True
    elif action == RELEASE_DRIBBLE:
        player.dribble = False


@kernel
def release_sticky_actions(match, i):
    """Clear the sticky actions and a kick that has not begun, because the built-in AI has taken over player i."""
    player = match.players[i]
    player.direction = 0
    player.sprint = False
    player.dribble = False
    if player.kick != 0 and not player.is_aimed and match.kicker != i:
        forget_kick(player)


@kernel
def hold_kick(player, action):
    """Count how long a kick button is held; the kick is due on release, or after it was held for too long.

    Another button counts as a release, except a short pass, which replaces a shot or a high pass.
    """
    if is_kick(action) and (player.kick in (0, action) or takes_place(player.kick, action)):
        if player.kick_wait > 0.0:
            return  # the swing has already begun
        if player.kick != action:
            player.kick, player.kick_held, player.is_aimed = action, 0, False
            player.kick_ready = False
        player.kick_held += 1
        player.kick_patience = KICK_PATIENCE
        if player.kick_held >= HELD_LONGEST:
            player.kick_ready = True
    elif player.kick != 0:
        player.kick_ready = True
    if player.kick_ready and player.kick_wait <= 0.0:
        player.kick_patience -= 1
        if player.kick_patience < 0:
            forget_kick(player)


@kernel
def takes_place(kick, action):
    """Return whether a button replaces the kick that has been requested."""
    return action == SHORT_PASS and kick in (HIGH_PASS, SHOT)


@kernel
def may_slide(match, i):
    """Return whether the slide button works for player i: no kick is requested, and the carrier's ball is far enough
    away. At a free ball, the player must be neither the first of the team nor clearly ahead of the opponents.
    """
    player = match.players[i]
    if player.kick != 0 or i in (match.carrier, match.kicker):
        return False
    if match.carrier != NOBODY and apart(match.ball, player) < ASK.slide_from:
        return False
    if match.carrier == NOBODY and is_ours(match, player.team) and match.chaser[player.team] == i:
        return False
    return in_time_by(match, player, time_to_meet(match, i, look_ahead(match.ball))) < ASK.slide


@kernel
def may_ask(match, i, button):
    """Return whether a button requests a kick for player i: the carrier, the first at the ball, or hardly later."""
    player = match.players[i]
    if i in (match.carrier, match.kicker) or (is_ours(match, player.team) and match.chaser[player.team] == i):
        return True
    least = ASK.high_pass if button == HIGH_PASS else ASK.in_time
    if match.ball.z > ASK.high:
        least -= ASK.high_ease
    return in_time_by(match, player, time_to_meet(match, i, look_ahead(match.ball))) >= least


@kernel
def steer(match, i):
    """Set the velocity that the sticky actions request, corrected by the pull of a free ball.

    A carrier who has requested a pass runs on until the ball is kicked. A carrier who has requested a shot does so
    while the leg swings, or if no direction is held. Sprint and dribble held together disable the pull of a free ball,
    as in Google Research Football.
    """
    player = match.players[i]
    at_feet = match.carrier == i and apart(match.ball, player) < TOUCH.reach
    if match.carrier == i and player.stance_wait > 0.0 and player.kick == 0:  # stops with the ball, or ends the touch
        if player.direction == 0 or ball_speed(match.ball) < STOPPED:
            player.desired_vx, player.desired_vy = 0.0, 0.0
        else:
            player.desired_vx, player.desired_vy = player.vx, player.vy
        return
    speed = requested_speed(player, match.carrier == i)
    if at_feet and player.kick != 0 and (player.kick != SHOT or player.direction == 0 or match.kicker == i):
        run_on(player, speed, player.kick < SHOT and match.carry_age < SETTING_OFF)
        return
    if match.carrier == i and player.stance_wait > 0.0:  # stops with the ball first
        player.desired_vx, player.desired_vy = 0.0, 0.0
        return
    player.desired_vx, player.desired_vy = DIRECTION_X[player.direction] * speed, DIRECTION_Y[player.direction] * speed
    freed = player.sprint and player.dribble and not owns(match.ball, player)
    plays = match.carrier == NOBODY and player.direction > 0 and player.kick == 0
    if plays and is_about_to_play(match.ball, player):
        player.desired_vx, player.desired_vy = player.vx, player.vy
    elif match.use_magnet and not at_feet and not freed and match.game_mode == NORMAL:
        follow_magnet(match, i)


@kernel
def run_on(player, speed, sets_off):
    """Let a carrier who has requested a kick run straight on, at up to running speed unless the direction leads back.

    A carrier who hardly moves starts in the held direction. A carrier who sets off and has requested a pass turns to
    the last desired velocity. A carrier about to pass does not accelerate beyond `PASSING_PACE`.
    """
    now = length(player.vx, player.vy)
    ux, uy = DIRECTION_X[player.direction], DIRECTION_Y[player.direction]
    if now < PULL.standing:
        speed = min(speed, PASSING_PACE) if player.kick < SHOT else speed
        player.desired_vx, player.desired_vy = speed * ux, speed * uy
        return
    if sets_off and player.vx * player.desired_vx + player.vy * player.desired_vy > 0.0:
        ux, uy = toward(player.desired_vx, player.desired_vy)
        pace = max(min(speed, PASSING_PACE), now)
        player.desired_vx, player.desired_vy = pace * ux, pace * uy
        return
    if player.direction == 0:
        ux, uy = player.vx, player.vy
    most = PASSING_PACE if player.kick < SHOT else CARRY_RUN
    share = max(min(speed, most) / now, 1.0) if player.vx * ux + player.vy * uy > 0.0 else 1.0
    player.desired_vx, player.desired_vy = share * player.vx, share * player.vy


@kernel
def requested_speed(player, with_ball):
    """Return the speed in m/s that the sprint and dribble actions request."""
    if player.sprint:
        return player.top_speed
    if player.dribble:
        return CARRY_DRIBBLE if with_ball else DRIBBLE_SPEED
    return CARRY_RUN if with_ball else RUN_SPEED


@kernel
def main_action(player, command):
    """Return the main action of a command: a kick or a slide, else the first action that changes a sticky action, else
    the first; IDLE for the built-in AI.
    """
    told = IDLE
    while command > 0:  # from the last to the first
        action = command % NUM_COMMANDS
        command //= NUM_COMMANDS
        says_more = changes(player, action) or not changes(player, told)
        if told == IDLE or is_button(action) or excludes(action, told) or (says_more and not is_button(told)):
            told = action
    return IDLE if told == BUILTIN_AI else told


@kernel
def is_button(action):
    """Return whether an action is a kick or a slide, which takes effect once instead of as long as it is held."""
    return is_kick(action) or action == SLIDING


@kernel
def is_kick(action):
    """Return whether an action is a pass or a shot."""
    return LONG_PASS <= action <= SHOT


@kernel
def excludes(action, other):
    """Return whether two sticky actions set the same thing: direction, sprint or dribble."""
    if is_direction(action):
        return is_direction(other)
    low, high = min(action, other), max(action, other)
    return (low == SPRINT and high == RELEASE_SPRINT) or (low == DRIBBLE and high == RELEASE_DRIBBLE)


@kernel
def is_direction(action):
    """Return whether an action sets or releases the direction."""
    return 1 <= action <= 8 or action == RELEASE_DIRECTION


@kernel
def changes(player, action):
    """Return whether an action would change the player's sticky actions."""
    if 1 <= action <= 8:
        return player.direction != action
    if action == RELEASE_DIRECTION:
        return player.direction != 0
    if action in (SPRINT, RELEASE_SPRINT):
        return player.sprint != (action == SPRINT)
    return player.dribble != (action == DRIBBLE)


@kernel
def desired_action(player, step):
    """Return the one of the 19 actions nearest to the built-in AI's decision; NO_ACTION while the player is down.

    The AI decides on a direction and a pace at the same time. An action expresses only one of them, so it depends on
    the step which one is returned.
    """
    if player.is_sliding and player.down_wait >= SLIDE.time:
        return SLIDING
    if player.down_wait > 0.0:
        return NO_ACTION
    if player.kick != 0:
        return player.kick
    speed = length(player.desired_vx, player.desired_vy)
    if speed < STANDS:
        return RELEASE_DIRECTION
    if step % PACE_EVERY == PACE_EVERY - 1:
        return SPRINT if speed > SPRINTS else RELEASE_SPRINT
    eighths = round(math.atan2(player.desired_vy, player.desired_vx) / (math.pi / 4))  # from +x, counterclockwise
    return (4 - eighths) % 8 + 1
