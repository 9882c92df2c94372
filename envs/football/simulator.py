"""One step of a match as a recipe.

Each stage stands in the file of that name. Read next: `state` for the record, then the stages in their order.
"""

from __future__ import annotations

from envs.football.ai.decide import read_game, think
from envs.football.ai.keeper import hurry
from envs.football.constants import BUILTIN_AI, NOBODY, RUNNING, STAND
from envs.football.control.agents import assign_actions, choose_controlled
from envs.football.control.keys import obey, release_keys
from envs.football.control.reward import pay_checkpoints
from envs.football.physics.dribble import lead_ball
from envs.football.physics.frames import play_frames
from envs.football.physics.kicks import swing_legs
from envs.football.physics.motion import plan_motion
from envs.football.physics.possession import find_chasers, tick
from envs.football.rules.offside import mark_offside
from envs.football.rules.referee import apply_rules, begin_step
from envs.football.rules.restarts import wait_for_restart
from scenic_lite.kernels.jit import kernel


@kernel
def step_match(match, actions):
    """Move a match on by one step of 0.1 s in which the agents' players take `actions` [A] (0..18).

    A match that has ended stays as it is and pays nothing.
    """
    begin_step(match)
    if match.ended != RUNNING:
        return
    assign_actions(match, actions)
    play(match)


@kernel
def play(match):
    """Move a match on in which every player has his action."""
    if match.taker != NOBODY:
        wait_for_restart(match)
    if match.taker == NOBODY:
        find_chasers(match)
        read_game(match)
        decide(match)
        plan_motions(match)
        swing_legs(match)
        if lead_ball(match):
            mark_offside(match, match.carrier)
    play_frames(match)
    tick(match)
    apply_rules(match)
    choose_controlled(match)
    pay_checkpoints(match)


@kernel
def decide(match):
    """Turn every player's action into a wanted velocity and perhaps a kick."""
    for i in range(match.num_players):
        player = match.players[i]
        if player.action == BUILTIN_AI:
            release_keys(match, i)
            think(match, i)
        elif player.action == STAND:
            release_keys(match, i)
            player.want_x, player.want_y = 0.0, 0.0
        else:
            obey(match, i, player.action)
            hurry(match, i)


@kernel
def step_teams(match, actions):
    """Move a match on by one step in which every player has his own action [P]: 0..18, BUILTIN_AI or STAND.

    A match that has ended stays as it is.
    """
    begin_step(match)
    if match.ended != RUNNING:
        return
    for i in range(match.num_players):
        match.players[i].action = actions[i]
    play(match)


@kernel
def plan_motions(match):
    """Let every body answer what its player wants."""
    for i in range(match.num_players):
        plan_motion(match, i)


@kernel
def step_matches(matches, actions):
    """Move matches MATCH [N] on by one step each, with actions [N, A]; bare, one after the other (see `batch`)."""
    for e in range(len(matches)):
        step_match(matches[e], actions[e])
