"""The built-in AI: shared perception of both teams, then one decision per step for each player without a command.

Team decisions (slots, markers, runs) are made every few steps. Read next: `ai.balance`, `ai.positions`,
`ai.marking`; then `ai.keeper`, `ai.attack`.
"""

from __future__ import annotations

from regista.envs.football.ai.attack import meet_free_ball, play_ball
from regista.envs.football.ai.balance import remember
from regista.envs.football.ai.defence import goes_for_led_ball, must_move, set_defensive_lines, tackle, tackles
from regista.envs.football.ai.formation import EXCHANGED_EVERY, exchange_slots, follow_ball
from regista.envs.football.ai.keeper import choose_keeper_command
from regista.envs.football.ai.marking import choose_markers, choose_pressers, presses
from regista.envs.football.ai.positions import take_position
from regista.envs.football.ai.run_speed import REACTION, reaction_time
from regista.envs.football.ai.support import choose_runners
from regista.envs.football.constants import GK, LEFT, NOBODY, NORMAL, RIGHT, STEP
from regista.envs.football.physics.possession import first_at_ball, man_on_ball, owns
from regista.envs.football.skills.steering import go_for_ball
from regista.kernels.jit import kernel
from regista.kernels.rng import uniform

MARKED_EVERY, MARKED_AT = 4, 3  # steps: period and phase; no player is marked at the beginning
SOONER, SOONER_SLACK = 0.85, 0.01  # factor of the time of the first team so far, to a free ball; s, added to both times
LATE, LATE_SHARE = 0.2, 2.0  # limits of a run: s, for a player without a mark; ratio to the opponents' time


@kernel
def read_game(match):
    """Update both teams' players at the ball, and every few steps slots and markers."""
    count_possession(match)
    find_team_in_possession(match)
    remember(match)
    follow_ball(match)
    set_defensive_lines(match)
    on_ball = first_at_ball(match)
    if on_ball != NOBODY and match.step % EXCHANGED_EVERY == 0:
        exchange_slots(match, on_ball)
    if match.step % MARKED_EVERY == MARKED_AT:
        choose_markers(match)
    choose_runners(match)
    choose_pressers(match)


@kernel
def count_possession(match):
    """Count how long the last carrier has had the ball."""
    match.carry_age += 1
    if match.carrier != NOBODY and match.carrier != match.last_carrier:
        match.last_carrier, match.carry_age = match.carrier, 0


@kernel
def find_team_in_possession(match):
    """Find the team that has the ball or will be first at it; for a free ball this only changes if the other team is
    clearly sooner.
    """
    team = match.team_in_possession
    if match.carrier != NOBODY:
        match.team_in_possession = match.players[match.carrier].team
    elif team == NOBODY:
        if match.arrival[LEFT] != match.arrival[RIGHT]:
            match.team_in_possession = LEFT if match.arrival[LEFT] < match.arrival[RIGHT] else RIGHT
    elif match.arrival[1 - team] + SOONER_SLACK < SOONER * (match.arrival[team] + SOONER_SLACK):
        match.team_in_possession = 1 - team


@kernel
def choose_command(match, i):
    """Decide for player i."""
    player = match.players[i]
    if player.down_wait > 0.0:
        return
    if player.role == GK:
        choose_keeper_command(match, i)
    elif unaware_of_kick(match, player):
        return  # the last decision remains in force
    elif match.carrier == i:
        play_ball(match, i)
    elif goes_for_free_ball(match, i):
        meet_free_ball(match, i)
    elif goes_for_led_ball(match, i):
        return
    elif match.team_in_possession != player.team and tackles(match, player):
        tackle(match, i)
    elif presses(match, i) and must_move(player, match.players[man_on_ball(match, 1 - player.team)]):
        go_for_ball(match, i, player.top_speed)
    else:
        take_position(match, i)


@kernel
def unaware_of_kick(match, player):
    """Return whether the ball has just been kicked and the player has not reacted yet."""
    if match.carrier != NOBODY or match.kick_age > player.reaction_time * REACTION.unskilled + 0.5 * STEP:
        return False
    return match.kick_age < reaction_time(player) + (uniform(match) - 0.5) * STEP


@kernel
def goes_for_free_ball(match, i):
    """Return whether player i runs for a free ball: it is the first of its team there, and not much later than the
    opponents.

    If an opponent is near enough to count as the owner, the player must not be later, even before the opponent's first
    touch. A player who marks an opponent abandons the ball sooner.
    """
    team = match.players[i].team
    if match.carrier != NOBODY or match.chaser[team] != i or match.game_mode != NORMAL:
        return False
    rival = match.chaser[1 - team]
    if rival != NOBODY and match.arrival[team] > match.arrival[1 - team] and owns(match.ball, match.players[rival]):
        return False
    late = LATE if match.players[i].marked_opponent == NOBODY else 0.0
    return match.arrival[team] < LATE_SHARE * match.arrival[1 - team] + late
