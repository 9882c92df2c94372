"""Offside, from drawn positions."""

from __future__ import annotations

from dataclasses import replace

import pytest
from pitch import OPEN, play, position

from regista.envs.football.constants import CB, CM, FREE_KICK, GK, LEFT, RIGHT, SHORT_PASS


@pytest.mark.parametrize(
    ("mate_x", "offsides", "whistle"), [(20.0, True, True), (14.0, True, False), (20.0, False, False)]
)
def test_a_pass_to_a_mate_behind_the_last_back(mate_x: float, offsides: bool, whistle: bool) -> None:
    """
    passer   back    mate        keeper      the mate at 20 is beyond the back at 16: offside
      o →     x       o            x
      5      16      20           54
    """
    players = [(5.0, 0.0, LEFT, CM), (mate_x, 2.0, LEFT, CM), (16.0, 9.0, RIGHT, CB), (54.0, 0.0, RIGHT, GK)]
    matches = position(players, (5.4, 0.0), replace(OPEN, offsides=offsides))
    modes = set()
    for action in [0, SHORT_PASS] + [0] * 18:
        play(matches, [action], player=0)
        mode = int(matches["game_mode"][0])
        modes.add(mode)
        assert mode != FREE_KICK or matches["restart_team"][0] == RIGHT
    assert (FREE_KICK in modes) == whistle


def test_in_the_own_half_nobody_is_offside() -> None:
    players = [(-25.0, 0.0, LEFT, CM), (-8.0, 2.0, LEFT, CM), (-30.0, 9.0, RIGHT, CB), (54.0, 0.0, RIGHT, GK)]
    matches = position(players, (-24.6, 0.0), replace(OPEN, offsides=True))
    for action in [0] * 4 + [SHORT_PASS] + [0] * 14:
        play(matches, [action], player=0)
        assert matches["game_mode"][0] != FREE_KICK
