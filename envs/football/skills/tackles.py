"""Winning the ball from a carrier: standing tackles, slides, and the resulting fouls.

Chances are fitted to tackles measured in Google Research Football; severities follow its rule. Read next:
`rules.fouls`.
"""

from __future__ import annotations

from typing import NamedTuple

from regista.envs.football.constants import BUILTIN_AI, DT
from regista.envs.football.physics.motion import SLIDE
from regista.envs.football.physics.vectors import apart, length, toward
from regista.envs.football.rules.fouls import report_foul
from regista.envs.football.skills.touch import take
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform


class Tackle(NamedTuple):
    """Standing tackles."""

    reach: float = 0.85  # m from the body to the ball
    below: float = 0.9  # m, maximum height of the ball
    idles: float = 0.5  # m/s; a slower player who desires no higher speed does not try
    meant_cosine: float = 0.85  # minimum cosine between the tackler's desired direction and the way to the ball
    shielding_cosine: float = 0.5  # cosine between the ways to the carrier and on to the ball: above it, a shield
    passing_most: float = 9.0  # m/s at which the ball passes the tackler, at most
    contact: float = 0.85  # m between bodies, for a poke round the carrier's body
    at_feet: float = 0.6  # m from the carrier's body to the ball, for such a poke
    chance: float = 0.9
    hurried: float = 0.02  # chance lost per m/s of the carrier
    built_in: float = 0.94  # chance of a built-in player,
    built_in_hurried: float = 0.225  # less this per m/s of the carrier,
    built_in_far: float = 1.7  # more by this per m from the carrier's body to the ball,
    built_in_most: float = 0.9  # but at most:
    built_in_least: float = 0.6  # factor of this for the least skillful player,
    built_in_skill: float = 0.55  # and added for the most skillful player, up to 1
    beside: float = 0.35  # minimum cosine of the angle from the carrier's front, for a built-in player's try
    behind: float = 0.3  # factor of the chance from behind
    behind_cosine: float = -0.3  # cosine of the angle from the carrier's front, below which a tackle is from behind
    skill_least: float = 0.9  # factor of the chance for the least skillful
    skill_most: float = 1.04  # and for the most skillful
    clumsy: float = 4.5  # the chance is multiplied by 1 plus this times the square of the missing skill of the carrier
    swerve: float = 20.0  # m/s, see `within_reach`
    wait: float = 0.6  # s after a failure until the player can touch the ball again
    beaten_down: float = 0.3  # s on the ground
    robbed_wait: float = 0.7  # s until a robbed carrier can touch the ball again
    won_speed: float = 0.3  # share of the winner's speed that the ball gets
    trip_chance: float = 0.4  # probability of a tackle from the side or from behind that misses the ball


class Slide(NamedTuple):
    """Slides, and the resulting fouls."""

    reach: float = 0.75  # m from the body to the ball
    legs: float = 0.8  # m from the body to the feet,
    trip_reach: float = 0.6  # m from the feet to the carrier's body
    legs_out: float = SLIDE.time - 0.05  # s left of a slide; before, the slide reaches no carrier
    rate: float = 10.0  # wins per s within reach
    moving: float = 0.5  # m/s at which the ball passes the player, at least
    shielded: float = 0.05  # factor of the rate from behind, until the slide has passed the carrier's body
    foul_side: float = 0.97  # probability of felling a standing carrier from the side
    foul_side_running: float = 0.87  # probability of felling a running carrier from the side
    foul_behind: float = 0.95  # probability of felling a running carrier from behind; a standing one: `foul_front`
    foul_front: float = 0.03
    severity: float = 1.0  # severity of a slide that does not reach the ball
    severity_standing: float = 0.5  # added against a standing carrier
    severity_running: float = 0.9  # at most added against a running carrier


# Fitted to tackles measured in Google Research Football: `lab.benchmarks --suite grf`, family tackles.
TACKLE, SLIDING = Tackle(), Slide()
STANDING = 1.5  # m/s, below which a carrier stands
SIDE_COSINE = 0.7  # below this absolute cosine a tackle is from the side


@kernel
def in_tackle_reach(match, i, distance):
    """Return whether player i, at `distance` m from the ball, tries for it, if necessary past the carrier's body.

    An idle player beside a standing carrier does not.
    """
    player, ball, carrier = match.players[i], match.ball, match.players[match.carrier]
    if ball.z > TACKLE.below:
        return False
    idles = length(player.desired_vx, player.desired_vy) < TACKLE.idles and length(player.vx, player.vy) < TACKLE.idles
    if idles and length(carrier.vx, carrier.vy) < STANDING:
        return False
    return distance < TACKLE.reach or (
        apart(player, carrier) < TACKLE.contact and apart(ball, carrier) < TACKLE.at_feet
    )


@kernel
def goes_for_ball(match, i, distance):
    """Return whether player i tries for the ball at this distance: the desired direction leads to it, or the player
    stands and lets it come.

    A built-in player tries with any desired direction, but not past the carrier's body, nor at a high closing speed.
    """
    player, ball = match.players[i], match.ball
    carrier = match.players[match.carrier]
    if player.action != BUILTIN_AI:
        want = length(player.desired_vx, player.desired_vy)
        along = player.desired_vx * (ball.x - player.x) + player.desired_vy * (ball.y - player.y)
        return along >= TACKLE.meant_cosine * want * distance
    to_x, to_y = toward(carrier.x - player.x, carrier.y - player.y)
    ball_x, ball_y = toward(ball.x - carrier.x, ball.y - carrier.y)
    slow = length(ball.vx - player.vx, ball.vy - player.vy) < TACKLE.passing_most
    ahead = frontal(player, carrier) > TACKLE.beside or length(carrier.vx, carrier.vy) < STANDING
    return slow and ahead and to_x * ball_x + to_y * ball_y < TACKLE.shielding_cosine


@kernel
def tackle(match, i):
    """Let player i try to win the ball from the carrier."""
    player, carrier = match.players[i], match.players[match.carrier]
    front, speed = frontal(player, carrier), length(carrier.vx, carrier.vy)
    if player.action == BUILTIN_AI:
        chance = chance_of_built_in(match, player, carrier, speed)
    else:
        chance = (TACKLE.chance - TACKLE.hurried * speed) * within_reach(match, i, TACKLE.swerve)
        chance *= share_of_skill(player) * (1.0 + TACKLE.clumsy * (1.0 - carrier.skill) ** 2)
        if front < TACKLE.behind_cosine:
            chance *= TACKLE.behind
    chance *= match.engine.tackle_odds
    if uniform(match) < chance:
        win(match, i)
        return
    player.touch_wait = TACKLE.wait
    if speed > STANDING:
        player.down_wait = max(player.down_wait, TACKLE.beaten_down)
        if front < SIDE_COSINE and uniform(match) < TACKLE.trip_chance:
            report_foul(match, i, match.carrier, 0.0, False)


@kernel
def chance_of_built_in(match, player, carrier, speed):
    """Return the chance of a built-in player, who waits for the ball, against a carrier at this speed in m/s.

    The chance grows with the distance of the ball from the carrier.
    """
    chance = TACKLE.built_in - TACKLE.built_in_hurried * speed + TACKLE.built_in_far * apart(match.ball, carrier)
    return min(chance, TACKLE.built_in_most) * min(TACKLE.built_in_least + TACKLE.built_in_skill * player.skill, 1.0)


@kernel
def share_of_skill(player):
    """Return the factor of the chance to win the ball for a player's skill; 1 for the skill of the measured players."""
    return TACKLE.skill_least + (TACKLE.skill_most - TACKLE.skill_least) * player.skill


@kernel
def slide_into(match, i, distance):
    """Let player i, sliding at `distance` m from the ball, win it or fell the carrier if either is in reach."""
    player, carrier, ball = match.players[i], match.players[match.carrier], match.ball
    if player.down_wait > SLIDING.legs_out:
        return
    front = frontal(player, carrier)
    feet_x, feet_y = player.x + SLIDING.legs * player.facing_x, player.y + SLIDING.legs * player.facing_y
    if length(carrier.x - feet_x, carrier.y - feet_y) < SLIDING.trip_reach and not player.is_slide_spent:
        player.is_slide_spent = True
        runs = length(carrier.vx, carrier.vy) > STANDING
        if uniform(match) < foul_chance(front, runs):
            most = SLIDING.severity_running * uniform(match) if runs else SLIDING.severity_standing
            player.touch_wait = TACKLE.wait
            report_foul(match, i, match.carrier, SLIDING.severity + most, True)
            return
    passes = length(ball.vx - player.vx, ball.vy - player.vy)
    if distance > SLIDING.reach or ball.z > TACKLE.below or passes < SLIDING.moving:
        return
    rate = SLIDING.rate * share_of_skill(player) * match.engine.tackle_odds
    same_way = player.facing_x * carrier.facing_x + player.facing_y * carrier.facing_y
    if same_way > SIDE_COSINE and distance > apart(ball, carrier):
        rate *= SLIDING.shielded
    if uniform(match) < rate * DT:
        win(match, i)


@kernel
def foul_chance(front, runs):
    """Return the chance that a slide fells the carrier: high from the side or from behind if running, else low."""
    if abs(front) < SIDE_COSINE:
        return SLIDING.foul_side_running if runs else SLIDING.foul_side
    if front > 0.0:
        return SLIDING.foul_front
    return SLIDING.foul_behind if runs else SLIDING.foul_front


@kernel
def frontal(player, carrier):
    """Return the cosine of the direction from which a player comes: 1 from in front of the carrier, -1 from behind."""
    ux, uy = toward(player.x - carrier.x, player.y - carrier.y)
    return ux * carrier.facing_x + uy * carrier.facing_y


@kernel
def win(match, i):
    """Give the carrier's ball to player i; the carrier cannot win it back at once."""
    match.players[match.carrier].touch_wait = TACKLE.robbed_wait
    take(match, i)
    if match.carrier == i:
        ball = match.ball
        ball.vx, ball.vy = TACKLE.won_speed * ball.vx, TACKLE.won_speed * ball.vy


@kernel
def within_reach(match, i, widest):
    """Return the factor of player i's chance to win the ball from a carrier who swerves across the player's reach.

    At `widest` m/s across it the ball cannot be won.
    """
    player, ball, carrier = match.players[i], match.ball, match.players[match.carrier]
    dx, dy = ball.x - player.x, ball.y - player.y
    swerve = abs(carrier.vx * dy - carrier.vy * dx) / (length(dx, dy) + 1e-9)
    return max(1.0 - swerve / widest, 0.0)
