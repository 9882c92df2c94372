"""Taking the ball off a carrier's feet: standing tackles, slides, and the fouls that come of both.

Chances are fitted to tackles measured of Google Research Football, severities follow its rule. Read next:
`rules.fouls`.
"""

from __future__ import annotations

from envs.football.constants import BUILTIN_AI, DT
from envs.football.physics.motion import SLIDE_TIME
from envs.football.physics.vectors import apart, length, toward
from envs.football.rules.fouls import report_foul
from envs.football.skills.touch import take
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

STANDING = 1.5  # m/s, a carrier slower than this stands

# Standing tackles
TACKLE_REACH, TACKLE_BELOW = 0.85, 0.9  # m from the body to the ball; its height
IDLES = 0.5  # m/s
MEANT_COSINE = 0.85  # of the angle between the way that a tackler wants to go and the ball
SHIELDING_COSINE = 0.6  # of the angle at the carrier's body between the way to him and on to the ball
PASSING_MOST = 9.0  # m/s at which the ball passes
CONTACT, AT_FEET = 0.85, 0.6  # m between bodies, and to the ball from the carrier's, for a poke round his body
TACKLE_CHANCE, TACKLE_HURRIED = 0.9, 0.02  # of a tackle; less of it per m/s of the carrier
TACKLE_BEHIND, BEHIND_COSINE = 0.3, -0.3  # share of the chance that is left from behind
SKILL_LEAST, SKILL_MOST = 0.9, 1.04  # share of the chance that the least and the most skilful have
CLUMSY = 4.5  # more of the chance against a carrier without skill, by the square of what he lacks
SWERVE = 20.0  # m/s, see `within_reach`
TACKLE_WAIT, BEATEN_DOWN, ROBBED_WAIT = 0.6, 0.3, 0.7  # s
WON_SPEED = 0.3  # share of the winner's speed that the ball gets
TRIP_CHANCE = 0.4  # of a tackle from the side or from behind that misses the ball
SIDE_COSINE = 0.7  # less than this off straight ahead or straight behind is from the side

# Slides
SLIDE_REACH, TRIP_REACH = 0.75, 1.22  # m from the body to the ball, and to the carrier's body
LEGS_OUT = SLIDE_TIME - 0.05  # s left of a slide until which it reaches nobody
SLIDE_RATE, SLIDE_MOVING = 10.0, 0.5  # wins per s within reach of a ball that passes at more than this many m/s
SHIELDED = 0.05  # share of that from behind, until he has slid past the carrier's body
# Chances to fell the carrier: who stands is not felled from behind
FOUL_SIDE, FOUL_SIDE_RUNNING, FOUL_BEHIND, FOUL_FRONT = 0.97, 0.87, 0.95, 0.03
SEVERITY, SEVERITY_STANDING, SEVERITY_RUNNING = 1.0, 0.5, 0.9  # of never meeting the ball; more from beside or behind


@kernel
def in_tackle_reach(match, i, distance):
    """Tell whether player i, this far from the ball, tries for it, past the carrier's body if need be.

    Who stands idly beside a carrier who stands does not.
    """
    player, ball, carrier = match.players[i], match.ball, match.players[match.carrier]
    if ball.z > TACKLE_BELOW:
        return False
    idles = length(player.desired_vx, player.desired_vy) < IDLES and length(player.vx, player.vy) < IDLES
    if idles and length(carrier.vx, carrier.vy) < STANDING:
        return False
    return distance < TACKLE_REACH or (apart(player, carrier) < CONTACT and apart(ball, carrier) < AT_FEET)


@kernel
def goes_for_ball(match, i, distance):
    """Tell whether the way that player i wants to go leads to the ball, this far from him; who stands lets it come.

    A built-in player does not try past the carrier's body, nor when they run at each other too fast.
    """
    player, ball = match.players[i], match.ball
    carrier = match.players[match.carrier]
    want = length(player.desired_vx, player.desired_vy)
    along = player.desired_vx * (ball.x - player.x) + player.desired_vy * (ball.y - player.y)
    if along < MEANT_COSINE * want * distance:
        return False
    if player.action != BUILTIN_AI:
        return True
    to_x, to_y = toward(carrier.x - player.x, carrier.y - player.y)
    ball_x, ball_y = toward(ball.x - carrier.x, ball.y - carrier.y)
    slow = length(ball.vx - player.vx, ball.vy - player.vy) < PASSING_MOST
    return slow and to_x * ball_x + to_y * ball_y < SHIELDING_COSINE


@kernel
def tackle(match, i):
    """Let player i try to take the ball off the carrier's feet."""
    player, carrier = match.players[i], match.players[match.carrier]
    front, speed = frontal(player, carrier), length(carrier.vx, carrier.vy)
    chance = (TACKLE_CHANCE - TACKLE_HURRIED * speed) * share_of_skill(player) * within_reach(match, i, SWERVE)
    chance *= 1.0 + CLUMSY * (1.0 - carrier.skill) ** 2
    if front < BEHIND_COSINE:
        chance *= TACKLE_BEHIND
    if uniform(match) < chance:
        win(match, i)
        return
    player.touch_wait = TACKLE_WAIT
    if speed > STANDING:
        player.down_wait = max(player.down_wait, BEATEN_DOWN)
        if front < SIDE_COSINE and uniform(match) < TRIP_CHANCE:
            report_foul(match, i, match.carrier, 0.0, False)


@kernel
def share_of_skill(player):
    """Share of the chance to win the ball that a player of his skill has; 1 for the one who was measured."""
    return SKILL_LEAST + (SKILL_MOST - SKILL_LEAST) * player.skill


@kernel
def slide_into(match, i, distance):
    """Let player i, sliding this far from the ball, win it or fell the carrier if either is in his reach."""
    player, carrier, ball = match.players[i], match.players[match.carrier], match.ball
    if player.down_wait > LEGS_OUT:
        return
    front = frontal(player, carrier)
    if apart(player, carrier) < TRIP_REACH and not player.is_slide_spent:
        player.is_slide_spent = True
        runs = length(carrier.vx, carrier.vy) > STANDING
        if uniform(match) < foul_chance(front, runs):
            most = SEVERITY_RUNNING * uniform(match) if runs else SEVERITY_STANDING
            player.touch_wait = TACKLE_WAIT
            report_foul(match, i, match.carrier, SEVERITY + most, True)
            return
    passes = length(ball.vx - player.vx, ball.vy - player.vy)
    if distance > SLIDE_REACH or ball.z > TACKLE_BELOW or passes < SLIDE_MOVING:
        return
    rate = SLIDE_RATE * share_of_skill(player)
    same_way = player.facing_x * carrier.facing_x + player.facing_y * carrier.facing_y
    if same_way > SIDE_COSINE and distance > apart(ball, carrier):
        rate *= SHIELDED
    if uniform(match) < rate * DT:
        win(match, i)


@kernel
def foul_chance(front, runs):
    """Chance that a slide fells the carrier: from the side nearly always, from behind if he runs, seldom frontal."""
    if abs(front) < SIDE_COSINE:
        return FOUL_SIDE_RUNNING if runs else FOUL_SIDE
    if front > 0.0:
        return FOUL_FRONT
    return FOUL_BEHIND if runs else FOUL_FRONT


@kernel
def frontal(player, carrier):
    """Cosine of where a player comes from, seen from the carrier: 1 from ahead of him, -1 from behind."""
    ux, uy = toward(player.x - carrier.x, player.y - carrier.y)
    return ux * carrier.facing_x + uy * carrier.facing_y


@kernel
def win(match, i):
    """Give player i the ball of the carrier, who cannot take it back at once."""
    match.players[match.carrier].touch_wait = ROBBED_WAIT
    take(match, i)
    if match.carrier == i:
        ball = match.ball
        ball.vx, ball.vy = WON_SPEED * ball.vx, WON_SPEED * ball.vy


@kernel
def within_reach(match, i, widest):
    """Share of player i's chance to win the ball that is left by a carrier who swerves across his reach.

    At `widest` m/s across it the ball cannot be won.
    """
    player, ball, carrier = match.players[i], match.ball, match.players[match.carrier]
    dx, dy = ball.x - player.x, ball.y - player.y
    swerve = abs(carrier.vx * dy - carrier.vy * dx) / (length(dx, dy) + 1e-9)
    return max(1.0 - swerve / widest, 0.0)
