"""The ten frames of a step: bodies, ball and their meetings, until the ball leaves the pitch.

Read next: `physics.ball`, `physics.bodies`, `skills.contacts`, one per line of `play_frames`.
"""

from __future__ import annotations

from envs.football.constants import DT, FRAMES, NOBODY, NORMAL
from envs.football.physics.ball import advance_ball
from envs.football.physics.bodies import advance_player, crowded, keep_on_pitch, part_bodies
from envs.football.rules.offside import mark_offside
from envs.football.rules.whistle import off_pitch
from envs.football.skills.contacts import meet_ball, reachable
from envs.football.skills.hands import carry_in_hands
from envs.football.skills.kicks import swing_frame
from scenic_lite.kernels.jit import kernel


@kernel
def play_frames(match):
    """Move everything on by one step of 100 ms; the ball stops where it leaves the pitch."""
    bits = reachable(match)
    close = crowded(match)
    in_play = match.game_mode == NORMAL
    for _ in range(FRAMES):
        for i in range(match.num_players):
            advance_player(match.players[i])
        if close:
            part_bodies(match)
        if not in_play:
            continue
        if match.kicker != NOBODY and swing_frame(match):
            bits = reachable(match)
            mark_offside(match, match.last_touch)
        if match.keeper_holding != NOBODY:
            carry_in_hands(match)
        else:
            advance_ball(match.ball)
            in_play = not off_pitch(match)
            if bits != 0 and in_play:
                meet_ball(match, bits)
                in_play = match.game_mode == NORMAL
        match.save_wait -= DT
    for i in range(match.num_players):
        keep_on_pitch(match.players[i])
