"""An engine that differs from episode to episode: who sets its factors, and what each of them does."""

from __future__ import annotations

import numpy as np
import pytest
from pitch import duel, play, position

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import CB, CM, DIRECTION_RIGHT, GK, LEFT, RIGHT, SHORT_PASS, SHOT, SPRINT
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.scenic.domain import FACTORS
from regista.envs.football.scenic.lineup import NotAMatchError
from regista.envs.football.state import ENGINE
from regista.envs.football.vector_env import FootballVectorEnv

PROGRAM = """
param end_episode_on_possession_change = True
param game_duration = 20
{more}
ego = LeftCM at 0 @ 0
LeftGK at -99 @ 0
RightCM at 40 @ 0
RightGK at 99 @ 0
ball = Ball at 5 @ 0
"""


def made(more: str = "", count: int = 3, **settings) -> FootballVectorEnv:
    env = FootballVectorEnv(PROGRAM.format(more=more), count, config=FootballConfig(**settings))
    env.reset(seed=0)
    return env


def factors(env: FootballVectorEnv) -> np.ndarray:
    """Return the drawn columns `[N, 8]`."""
    return np.stack([env.matches["engine"][name] for name in ENGINE.names], axis=-1)


# ---------------------------------------------------------------- who sets them


def test_without_a_spread_all_factors_are_one() -> None:
    env = made()
    assert (factors(env)[:, :-1] == 1.0).all() and (factors(env)[:, -1] == 0.0).all()


def test_every_episode_draws_its_own_factors() -> None:
    env = made(count=200, engine_spread=0.15)
    first = factors(env)
    assert np.abs(first[:, :-1] - 1.0).max() <= 0.15 and first[:, :-1].std(axis=0) == pytest.approx(0.0866, abs=0.01)
    assert first[:, -1].min() >= 0.0 and first[:, -1].max() <= 0.15 and first[:, -1].mean() > 0.05
    players = env.matches["players"]
    speed = first[:, ENGINE.names.index("keeper_speed")]
    assert players["top_speed"][:, 0] == pytest.approx(7.75 * speed)
    assert players["top_speed"][:, 1] == pytest.approx(7.83)
    assert players["reaction_time"][:, 2] == pytest.approx(first[:, ENGINE.names.index("reaction_time")])
    for _ in range(20):
        env.step(np.zeros(200, int))
    second = factors(env)
    assert (second != first).all() and np.abs(second[:, :-1] - 1.0).max() <= 0.15
    again = made(count=200, engine_spread=0.15)
    assert (factors(again) == first).all()


def test_a_parameter_of_the_program_may_name_one_and_is_a_column_of_theta() -> None:
    env = made("param keeper_speed = Range(0.85, 1.15)\nparam tackle_odds = 1.2", count=3)
    assert [draw.name for draw in env.parameters] == ["keeper_speed"]
    env.reset(options={"theta": [[-1.0], [0.0], [1.0]]})
    engine = env.matches["engine"]
    assert engine["keeper_speed"] == pytest.approx([0.85, 1.0, 1.15])
    assert engine["tackle_odds"].tolist() == [1.2] * 3 and engine["keeper_range"].tolist() == [1.0] * 3
    assert env.matches["players"]["top_speed"][:, 0] == pytest.approx([7.75 * f for f in (0.85, 1.0, 1.15)])
    assert env.describe([[1.0]])[0]["keeper_speed"] == pytest.approx(1.15)


def test_a_spread_goes_around_what_the_program_says() -> None:
    env = made("param keeper_speed = 1.4\nparam engine_spread = 0.1", count=50)
    speed = env.matches["engine"]["keeper_speed"]
    assert speed.min() >= 1.4 * 0.9 and speed.max() <= 1.4 * 1.1 and speed.std() > 0.02


@pytest.mark.parametrize("name", sorted(FACTORS))
def test_what_is_no_factor_is_refused(name: str) -> None:
    with pytest.raises(NotAMatchError, match=f"param {name} must be a number .* not 4.5"):
        FootballVectorEnv(PROGRAM.format(more=f"param {name} = 4.5"))
    with pytest.raises(NotAMatchError, match=f"param {name} must be a number .* not -"):
        FootballVectorEnv(PROGRAM.format(more=f"param {name} = Range(-2, -1)"))


def test_a_spread_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match=r"engine_spread must be 0 or more and at most 0\.99"):
        FootballConfig(engine_spread=1.5)
    with pytest.raises(ValueError, match="engine_spread needs engine 'regista'"):
        FootballConfig(engine_spread=0.1, engine="grf")


# ---------------------------------------------------------------- what they do


def config(**settings: float) -> MatchConfig:
    return MatchConfig(
        end_episode_on_score=False,
        end_episode_on_out_of_play=False,
        end_episode_on_possession_change=False,
        use_magnet=False,
        **settings,
    )


def test_a_longer_lag_starts_later_with_and_without_the_ball() -> None:
    players = [(0.0, 0.0, LEFT, CM), (50.0, 30.0, RIGHT, GK)]
    for ball in ((0.4, 0.0), (40.0, 30.0)):
        places = []
        for lag in (0.5, 1.0, 1.5):
            matches = play(position(players, ball, config(start_lag=lag)), [0] * 5 + [DIRECTION_RIGHT] * 10)
            places.append(matches["players"]["x"][0, 0])
        assert places[0] > places[1] + 0.02 and places[1] > places[2] + 0.02


def test_a_keeper_of_more_range_comes_out_further() -> None:
    places = []
    for share in (0.5, 1.0):
        players = [(25.0, 0.0, LEFT, CM), (54.0, 0.0, RIGHT, GK), (-20.0, 0.0, RIGHT, CM), (-53.9, 0.0, LEFT, GK)]
        matches = position(players, (25.4, 0.0), config(keeper_range=share))
        places.append(play(matches, [DIRECTION_RIGHT] * 25, 0)["players"]["x"][0, 1])
    assert places[0] > places[1] + 3.0


def test_a_keeper_of_more_reach_saves_more() -> None:
    """From several places together: most shots go to where either every reach does, or none."""
    saved = []
    for reach in (0.6, 1.0, 1.6):
        shares = []
        for place in ((38.0, -6.0), (42.0, 0.0), (44.0, -4.0)):
            matches = duel(place, (54.0, 0.0), seeds=range(200), keeper_reach=reach)
            for key in (DIRECTION_RIGHT, 0, 0, SHOT, *[0] * 12):
                play(matches, [key], 0)
            shares.append(np.mean(matches["save_succeeds"]))
        saved.append(np.mean(shares))
    assert saved[0] < saved[1] - 0.02 and saved[1] < saved[2] - 0.02


def test_odds_of_tackles_decide_who_has_the_ball() -> None:
    won = []
    for odds in (0.2, 1.0):
        players = [(35.0, 0.0, LEFT, CM), (43.0, 0.0, RIGHT, CB), (-50.0, 0.0, RIGHT, GK)]
        matches = position(players, (35.4, 0.0), config(tackle_odds=odds), range(100))
        taken = np.zeros(100, bool)
        for _ in range(20):
            play(matches, [DIRECTION_RIGHT])
            taken |= matches["carrier"] == 1
        won.append(taken.mean())
    assert won[0] < won[1] - 0.2


@pytest.mark.parametrize("key", [SHORT_PASS, SHOT])
def test_kicks_scatter_by_their_spread(key: int) -> None:
    spread = []
    for share in (0.25, 1.0, 2.0):
        players = [(20.0, 0.0, LEFT, CM), (38.0, 0.0, LEFT, CM), (-54.0, 0.0, LEFT, GK), (54.0, 30.0, RIGHT, GK)]
        matches = position(players, (20.4, 0.0), config(kick_spread=share), range(150))
        play(matches, [DIRECTION_RIGHT, 0, 0, key], 0)
        angles = np.full(150, np.nan)
        for _ in range(10):
            play(matches, [0], 0)
            left = np.isnan(angles) & (np.hypot(matches["ball"]["vx"], matches["ball"]["vy"]) > 10.0)
            angles[left] = np.arctan2(matches["ball"]["vy"], matches["ball"]["vx"])[left]
        spread.append(np.nanstd(angles))
    assert spread[0] < 0.8 * spread[1] and spread[1] < 0.8 * spread[2]


def test_noise_plays_the_last_action_again() -> None:
    players = [(0.0, 0.0, LEFT, CM), (50.0, 30.0, RIGHT, GK)]
    shares = []
    for noise in (0.0, 0.5, 1.0):
        matches = position(players, (40.0, 30.0), config(sticky_noise=noise), range(200))
        play(matches, [SPRINT, DIRECTION_RIGHT])
        shares.append(np.mean(matches["players"]["direction"][:, 0] == DIRECTION_RIGHT))
    assert shares[0] == 1.0 and shares[1] == pytest.approx(0.5, abs=0.12) and shares[2] == 0.0
