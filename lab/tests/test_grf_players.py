"""Scripted players of whole matches: their actions in hand-made situations, and the counts of a match."""

import numpy as np
import pytest

from lab.grf import players
from lab.grf.players import Dodger, Passer, Player, Sight
from regista.envs.football.constants import DIRECTION_RIGHT, SHORT_PASS, SHOT, SPRINT

TOP_RIGHT, TOP, BOTTOM_RIGHT = 4, 3, 6  # direction keys


def sight(me=(0.0, 0.0), ball=None, mates=(), opponents=(), mine=True):
    """Return the observation of one agent, with the ball at its feet by default."""
    nobody = np.full((1, 1, 2), np.nan)
    return Sight(
        np.array([me]),
        np.array([me if ball is None else ball]),
        np.array([mates]) if mates else nobody,
        np.array([opponents]) if opponents else nobody,
        np.array([mine]),
    )


def pressed(player, seen, monkeypatch, steps=1):
    """Return the actions of some steps, except for sprint actions."""
    monkeypatch.setattr(players, "look", lambda matches: seen)
    player.begin(1)
    return [int(player(None, 8 * step)[0]) for step in range(steps)]


@pytest.mark.parametrize("kind", [Player, Dodger, Passer])
def test_all_run_at_the_goal_with_the_ball_and_at_the_ball_without(kind, monkeypatch):
    assert pressed(kind(), sight(), monkeypatch) == [DIRECTION_RIGHT]
    assert pressed(kind(), sight(ball=(3.0, 3.0), mine=False), monkeypatch) == [TOP_RIGHT]


@pytest.mark.parametrize("kind", [Player, Dodger, Passer])
def test_all_shoot_from_near_and_press_sprint_now_and_then(kind, monkeypatch):
    assert pressed(kind(), sight(me=(40.0, 0.0)), monkeypatch) == [SHOT]
    monkeypatch.setattr(players, "look", lambda matches: sight())
    player = kind()
    player.begin(1)
    assert player(None, 1)[0] == SPRINT


def test_the_dodger_turns_away_from_who_is_close_and_in_front(monkeypatch):
    assert pressed(Dodger(), sight(opponents=[(3.0, 1.0)]), monkeypatch) == [BOTTOM_RIGHT]
    assert pressed(Dodger(), sight(opponents=[(3.0, -1.0)]), monkeypatch) == [TOP_RIGHT]
    for harmless in ((-3.0, 0.0), (9.0, 0.0)):  # behind, and far
        assert pressed(Dodger(), sight(opponents=[harmless]), monkeypatch) == [DIRECTION_RIGHT]
    assert pressed(Player(), sight(opponents=[(3.0, 1.0)]), monkeypatch) == [DIRECTION_RIGHT]


def test_the_passer_turns_to_a_free_mate_ahead_and_passes_then(monkeypatch):
    mates = [(-8.0, 0.0), (1.0, 12.0), (12.0, -12.0)]
    marked = (12.0, -10.0)  # beside the foremost mate
    assert pressed(Passer(), sight(mates=mates, opponents=[(2.0, 0.0), marked]), monkeypatch, 2) == [TOP, SHORT_PASS]
    assert pressed(Passer(), sight(mates=mates, opponents=[(2.0, 0.0)]), monkeypatch, 2) == [
        BOTTOM_RIGHT - 0,
        SHORT_PASS,
    ]
    assert pressed(Passer(), sight(mates=mates[:1], opponents=[(2.0, 0.0)]), monkeypatch, 2) == [DIRECTION_RIGHT] * 2
    assert pressed(Passer(), sight(mates=mates, opponents=[(9.0, 0.0)]), monkeypatch, 2) == [DIRECTION_RIGHT] * 2


def test_a_match_is_played_whole_and_counted(monkeypatch):
    monkeypatch.setattr(players, "STEPS", 60)
    played = players.play_matches("runner", 0.05, 2)
    assert (played.lengths == 60).all()
    found = players.numbers(played)
    assert found["goals_for"] == played.score[:, 0].mean()
    assert 0 < found["possession"] <= 1
