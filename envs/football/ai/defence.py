"""Built-in players against an opponent: stay between him and the goal, hunt him, tackle, and keep the line.

As measured of Google Research Football, a lone defender retreats before a carrier, staying between him and the
goal, and attacks the ball only near it or near his own goal. Read next: `ai.positions`, where all this is put together;
`ai.keeper`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from regista.envs.football.ai.attack import run_by_forces
from regista.envs.football.ai.formation import LINE, MINDSET, between
from regista.envs.football.ai.run_speed import go, reaction_time
from regista.envs.football.constants import HALF_LENGTH, LEFT, NOBODY, RIGHT
from regista.envs.football.physics.pitch import forward, own_goal_x
from regista.envs.football.physics.possession import look_ahead, man_on_ball, meeting_time, travelled
from regista.envs.football.physics.vectors import apart, length, squared_apart, toward
from regista.envs.football.skills.steering import AWAIT, await_ball, go_for_ball, slide
from regista.kernels.jit import kernel


class Duel(NamedTuple):
    """Going for a led ball: tackles and slides."""

    slide_near: float = 0.7  # m to the ball, at least
    slide_far: float = 1.6  # m, at most
    slide_cosine: float = 0.7  # how nearly straight ahead it lies
    slide_loose: float = 1.4  # m from the carrier to the ball, for which he needs more than 0.26 s
    tackle_range: float = 2.0  # m to a ball
    coming: float = 1.5  # m/s at which it comes: whoever it comes to tries for it


class Race(NamedTuple):
    """Who is sooner at a led ball: his run fades while a circle that he reaches grows around it, as `Run` says."""

    longest: float = 1.5  # s: who needs longer is not asked
    nearest: float = 12.0  # m to the ball, the same
    on_his_way: float = 0.3  # s since the carrier has played it, from when on he is on his way to the next touch,
    touches_every: float = 0.7  # s, which comes so long after the last
    in_time: float = 0.99  # of the carrier's time by his, from where on he goes for it,
    patience: float = 0.2  # s that both are longer than they are


class Guard(NamedTuple):
    """Staying between an opponent and the goal."""

    lead: float = 0.5  # s by which the opponent's run is led, as it was a reaction time ago
    own_lead: float = 0.14  # s by which his own is
    shot_from: float = 24.0  # m to the goal: from where the opponent on the ball shoots,
    danger_from: float = 8.0  # and from where any other is dangerous
    nearest: float = 0.4  # m in front of him at least
    buffer: float = 4.0  # m nearer than he is to where he will shoot
    late: float = 0.7  # share of the m by which a guard is too late that he falls back
    rounds_from: float = 3.0  # m to an opponent in his way back: from there on he runs round him,
    clear_by: float = 1.5  # m beside him,
    abreast: float = 0.3  # m, until he is abreast of him
    most: tuple[float, ...] = (1.9, 1.5, 1.3)  # how much backs, midfield, forwards guard, less the hold on the ball
    curve: float = 0.7


class Meet(NamedTuple):
    """Where a hunter meets the opponent on his way to the goal."""

    stride: float = 0.8  # m beyond where both are equally far
    lead: float = 0.14  # s, the opponent's run
    deep: float = 0.5  # m deeper than he is, which do not count,
    wide: float = 0.8  # m aside for each m deeper: from there on he must move


class Trap(NamedTuple):
    """The line behind which nobody falls back but with the ball."""

    start: float = 40.0  # m from the own goal, where the line is held,
    force: float = 6.0  # and where it is held at the last
    fall_back: float = 25.0  # m before the ball, while that is far
    future: float = 0.7  # s of the ball's way
    caution: float = 4.0  # m before the opponent on the ball,
    rival_lead: float = 0.15  # s, his run
    slack: float = 4.0  # m that a mate may be behind the line
    seen_lead: float = 0.24 - 0.11  # s by which opponents lead their runs, whom they see a reaction time ago
    soft: float = 2.0  # m before the line, from where on places are pressed together


# Documented of Google Research Football; families tackles, academy and matches of `regista benchmark --suite grf`.
DUEL, RACE, GUARD, MEET, TRAP = Duel(), Race(), Guard(), Meet(), Trap()


@kernel
def tackles(match, player):
    """Return whether a player tries for a led ball that comes to him, from where he is not behind it.

    Who marks the carrier waits for that until he has come close to where he will shoot.
    """
    ball = match.ball
    dx, dy = ball.x - player.x, ball.y - player.y
    if match.carrier == NOBODY or dx * dx + dy * dy > DUEL.tackle_range * DUEL.tackle_range:
        return False
    if player.marked_opponent == match.carrier:
        carrier = match.players[match.carrier]
        if length(own_goal_x(player.team) - carrier.x, carrier.y) > GUARD.shot_from + GUARD.buffer:
            return False
    coming = -(dx * ball.vx + dy * ball.vy) / (length(dx, dy) + 1e-9)
    return coming > DUEL.coming and forward(player.team) * dx > 0.0


@kernel
def goes_for_led_ball(match, i):
    """Let player i, the first of his team at a ball that an opponent leads, go for it if he is as soon at it; return
    whether he does.

    The original has its one designated player do so, whomever he marks. After each touch of a sprinter a back 6 m
    before him is sooner at the ball for a moment: he then stops, and lets it come.
    """
    player, ball = match.players[i], match.ball
    if match.carrier == NOBODY or match.keeper_holding != NOBODY or match.chaser[player.team] != i:
        return False
    carrier = match.players[match.carrier]
    if carrier.team == player.team or squared_apart(player, ball.x, ball.y) > RACE.nearest * RACE.nearest:
        return False
    ahead = look_ahead(ball)
    mine = meeting_time(ball, ahead, player)
    if mine >= RACE.longest:
        return False
    his = meeting_time(ball, ahead, carrier)
    if carrier.stride < 0.0:
        his = min(his, -carrier.stride)  # he is about to play it
    elif carrier.stride > RACE.on_his_way:
        his = min(his, max(RACE.touches_every - carrier.stride, 0.0))
    in_time = (his + RACE.patience) / (mine + RACE.patience)
    if in_time < RACE.in_time:
        return False
    if in_time < AWAIT.in_time or not awaits_carrier(match, player, mine):
        share = travelled(ahead, mine) / (ahead.speed + 1e-9)
        go(player, ball.x + share * ball.vx - player.x, ball.y + share * ball.vy - player.y, player.top_speed)
    return True


@kernel
def awaits_carrier(match, player, time):
    """Let a player who is at a led ball in `time` s, clearly sooner than its carrier, meet it where that suits where he
    would dribble; return whether it comes to him.
    """
    run_by_forces(match, player)
    ux, uy = toward(player.desired_vx, player.desired_vy)
    return await_ball(match.ball, player, time, ux, uy)


@kernel
def tackle(match, i):
    """Run at a led ball, and slide where only that reaches it."""
    player = match.players[i]
    go_for_ball(match, i, player.top_speed)
    if may_slide(match, player):
        slide(match, i)


@kernel
def may_slide(match, player):
    """Return whether a slide reaches a ball that is loose for long enough; teams with agents leave that to them."""
    ball, carrier = match.ball, match.players[match.carrier]
    if match.num_agents[player.team] != 0 or apart(ball, carrier) < DUEL.slide_loose:
        return False
    dx, dy = ball.x - player.x, ball.y - player.y
    distance = length(dx, dy)
    ahead = player.facing_x * dx + player.facing_y * dy
    return DUEL.slide_near < distance < DUEL.slide_far and ahead > DUEL.slide_cosine * distance


@kernel
def must_move(player, rival):
    """Return whether a player has to move to meet an opponent, who does not simply run into him.

    They would meet on the opponent's way to the goal, where both are equally far, or just beyond.
    """
    goal_x = own_goal_x(player.team)
    way_x, way_y = goal_x - rival.x, -rival.y
    to_x, to_y = player.x - rival.x, player.y - rival.y
    along = way_x * to_x + way_y * to_y
    share = min(0.5 * (to_x * to_x + to_y * to_y) / along, 1.0) if along > 1e-9 else 0.0
    share += MEET.stride / (length(way_x, way_y) + 1e-9)
    x = rival.x + share * way_x + MEET.lead * rival.vx
    y = rival.y + share * way_y + MEET.lead * rival.vy
    deep = max(forward(player.team) * (x - player.x), 0.0) - MEET.deep
    return abs(y - player.y) > MEET.wide * deep


@kernel
def guard_share(match, player):
    """Return how much a player guards whom he marks, 0 to 1: the more the less of the ball his team has."""
    attacker = MINDSET[match.players[player.post].role]
    share = GUARD.most[LINE[player.role]] - attacker - match.hold[player.team]
    return share**GUARD.curve if 0.0 < share < 1.0 else min(max(share, 0.0), 1.0)


@kernel
def guarding_place(match, player, x, y):
    """Return where a player who belongs at (x, y) guards the opponent whom he marks: nearer to where he will shoot.

    Where that opponent will be is led so far that a guard goes back before a sprinter rather than into him.
    """
    rival = match.players[player.marked_opponent]
    goal_x = own_goal_x(player.team)
    lead = GUARD.lead - reaction_time(player)
    from_x, from_y = rival.x + lead * rival.vx, rival.y + lead * rival.vy
    to_goal = length(goal_x - from_x, from_y) + 1e-9
    on_ball = player.marked_opponent == man_on_ball(match, rival.team) and match.team_in_possession == rival.team
    way = min(max(to_goal - (GUARD.shot_from if on_ball else GUARD.danger_from), GUARD.nearest), HALF_LENGTH)
    ahead, line = forward(player.team), match.trap[player.team]
    if ahead * (from_x + way / to_goal * (goal_x - from_x)) < line:
        way = to_goal * (ahead * line - from_x) / (goal_x - from_x + math.copysign(1e-9, goal_x))
    spot_x, spot_y = from_x + way / to_goal * (goal_x - from_x), from_y * (1.0 - way / to_goal)
    way = abs(way)  # who is past the line is met where he would have crossed it, behind his back
    off = length(spot_x - x, spot_y - y) + 1e-9
    share = min(max(off - way + GUARD.buffer, 0.0) / off, 1.0)
    x, y = x + share * (spot_x - x), y + share * (spot_y - y)
    late = length(spot_x - player.x - GUARD.own_lead * player.vx, spot_y - player.y - GUARD.own_lead * player.vy) - way
    if late > 0.0:
        back = GUARD.late * late / (length(goal_x - x, y) + 1e-9)
        x, y = x + back * (goal_x - x), y * (1.0 - back)
    return x, y


@kernel
def run_round(player, rival, x, y):
    """Run round an opponent who is in the way to (x, y); return whether one is."""
    dx, dy = x - player.x, y - player.y
    distance = length(dx, dy) + 1e-9
    to_x, to_y = rival.x - player.x, rival.y - player.y
    along, across = (to_x * dx + to_y * dy) / distance, (to_x * dy - to_y * dx) / distance
    if not GUARD.abreast < along < min(distance, GUARD.rounds_from) or abs(across) > GUARD.clear_by:
        return False
    aside = math.copysign(GUARD.clear_by, across)  # to the side on which he is not
    x, y = rival.x - aside * dy / distance, rival.y + aside * dx / distance
    go(player, x + dx / distance - player.x, y + dy / distance - player.y, player.top_speed)
    return True


@kernel
def lay_traps(match):
    """Set both teams' lines behind which nobody falls back, where the deepest danger is, and who is second-last."""
    for team in (LEFT, RIGHT):
        match.trap[team] = -deepest_danger(match, team)


@kernel
def deepest_danger(match, team):
    """Return how deep in a team's half, in m from the middle, its line is: by ball, carrier, and slow mates."""
    depth = -forward(team)
    ball = depth * match.ball.x
    near = between(ball, HALF_LENGTH - TRAP.start - TRAP.fall_back, HALF_LENGTH - TRAP.force)
    deepest = max(HALF_LENGTH - TRAP.start, ball + TRAP.fall_back * (1.0 - near))
    deepest = max(deepest, ball + TRAP.future * depth * match.ball.vx)
    on_ball = man_on_ball(match, 1 - team)
    if on_ball != NOBODY:
        rival = match.players[on_ball]
        deepest = max(deepest, depth * (rival.x + TRAP.rival_lead * rival.vx) + TRAP.caution)
    last, second, led_last, led_second = -math.inf, -math.inf, -math.inf, -math.inf
    for i in range(match.num_players):
        player = match.players[i]
        if player.team == team and not player.has_left:
            depth_of_player = depth * player.x
            last, second = max(last, depth_of_player), max(second, min(last, depth_of_player))
            depth_of_player += TRAP.seen_lead * depth * player.vx
            led_last, led_second = max(led_last, depth_of_player), max(led_second, min(led_last, depth_of_player))
    match.second_last[team] = led_second
    return max(deepest, max(second, ball, 0.0) - TRAP.slack)


@kernel
def held_up(match, team, x):
    """Return x of a place in m, pressed together before the line behind which nobody falls back."""
    depth = -forward(team)
    start = -match.trap[team] - TRAP.soft
    if depth * x <= start:
        return x
    return depth * (start + TRAP.soft * min((depth * x - start) / (2.0 * TRAP.soft), 1.0))
