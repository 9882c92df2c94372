"""The built-in AI: what both teams see of the match, then one decision per player and step for all without a command.

Decisions of a team (slots, markers, runs) are made anew every few steps. Read next: `ai.formation`, `ai.marking`; then
`ai.keeper`, `ai.attack`, `ai.support`, `ai.defence`.
"""

from __future__ import annotations

from envs.football.ai.attack import meet_free_ball, play_ball
from envs.football.ai.defence import defend
from envs.football.ai.formation import exchange_slots, remember_ball
from envs.football.ai.keeper import choose_keeper_command
from envs.football.ai.marking import choose_markers, choose_pressers
from envs.football.ai.run_speed import REACTION, reaction_time
from envs.football.ai.support import start_runs, support
from envs.football.constants import GK, LEFT, NOBODY, NORMAL, RIGHT, STEP
from envs.football.physics.possession import ball_speed, meeting_time
from scenic_lite.kernels.jit import kernel
from scenic_lite.kernels.rng import uniform

SLOTS_EVERY, MARKS_EVERY = 10, 5  # steps
LATE = 0.3  # s behind the opponents at a free ball: further behind, nobody runs for it


@kernel
def read_game(match):
    """See for both teams who has or gets the ball, and every few steps who belongs where and marks whom."""
    remember_ball(match)
    count_possession(match)
    changed = find_team_in_possession(match)
    if match.step % SLOTS_EVERY == 0:
        exchange_slots(match)
    if changed or match.step % MARKS_EVERY == 0:
        choose_markers(match)
        start_runs(match)
    choose_pressers(match)


@kernel
def count_possession(match):
    """Count for how long the last player on the ball has had it."""
    match.carry_age += 1
    if match.carrier != NOBODY and match.carrier != match.last_carrier:
        match.last_carrier, match.carry_age = match.carrier, 0


@kernel
def find_team_in_possession(match):
    """Find the team that has the ball or will be first at it; return whether it is another than before."""
    before = match.team_in_possession
    if match.carrier != NOBODY:
        match.team_in_possession = match.players[match.carrier].team
        return match.team_in_possession != before
    match.arrival_lead = arrival_lead(match)
    if match.arrival_lead != 0.0:
        match.team_in_possession = LEFT if match.arrival_lead < 0.0 else RIGHT
    return match.team_in_possession != before


@kernel
def arrival_lead(match):
    """Return the seconds by which the left team's first player at a free ball is later than the right team's."""
    left, right = match.chaser[LEFT], match.chaser[RIGHT]
    if left == NOBODY or right == NOBODY:
        return -1.0 if right == NOBODY else 1.0
    speed = ball_speed(match.ball)
    return meeting_time(match, match.players[left], speed) - meeting_time(match, match.players[right], speed)


@kernel
def choose_command(match, i):
    """Decide for player i."""
    player = match.players[i]
    if player.down_wait > 0.0:
        return
    if player.role == GK:
        choose_keeper_command(match, i)
    elif unaware_of_kick(match, player):
        return  # he goes on with what he was doing
    elif match.carrier == i:
        play_ball(match, i)
    elif goes_for_free_ball(match, i):
        meet_free_ball(match, i)
    elif match.team_in_possession == player.team:
        support(match, i)
    else:
        defend(match, i)


@kernel
def unaware_of_kick(match, player):
    """Return whether the ball has just been kicked and a player has not reacted to that yet."""
    if match.carrier != NOBODY or match.kick_age > player.reaction_time * REACTION.unskilled + 0.5 * STEP:
        return False
    return match.kick_age < reaction_time(player) + (uniform(match) - 0.5) * STEP


@kernel
def goes_for_free_ball(match, i):
    """Return whether player i runs for a free ball: first of his team at it, and not much later than the opponents."""
    team = match.players[i].team
    if match.carrier != NOBODY or match.chaser[team] != i or match.game_mode != NORMAL:
        return False
    return (match.arrival_lead if team == LEFT else -match.arrival_lead) < LATE
