"""How surely opponents intercept a ball that is played along a lane."""

from __future__ import annotations

from pitch import OPEN, position

from regista.envs.football.ai.interception import danger
from regista.envs.football.constants import CB, CM, GK, LEFT, RIGHT

KEEPERS = [(-54.0, 0.0, LEFT, GK), (54.0, 30.0, RIGHT, GK)]
TARGET = (15.0, 0.0)


def danger_from(*rivals: tuple[float, float], overhead: float = 0.0) -> float:
    """Return danger of the lane from the middle of the pitch to TARGET, with opponents at these places."""
    players = [*KEEPERS, (-0.4, 0.0, LEFT, CM), *((x, y, RIGHT, CB) for x, y in rivals)]
    return danger(position(players, (0.0, 0.0), OPEN)[0], LEFT, 0.0, 0.0, *TARGET, overhead, 1.0)


def test_a_free_lane_is_safe() -> None:
    assert danger_from() == 0.0
    assert danger_from((-3.0, 0.5), (25.0, 0.0), (15.0, 20.0)) == 0.0  # behind, beyond, far aside


def test_who_stands_in_the_lane_has_the_ball() -> None:
    assert danger_from((15.0, 1.0)) == 1.0


def test_danger_falls_with_the_distance_to_the_lane_and_adds_up() -> None:
    near, far = danger_from((12.0, 5.0)), danger_from((12.0, 7.0))
    assert 0.0 < far < near < 1.0
    assert danger_from((12.0, 5.0), (12.0, -7.0)) > near + 0.9 * far


def test_a_high_ball_passes_over_who_is_near_the_passer() -> None:
    assert danger_from((4.0, 0.5)) > 0.3
    assert danger_from((4.0, 0.5), overhead=0.6) == 0.0
    assert danger_from((14.0, 0.5), overhead=0.6) == danger_from((14.0, 0.5))
