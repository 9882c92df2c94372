"""How a scene begins: bodies under way, the first touch in the run, and where keepers go, by Google Research Football.

Places are its medians over 10 episodes each of run_to_score_with_keeper and 3_vs_1_with_keeper, in its units.
"""

from __future__ import annotations

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import CB, CF, DIRECTION_RIGHT, GK, LEFT, NOBODY, RIGHT, SPRINT
from regista.envs.football.vector_env import FootballVectorEnv
from tests.envs.pitch import play, position

UNIT = 54.4  # m


def sprint(steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x of the striker, of the ball and of the keepers [2] in units over a sprint at a ball 1.1 m ahead."""
    players = [(0.0, 0.0, LEFT, CF), (-55.0, 0.0, LEFT, GK), (55.0, 0.0, RIGHT, GK)]
    matches = position(players, (1.09, 0.0))
    x, ball, keepers = [], [], []
    for key in [DIRECTION_RIGHT, SPRINT] + [0] * (steps - 2):
        play(matches, [key])
        x.append(matches["players"]["x"][0, 0] / UNIT)
        ball.append(matches["ball"]["x"][0] / UNIT)
        keepers.append(matches["players"]["x"][0, 1:3] / UNIT)
    return np.array(x), np.array(ball), np.array(keepers)


def test_a_sprint_from_rest_loses_a_step() -> None:
    """Measured: nothing in the first step, then 1.1, 2.2, 3.0, 4.1 m/s, with the touch in the run."""
    x, ball, _ = sprint(20)
    assert x[0] == 0.0
    assert x[[3, 7, 12, 19]] == pytest.approx([0.012, 0.046, 0.097, 0.189], abs=0.012)
    assert np.all((ball - x)[3:10] * UNIT > 0.35), "the ball stays before him, it does not lie under his body"


FAR_APART = """
LeftGK at -100 @ 0, with regionContainedIn everywhere
ego = LeftCM at 18 @ -14
ball = Ball at 20 @ -14
RightGK at 99 @ 0
RightCB at -72 @ 0
"""


@pytest.mark.slow
def test_the_first_whistle_finds_bodies_anywhere_in_their_idle_movement() -> None:
    """Measured in 16 episodes: the ball, 1 m ahead, is touched in step 2 once, in 3, 4, 5 five, seven, three times; the
    keeper runs .62 m in 4 steps; after 4, 8 and 12 his way deviates by .26, .40, .49 m.
    """
    env = FootballVectorEnv(FAR_APART, 400, config=FootballConfig(control="active"))
    env.reset(seed=0)
    start, touched, run = env.matches["players"]["x"][:, 0].copy(), np.zeros(400, int), []
    for step in range(1, 13):
        env.step(np.full(400, DIRECTION_RIGHT if step == 1 else 0))
        touched[(touched == 0) & (env.matches["reported_owner"] >= 0)] = step
        run.append(np.abs(env.matches["players"]["x"][:, 0] - start))
    assert set(touched) <= {2, 3, 4, 5, 6} and {3, 4, 5} <= set(touched)
    assert touched.mean() == pytest.approx(3.75, abs=0.25)
    assert np.mean(run[3]) == pytest.approx(0.62, abs=0.2)
    assert np.std(run, axis=1)[[3, 7, 11]] == pytest.approx([0.26, 0.40, 0.49], abs=0.12)


def test_keepers_run_up_to_their_high_line_at_a_sprint_after_a_step() -> None:
    """Measured: -1.011 -1.008 -.997 -.980 -.960 -.936 -.898 at steps 1, 2, 4, 6, 8, 10 and 13, then -.83."""
    _, _, keepers = sprint(24)
    assert -keepers[[1, 3, 5, 7, 9, 12], 0] == pytest.approx([1.008, 0.997, 0.980, 0.960, 0.936, 0.898], abs=0.006)
    assert -keepers[23, 0] == pytest.approx(0.83, abs=0.01)


def test_a_keeper_waits_before_his_line() -> None:
    """Measured: .988, where a mate stands between the ball and his goal."""
    players = [(36.0, 0.0, LEFT, CF), (-54.0, 0.0, LEFT, GK), (55.0, 0.0, RIGHT, GK), (42.0, 0.0, RIGHT, CB)]
    matches = position(players, (36.5, 0.0))
    play(matches, [0] * 9)
    assert matches["players"]["x"][0, 2] / UNIT == pytest.approx(0.988, abs=0.004)


def test_outside_his_box_a_keeper_knocks_the_ball_loose() -> None:
    players = [(30.0, 0.0, LEFT, CF), (-54.0, 0.0, LEFT, GK), (31.5, 0.0, RIGHT, GK)]
    matches = position(players, (30.5, 0.0), seeds=range(50))
    loose = np.zeros(50, bool)
    for key in [DIRECTION_RIGHT] * 15:
        play(matches, [key])
        loose |= (matches["last_touch"] == 2) & (matches["carrier"] == NOBODY)
        assert not np.any(matches["keeper_holding"] == 2)
    assert loose.mean() > 0.3
