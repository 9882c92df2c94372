"""The record: what a fresh match holds, settings as values or arrays, and clear errors."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import duel

from regista.envs.football.constants import CM, GK
from regista.envs.football.kick_off import MatchConfig, Roster, kick_off
from regista.envs.football.state import BALL_FIELDS, ENGINE_FIELDS, MATCH, MATCH_FIELDS, PLAYER_FIELDS
from regista.kernels.rng import streams, uniform


def test_every_field_is_declared_once() -> None:
    for table in (BALL_FIELDS, ENGINE_FIELDS, PLAYER_FIELDS, MATCH_FIELDS):
        names = [row[0] for row in table]
        assert len(names) == len(set(names))
    assert set(MATCH.names) == {row[0] for row in MATCH_FIELDS} | {"ball", "engine", "players"}


def test_a_fresh_match() -> None:
    matches = duel((30.0, 1.0), (50.0, 2.0), range(3))
    assert matches.dtype == MATCH or matches.dtype.descr == MATCH.descr
    assert matches["num_players"].tolist() == [3, 3, 3]
    assert matches["players"]["x"][0, :3].tolist() == [30.0, 50.0, -53.9]
    assert matches["players"]["shirt"][0, :3].tolist() == [0, 0, 1]
    players = matches["players"][0, :3]
    away = np.stack([30.0 - players["x"], 2.76 - players["y"]])  # everybody looks at the ball
    assert np.stack([players["facing_x"], players["facing_y"]]) == pytest.approx(away / np.hypot(*away))
    assert (matches["agents"][:, 0] == 0).all()
    assert (matches["reported_owner"] == -1).all() and (matches["last_owned_team"] == -1).all()
    assert matches["players"]["skill"][0, :2] == pytest.approx([1.0, 0.72])
    assert len(np.unique(matches["random"])) == 3


def test_settings_may_differ_between_matches() -> None:
    config = MatchConfig(game_duration=[10, 20], right_team_difficulty=[0.0, 1.0], deterministic=[True, False])
    roster = Roster([0, 1], [CM, GK])
    matches = kick_off(np.zeros((2, 2, 2)) + [[0, 0], [40, 0]], np.zeros((2, 2)), roster, [7, 7], config)
    assert matches["game_duration"].tolist() == [10, 20]
    assert matches["players"]["skill"][:, 1] == pytest.approx([0.3, 1.0])
    assert matches["random"][0] != matches["random"][1]


@pytest.mark.parametrize(
    ("positions", "ball", "teams", "sentence"),
    [
        (np.zeros((1, 2, 3)), np.zeros((1, 2)), [0, 1], "positions must be"),
        (np.zeros((2, 2, 2)), np.zeros((1, 2)), [0, 1], "positions must be"),
        (np.zeros((1, 3, 2)), np.zeros((1, 2)), [0, 1], "3 players, teams"),
        (np.zeros((1, 23, 2)), np.zeros((1, 2)), [0] * 23, "1 to 22 players, not 23"),
    ],
)
def test_errors(positions: np.ndarray, ball: np.ndarray, teams: list[int], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        kick_off(positions, ball, Roster(teams, [CM] * len(teams)), [0])


@pytest.mark.slow
def test_random_streams_are_even_and_independent() -> None:
    matches = duel((30.0, 1.0), (50.0, 2.0), range(200))
    draws = np.array([[uniform(match) for _ in range(50)] for match in matches])
    assert draws.min() >= 0.0 and draws.max() < 1.0
    assert draws.mean() == pytest.approx(0.5, abs=0.02)
    assert draws.std() == pytest.approx(12**-0.5, abs=0.02)
    assert abs(np.corrcoef(draws[:, 0], draws[:, 1])[0, 1]) < 0.25
    assert abs(np.corrcoef(draws[:-1, 0], draws[1:, 0])[0, 1]) < 0.25
    assert (streams([0, 2**63]) != 0).all()
