"""The ten physics frames of a step: bodies, ball and contacts, until the ball leaves the pitch.

Read next: `physics.ball`, `physics.bodies`, `skills.contacts`, one per line of `play_frames`.
"""

from __future__ import annotations

from regista.envs.football.constants import DT, FRAMES, NOBODY, NORMAL
from regista.envs.football.physics.ball import advance_ball
from regista.envs.football.physics.bodies import advance_players, crowded, keep_on_pitch, part_bodies
from regista.envs.football.rules.offside import mark_offside
from regista.envs.football.rules.whistle import off_pitch
from regista.envs.football.skills.contacts import meet_ball, reachable
from regista.envs.football.skills.hands import carry_in_hands
from regista.envs.football.skills.kicks import leave_foot, swing_frame
from regista.kernels.jit import kernel


@kernel
def play_frames(match):
    """Simulate the frames of one step of 100 ms; the ball stops where it leaves the pitch.

    As an optimization, a player far from the ball and all other players moves by several frames at once: at the end,
    and before a contact with the ball, when other code may read the position.
    """
    bits, crowd = reachable(match), crowded(match)
    near, behind = bits | crowd | bit_of(match.kicker) | bit_of(match.keeper_holding), 0
    in_play = match.game_mode == NORMAL
    for _ in range(FRAMES):
        if near != 0:
            advance_players(match, near, 1)
        behind += 1
        if crowd != 0:
            part_bodies(match, crowd)
        if not in_play:
            continue
        if match.kicker != NOBODY and swing_frame(match):
            behind = advance_players(match, ~near, behind)
            leave_foot(match, match.kicker, 1.0)
            bits = reachable(match)
            near |= bits
            mark_offside(match, match.last_touch)
        if match.keeper_holding != NOBODY:
            carry_in_hands(match)
        else:
            advance_ball(match.ball)
            in_play = not off_pitch(match)
            if bits != 0 and in_play:
                behind = meet_ball(match, bits, ~near, behind)
                in_play = match.game_mode == NORMAL
        match.save_wait -= DT
    advance_players(match, ~near, behind)
    for i in range(match.num_players):
        keep_on_pitch(match.players[i])


@kernel
def bit_of(i):
    """Return the bit of player i, 0 for NOBODY."""
    return 0 if i == NOBODY else 1 << i
