"""One step of a match: the decisions for all players, then ten stages of football.

A step lasts 0.1 s and has one decision per player. Each stage is a function in another module and changes only MATCH.
Read next: `state` for the record, then the stages in their order.
"""

from __future__ import annotations

from regista.envs.football.ai.decide import choose_command, read_game
from regista.envs.football.ai.keeper import kick_out_if_overdue
from regista.envs.football.ai.set_pieces import wait_for_restart
from regista.envs.football.constants import BUILTIN_AI, RUNNING, STAND
from regista.envs.football.control.actions import apply_action, release_sticky_actions
from regista.envs.football.control.active_player import settle_first_step
from regista.envs.football.control.agents import (
    apply_commanded_actions,
    assign_actions,
    choose_controlled,
    record_desired_actions,
    set_actions,
)
from regista.envs.football.control.episode import end_episode
from regista.envs.football.control.reward import add_checkpoint_rewards, clear_rewards
from regista.envs.football.frames import play_frames
from regista.envs.football.physics.dribble import dribble
from regista.envs.football.physics.motion import plan_motion
from regista.envs.football.physics.possession import advance_timers, find_chasers
from regista.envs.football.rules.offside import mark_offside
from regista.envs.football.rules.referee import apply_rules, forget_events
from regista.envs.football.scenic.scripted_step import command_players, run_program_behaviors, run_program_monitors
from regista.envs.football.skills.kicks import swing_legs
from regista.kernels.jit import kernel


@kernel
def step_match(match, actions, code, cast, registers, commands):
    """Step a match by 0.1 s with the agents' `actions` [A] (0..18).

    The other four arguments belong to the program (see `scenic.scripted_step`); they are None without a program. An
    ended match stays unchanged.
    """
    if choose_actions(match, actions, code, cast, registers, commands):
        play(match)
        run_program_monitors(match, code, cast, registers, commands)


@kernel
def choose_actions(match, actions, code, cast, registers, commands):
    """Begin a step and give every player an action; return whether the match goes on."""
    if not begin_step(match):
        return False
    if not run_program_behaviors(match, code, cast, registers, commands):
        return False
    assign_actions(match, actions)
    if cast is not None:
        command_players(match, cast.players, commands)
    apply_commanded_actions(match)
    return True


@kernel
def play(match):
    """Play a step in which every player has an action."""
    if match.step == 0:
        settle_first_step(match)
    if not wait_for_restart(match):
        play_on(match)
    record_desired_actions(match)
    play_frames(match)
    advance_timers(match)
    apply_rules(match)
    end_episode(match)
    choose_controlled(match)
    add_checkpoint_rewards(match)


@kernel
def play_on(match):
    """Let all players perceive, decide, and respond with body and ball."""
    find_chasers(match)
    read_game(match)
    decide(match)
    plan_motions(match)
    swing_legs(match)
    if dribble(match):
        mark_offside(match, match.carrier)


@kernel
def decide(match):
    """Turn every player's action into a desired velocity and perhaps a kick."""
    for i in range(match.num_players):
        player = match.players[i]
        if player.action == BUILTIN_AI:
            release_sticky_actions(match, i)
            choose_command(match, i)
        elif player.action == STAND:
            release_sticky_actions(match, i)
            player.desired_vx, player.desired_vy = 0.0, 0.0
        else:
            apply_action(match, i, player.action)
            kick_out_if_overdue(match, i)


@kernel
def plan_motions(match):
    """Let every body respond to its desired velocity."""
    for i in range(match.num_players):
        plan_motion(match, i)


@kernel
def begin_step(match):
    """Clear the results of the last step; return whether the match goes on."""
    forget_events(match)
    clear_rewards(match)
    return match.ended == RUNNING


def step_matches(matches, actions):
    """Step matches MATCH [N] without programs, with the agents' actions [N, A]: 0..18."""
    _step_matches(matches, actions, False)


def step_everybody(matches, actions):
    """Step matches MATCH [N] with an action for every player, [N, P]: 0..18, BUILTIN_AI or STAND."""
    _step_matches(matches, actions, True)


@kernel
def _step_matches(matches, actions, everybody):
    """Step matches one after the other. Both callers share this kernel, since its compilation takes twenty seconds."""
    for e in range(len(matches)):
        match = matches[e]
        if everybody:
            goes_on = begin_step(match)
            if goes_on:
                set_actions(match, actions[e])
        else:
            goes_on = choose_actions(match, actions[e], None, None, None, None)
        if goes_on:
            play(match)
