"""What must never be in a match, and the kernels that play matches and look for it.

They stand in one file, for Numba keeps what it has compiled as long as the file is the same. Read next:
`tests.envs.torture`, who makes the matches.
"""

from __future__ import annotations

import math

from regista.envs.football.constants import (
    BUILTIN_AI,
    CORNER,
    FREE_KICK,
    GK,
    GOAL_KICK,
    LEFT,
    NO_FAULT,
    NOBODY,
    NORMAL,
    PENALTY,
    RUNNING,
    SHOT,
    SLIDING,
    SPRINT,
    STAND,
    THROW_IN,
)
from regista.envs.football.rules.fouls import report_foul
from regista.envs.football.skills.contacts import FEET
from regista.envs.football.skills.hands import PARRY
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform

COMPLAINTS = (
    *("sane", "a player's numbers are not finite", "a player is off the grass", "a player is too fast"),
    *("a player looks nowhere", "the ball's numbers are not finite", "the ball is where it cannot be"),
    *("the ball is too fast", "the score does not follow the goals", "play goes on with the ball outside"),
    *("a mode without a restart", "a restart without a mode", "the ball moves while play is stopped"),
    *("a restart that never ends", "somebody has the ball who cannot", "the owner is far from the ball"),
    *("a leg swings that must not", "who has left takes part", "a card that cannot be", "an end that is none"),
    *("the ball gained energy by itself", "a fault was raised", "the clock stands"),
    *("a goal counted for the wrong side", "somebody jumped", "the ball jumped", "a restart from the wrong place"),
    *("an opponent stands at the restart", "who was sent off is back, or a card is gone", "a name that nobody has"),
    *("an agent and its player disagree", "a touch that is no kick made the ball fast", "a half that cannot be"),
)
STYLES = 8  # of `choose_actions`
FASTEST = 10.0  # m/s of a body


@kernel
def complaint(match, before, energy):
    """Say what is wrong with a match after a step, 0 nothing; `energy` is the ball's before it, negative if unknown."""
    wrong = wrong_state(match) or wrong_change(match, before)
    if wrong != 0:
        return wrong
    if energy >= 0.0 and free(match) and energy_of(match.ball) > 1.001 * energy + 0.02:
        return 20
    return 22 if match.step != before.step + 1 else 0


@kernel
def wrong_state(match):
    """Say what is wrong with a match as it is, 0 nothing."""
    wrong = wrong_player(match) or wrong_ball(match) or wrong_play(match) or wrong_names(match) or wrong_restart(match)
    return 21 if wrong == 0 and match.fault != NO_FAULT else wrong


@kernel
def survey(matches, befores):
    """Return the first of matches [N] that is not sane a step after `befores` [N], and why; (-1, 0) where all are.

    One that has begun anew is looked at as it is.
    """
    for e in range(len(matches)):
        match = matches[e]
        wrong = wrong_state(match) if match.step == 0 else complaint(match, befores[e], -1.0)
        if wrong != 0:
            return e, wrong
    return -1, 0


@kernel
def wrong_change(match, before):
    """Return the number of what cannot come about within a step and did, 0 if nothing."""
    left, right = match.score[0] - before.score[0], match.score[1] - before.score[1]
    if left + right != abs(match.goal):
        return 8
    if left - right != match.goal or left < 0 or right < 0:
        return 23
    if match.half < before.half or match.half > 1 or (match.half == 1 and match.step < match.second_half):
        return 32
    for i in range(match.num_players):
        p, q = match.players[i], before.players[i]
        if (q.has_left and not p.has_left) or p.cards < q.cards:
            return 28
    if match.game_mode != NORMAL or before.game_mode != NORMAL or match.goal != 0 or match.half != before.half:
        return 0
    for i in range(match.num_players):
        p, q = match.players[i], before.players[i]
        if not p.has_left and (p.x - q.x) ** 2 + (p.y - q.y) ** 2 > 1.5 * 1.5 and alone(before, i):
            return 24
    b, a = match.ball, before.ball
    if (b.x - a.x) ** 2 + (b.y - a.y) ** 2 > 6.0 * 6.0:
        return 25
    kicked = match.kick_age <= 0.1 + 1e-9 or match.kicker != NOBODY or before.kicker != NOBODY
    most = max(energy_of(a) + spin_energy(a), 0.5 * fastest_touch(before) ** 2)
    return 31 if not kicked and 0.5 * (b.vx * b.vx + b.vy * b.vy) > most + 1e-6 else 0


@kernel
def fastest_touch(match):
    """Return the speed in m/s that a touch can give the ball which is no kick: a keeper's slide, or his hands."""
    ball = match.ball
    struck = PARRY.ball * math.sqrt(ball.vx * ball.vx + ball.vy * ball.vy) + PARRY.run * fastest_body(match)
    return max(FEET.fast, struck)


@kernel
def fastest_body(match):
    """Return the speed in m/s that nobody exceeds: keepers of some engines are faster than everybody else."""
    return FASTEST * max(match.engine.keeper_speed, 1.0)


@kernel
def alone(match, i):
    """Return whether nobody is near enough to push player i aside; out of a pile bodies are pushed far."""
    others = 0
    for j in range(match.num_players):
        dx, dy = match.players[i].x - match.players[j].x, match.players[i].y - match.players[j].y
        others += j != i and dx * dx + dy * dy < 3.0 * 3.0
    return others == 0


@kernel
def wrong_names(match):
    """Return a number if players or teams that are named do not exist, or are not of the team they are named for."""
    n = match.num_players
    for i in (match.last_touch, match.receiver, match.last_carrier, match.foul_player, match.foul_victim, match.kicker):
        if i < NOBODY or i >= n:
            return 29
    for team in range(2):
        for i in (match.chaser[team], match.runner[team], match.hunter[team, 0], match.hunter[team, 1]):
            if i < NOBODY or i >= n or (i != NOBODY and match.players[i].team != team):
                return 29
    for agent in range(match.num_agents[0] + match.num_agents[1]):
        i = match.agents[agent]
        if i == NOBODY:
            continue
        p = match.players[i]
        if i < 0 or i >= n or p.agent != agent or p.team != (0 if agent < match.num_agents[0] else 1):
            return 30
    for i in range(n):
        p = match.players[i]
        if p.agent != NOBODY and match.agents[p.agent] != i:
            return 30
        if (
            p.direction < 0
            or p.direction > 8
            or p.marked_opponent < NOBODY
            or p.marked_opponent >= n
            or p.kick_mate >= n
        ):
            return 29
    return 0


@kernel
def wrong_restart(match):
    """Return a number if a restart is not taken from where the rules say, or the opponents have not gone away."""
    b, mode = match.ball, match.game_mode
    if mode == NORMAL:
        return 0
    x, y = abs(b.x), abs(b.y)
    right_place = (
        (mode == THROW_IN and x < 55.0 and y == 36.0)
        or (mode == GOAL_KICK and abs(x - 50.6) < 1e-9 and y == 0.0)
        or (mode == CORNER and x == 55.0 and y == 36.0)
        or (mode == PENALTY and x == 44.0 and y == 0.0)
        or (mode == FREE_KICK and x <= 0.95 * 55.0 and y <= 0.95 * 36.0)
    )
    if not right_place:
        return 26
    takers, others = 0, 0
    for i in range(match.num_players):
        here = not match.players[i].has_left
        takers += here and match.players[i].team == match.restart_team
        others += here and match.players[i].team != match.restart_team
    if takers == 0 or others == 0:  # who has nobody leaves every restart to the others
        return 0
    ahead = b.x if match.restart_team == LEFT else -b.x
    if (mode == GOAL_KICK and ahead > 0.0) or (mode in (CORNER, PENALTY) and ahead < 0.0):
        return 26
    least = (2.0 if mode == THROW_IN else 9.15) - 1.0  # m; who stands on another steps aside
    for i in range(match.num_players):
        p = match.players[i]
        kept_away = p.team != match.restart_team and p.role != GK and not p.has_left and match.restart_wait == 0
        if kept_away and (p.x - b.x) ** 2 + (p.y - b.y) ** 2 < least * least:
            return 27
    return 0


@kernel
def wrong_player(match):
    fastest = fastest_body(match)
    for i in range(match.num_players):
        p = match.players[i]
        if not math.isfinite(
            p.x + p.y + p.vx + p.vy + p.facing_x + p.facing_y + p.desired_vx + p.desired_vy + p.tiredness
        ):
            return 1
        if not p.has_left and (abs(p.x) > 58.0 + 1e-9 or abs(p.y) > 39.0 + 1e-9):
            return 2
        if p.vx * p.vx + p.vy * p.vy > fastest * fastest:
            return 3
        if abs(p.facing_x * p.facing_x + p.facing_y * p.facing_y - 1.0) > 1e-6:
            return 4
        if p.kick_wait > 0.0 and match.kicker != i:
            return 16
        if p.cards < 0 or p.cards > 2 or (p.has_left and p.cards != 2):
            return 18
        if not p.tiredness >= 0.0 or p.tiredness > 0.99 or not p.down_wait >= 0.0 or not p.skill > 0.0:
            return 1
    return 0


@kernel
def wrong_ball(match):
    b = match.ball
    if not math.isfinite(b.x + b.y + b.z + b.vx + b.vy + b.vz + b.spin_x + b.spin_y + b.curl):
        return 5
    if abs(b.x) > 58.5 or abs(b.y) > 60.0 or b.z < 0.1 or b.z > 60.0:
        return 6
    if b.vx * b.vx + b.vy * b.vy + b.vz * b.vz > 55.0 * 55.0:
        return 7
    outside = abs(b.x) > 55.17 + 1e-9 or (abs(b.y) > 36.17 + 1e-9 and match.line_wait <= 1e-9)
    if outside and match.game_mode == NORMAL and match.ended == RUNNING:
        return 9
    return 0


@kernel
def wrong_play(match):
    if match.game_mode == NORMAL:
        if match.restart_team != NOBODY or match.taker != NOBODY:
            return 11
    else:
        if match.restart_team == NOBODY or match.game_mode < 2 or match.game_mode > 6:
            return 10
        b = match.ball
        if b.vx != 0.0 or b.vy != 0.0 or b.vz != 0.0:
            return 12
        if match.restart_wait > 30:
            return 13
        if match.carrier != NOBODY or match.keeper_holding != NOBODY or match.kicker != NOBODY:
            return 14
        if match.taker != NOBODY and match.players[match.taker].team != match.restart_team:
            return 10
        if match.reported_owner != NOBODY and (match.reported_owner != match.taker or match.game_mode != THROW_IN):
            return 14
    for i in (match.carrier, match.keeper_holding, match.kicker, match.taker, match.reported_owner, match.saver):
        if i != NOBODY and (i < 0 or i >= match.num_players or match.players[i].has_left):
            return 17
    if match.keeper_holding != NOBODY and (
        match.carrier != match.keeper_holding or match.players[match.keeper_holding].role != GK
    ):
        return 14
    if match.reported_owner != NOBODY:
        o = match.players[match.reported_owner]
        if (o.x - match.ball.x) ** 2 + (o.y - match.ball.y) ** 2 > 3.0 * 3.0:
            return 15
    if (match.terminated and match.truncated) or (match.ended == RUNNING) == (match.terminated or match.truncated):
        return 19
    return 0


@kernel
def free(match):
    """Return whether nobody but the laws of nature acts on the ball."""
    return match.carrier == NOBODY and match.game_mode == NORMAL and match.ended == RUNNING and match.goal == 0


@kernel
def energy_of(ball):
    """Return energy of the ball in J per kg, without that of its spin."""
    return 0.5 * (ball.vx * ball.vx + ball.vy * ball.vy + ball.vz * ball.vz) + 9.81 * (ball.z - 0.11)


@kernel
def spin_energy(ball):
    """Return what the spin can give back to the ball, in J per kg."""
    return 0.5 * (ball.spin_x * ball.spin_x + ball.spin_y * ball.spin_y)


@kernel
def choose_actions(match, style, actions):
    """Fill in an action per player in this style; keys held before are mostly kept."""
    for i in range(match.num_players):
        draw = uniform(match)
        key = int(19 * uniform(match))
        if style == 0:
            actions[i] = key
        elif style == 1:
            actions[i] = BUILTIN_AI
        elif style == 2:
            actions[i] = BUILTIN_AI if draw < 0.6 else key
        elif style == 3:
            actions[i] = SLIDING if draw < 0.4 else (1 + int(8 * uniform(match)) if draw < 0.8 else SPRINT)
        elif style == 4:
            actions[i] = (2, 4, 6, 8)[match.step // 100 % 4] if draw < 0.9 else SPRINT
        elif style == 5:
            if draw < 0.05:
                actions[i] = key
        elif style == 6:
            actions[i] = STAND if i % 2 == 0 else BUILTIN_AI
        else:
            actions[i] = SHOT - int(4 * draw) if uniform(match) < 0.5 else BUILTIN_AI


@kernel
def prepare(matches, starts, befores, styles, actions, energies):
    """Begin ended matches anew, choose all actions, and copy each match and the energy of its ball."""
    for e in range(len(matches)):
        match = matches[e]
        if match.ended != RUNNING:
            stream = match.random
            matches[e] = starts[e]
            match.random = stream
        if uniform(match) < 0.01:
            styles[e] = int(STYLES * uniform(match))
        choose_actions(match, styles[e], actions[e])
        if match.num_agents[0] + match.num_agents[1] > 0:
            for i in range(actions.shape[1]):
                actions[e, i] %= 19  # agents have no built-in AI's action, and cannot stand
        if uniform(match) < 0.001:
            foul_at_random(match)
        befores[e] = match
        rolls = free(match) and match.kicker == NOBODY
        energies[e] = energy_of(match.ball) + spin_energy(match.ball) if rolls else -1.0


@kernel
def first_complaint(matches, befores, energies):
    """Return the first match that is not sane after a step and why: (index, complaint), or (-1, 0)."""
    for e in range(len(matches)):
        match, before = matches[e], befores[e]
        untouched = match.last_touch == before.last_touch and not touched(match, before)
        wrong = complaint(match, before, energies[e] if untouched else -1.0)
        if wrong != 0:
            return e, wrong
    return -1, 0


@kernel
def touched(match, before):
    """Return whether somebody has touched the ball since: he must wait longer now."""
    count = 0
    for i in range(match.num_players):
        count += match.players[i].touch_wait > before.players[i].touch_wait
    return count > 0


@kernel
def foul_at_random(match):
    """Let somebody foul an opponent, however far away, by any severity."""
    i, j = int(match.num_players * uniform(match)), int(match.num_players * uniform(match))
    a, b = match.players[i], match.players[j]
    if a.team != b.team and not a.has_left and not b.has_left:
        report_foul(match, i, j, 2.4 * uniform(match), uniform(match) < 0.7)
