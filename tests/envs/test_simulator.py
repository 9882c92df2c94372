"""The simulator as a whole: repeatable, symmetric, and sane under any actions."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pitch import duel, plain, play, position, same

from regista.envs.football.constants import CB, CF, CM, GK, LEFT, RIGHT, RUNNING
from regista.envs.football.kick_off import MatchConfig
from regista.envs.football.simulator import step_matches
from regista.envs.football.state import MATCH

ROOT = Path(__file__).resolve().parents[2]
MIRRORED = np.array([0, 1, 8, 7, 6, 5, 4, 3, 2, *range(9, 19)])  # actions seen in a mirror along the x axis
FIVES = [
    (-54.0, 0.2, LEFT, GK),
    (-20.0, 7.0, LEFT, CB),
    (-12.0, -9.0, LEFT, CM),
    (-3.0, 4.0, LEFT, CF),
    (-6.0, -18.0, LEFT, CM),
    (53.0, -0.7, RIGHT, GK),
    (24.0, -6.0, RIGHT, CB),
    (15.0, 11.0, RIGHT, CM),
    (5.0, -3.5, RIGHT, CF),
    (9.0, 19.0, RIGHT, CM),
]


def random_play(matches: np.ndarray, steps: int, seed: int = 0) -> np.ndarray:
    actions = np.random.default_rng(seed).integers(0, 19, (steps, len(matches)))
    for row in actions:
        step_matches(matches, row[:, None])
    return matches


def test_the_same_seed_gives_the_same_match() -> None:
    first, second = (random_play(duel((30.0, 0.0), (45.0, 2.0), range(20)), 100) for _ in range(2))
    assert same(first, second)
    assert len(np.unique(first["ball"]["x"])) > 10


def test_a_batch_of_one_is_a_row_of_a_batch() -> None:
    actions = np.random.default_rng(3).integers(0, 19, (120, 8))
    batch = duel((30.0, 0.0), (45.0, 2.0), range(8))
    alone = duel((30.0, 0.0), (45.0, 2.0), [5])
    for row in actions:
        step_matches(batch, row[:, None])
        step_matches(alone, row[5:6, None])
    assert same(batch[5:6], alone)


def test_a_copy_goes_on_bit_for_bit(tmp_path: Path) -> None:
    matches = random_play(position(FIVES, (0.0, 1.0), seeds=range(3)), 60)
    np.save(tmp_path / "matches.npy", plain(matches))
    copy = np.load(tmp_path / "matches.npy").view(np.recarray)
    assert same(random_play(matches, 60, 1), random_play(copy, 60, 1))


PLAY_UNCOMPILED = """
import sys, warnings
import numpy as np
sys.path.insert(0, "tests/envs")
warnings.simplefilter("error")
from test_simulator import FIVES, random_play
from pitch import duel, plain, position
np.save(sys.argv[1], plain(random_play(duel((30.0, 0.0), (45.0, 2.0), range(2)), 100)))
np.save(sys.argv[2], plain(random_play(position(FIVES, (0.0, 1.0)), 40)))
"""


@pytest.mark.slow
def test_compiled_and_uncompiled_agree(tmp_path: Path) -> None:
    """Bit for bit where the C library's exp and log agree with Python's: the tolerance allows for others."""
    files = [tmp_path / "duel.npy", tmp_path / "fives.npy"]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", PLAY_UNCOMPILED, *map(str, files)]
    subprocess.run(command, env=environment, cwd=ROOT, check=True, timeout=120)
    compiled = [random_play(duel((30.0, 0.0), (45.0, 2.0), range(2)), 100)]
    compiled.append(random_play(position(FIVES, (0.0, 1.0)), 40))
    for file, ours in zip(files, compiled, strict=True):
        theirs = np.load(file)
        for name in MATCH.names:
            if name in ("ball", "engine", "players"):
                for field in MATCH[name].base.names:
                    np.testing.assert_allclose(theirs[name][field], ours[name][field], rtol=0, atol=1e-9)
            else:
                np.testing.assert_allclose(theirs[name].astype(float), ours[name].astype(float), rtol=0, atol=1e-9)


def test_seen_in_a_mirror() -> None:
    """y → −y of scene and actions gives the mirrored match, exactly, until a kick, a slide, a keeper or a set piece."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        striker, keeper = (rng.uniform(20, 35), rng.uniform(-9, 9)), (rng.uniform(40, 50), rng.uniform(-9, 9))
        ball = (striker[0] - 0.9, striker[1] + 1.1)
        actions = rng.choice([0, 1, 2, 3, 4, 5, 6, 7, 8, 13, 14, 15, 16, 17, 18], 80)
        players = [(*striker, LEFT, CM), (*keeper, RIGHT, GK), (-50.0, 0.5, LEFT, GK)]
        flipped = [(x, -y, team, role) for x, y, team, role in players]
        there, here = position(players, ball), position(flipped, (ball[0], -ball[1]))
        for action in actions:
            play(there, [action])
            play(here, [MIRRORED[action]])
            at_rest = there["kicker"][0] >= 0 or there["game_mode"][0] != 0
            is_drawn = there["players"]["is_slide_spent"].any() or there["last_touch"][0] == 1
            if at_rest or there["keeper_holding"][0] >= 0 or is_drawn:
                break
            np.testing.assert_array_equal(there["players"]["x"], here["players"]["x"])
            np.testing.assert_array_equal(there["players"]["y"], -here["players"]["y"])
            np.testing.assert_array_equal(there["ball"]["y"], -here["ball"]["y"])


def test_both_sides_play_alike() -> None:
    """The built-in AI on both sides, teams swapped and the pitch turned by 180°, gives the turned match."""
    equal = MatchConfig(
        end_episode_on_score=False,
        end_episode_on_out_of_play=False,
        end_episode_on_possession_change=False,
        right_team_difficulty=1.0,
        control="none",
    )
    turned = [(-x, -y, 1 - team, role) for x, y, team, role in FIVES]
    here, there = position(FIVES, (0.3, 1.0), equal), position(turned, (-0.3, -1.0), equal)
    for _ in range(150):
        play(here, [0])
        play(there, [0])
        if here["kicker"][0] >= 0:  # the scatter of a kick is drawn anticlockwise on both sides
            np.testing.assert_allclose(here["players"]["x"], -there["players"]["x"], atol=1e-9)
    np.testing.assert_allclose(here["ball"]["x"], -there["ball"]["x"], atol=1e-6)
    assert (here["score"][:, ::-1] == there["score"]).all()


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(
    striker=st.tuples(st.floats(-50, 50), st.floats(-30, 30)),
    keeper=st.tuples(st.floats(-50, 54), st.floats(-30, 30)),
    seed=st.integers(0, 2**63),
)
def test_invariants_under_random_actions(striker: tuple[float, float], keeper: tuple[float, float], seed: int) -> None:
    matches = duel(striker, keeper, [seed], game_duration=200)
    rng = np.random.default_rng(seed)
    for _ in range(200):
        play(matches, [int(rng.integers(19))])
        check_sane(matches)
    assert matches["ended"][0] != RUNNING


@pytest.mark.slow
def test_invariants_in_an_open_game_of_fives() -> None:
    matches = position(FIVES, (0.0, 1.0), seeds=range(32))
    rng = np.random.default_rng(0)
    for _ in range(600):
        step_matches(matches, rng.integers(0, 19, (32, 1)))
        check_sane(matches)
    assert matches["score"].sum() >= 1


def check_sane(matches: np.ndarray) -> None:
    """Check: no fault, everybody on the grass, nobody faster than a dive, the ball's owner near it and on the list."""
    players, ball = matches["players"][:, : matches["num_players"][0]], matches["ball"]
    for field in ("x", "y", "vx", "vy", "facing_x", "facing_y"):
        assert np.isfinite(players[field]).all(), field
    assert (matches["fault"] == 0).all()
    assert (np.abs(players["x"]) <= 58.0).all() and (np.abs(players["y"]) <= 39.0).all()
    assert (np.hypot(players["vx"], players["vy"]) < 9.0).all()
    assert np.allclose(np.hypot(players["facing_x"], players["facing_y"]), 1.0)
    assert (np.abs(ball["x"]) < 60.0).all() and (np.abs(ball["y"]) < 41.0).all() and (ball["z"] > 0.1).all()
    assert (np.sqrt(ball["vx"] ** 2 + ball["vy"] ** 2 + ball["vz"] ** 2) < 48.0).all()
    swinging = np.argwhere(players["kick_wait"] > 0.0)
    assert (matches["kicker"][swinging[:, 0]] == swinging[:, 1]).all()
    rows = np.flatnonzero(matches["reported_owner"] >= 0)
    owners = players[rows, matches["reported_owner"][rows]]
    assert (np.hypot(owners["x"] - ball["x"][rows], owners["y"] - ball["y"][rows]) < 2.0).all()
    agents = matches["agents"][:, 0]
    assert (agents >= 0).all() and (players["team"][:, agents] == LEFT).all()


def test_the_controlled_player_is_the_closest_one_before_the_next_action() -> None:
    """So that the player observed is the one whom the action moves; ties keep program order."""
    tie = position([(0.0, 3.0, LEFT, CM), (0.0, -3.0, LEFT, CM), (50.0, 0.0, RIGHT, GK)], (0.0, 0.0))
    assert tie["agents"][0, 0] == 0
    matches = position(FIVES, (0.0, 1.0))
    rng = np.random.default_rng(5)
    for _ in range(200):
        play(matches, [int(rng.integers(19))])
        left = matches["players"][0, :5]
        distance = np.hypot(left["x"] - matches["ball"]["x"][0], left["y"] - matches["ball"]["y"][0])
        assert matches["agents"][0, 0] == np.argmin(distance)


@pytest.mark.parametrize("action", [-1, 19, 400])
def test_an_action_that_does_not_exist_is_a_fault(action: int) -> None:
    matches = play(duel((30.0, 0.0), (45.0, 2.0)), [action])
    assert matches["fault"][0] == 2


def test_a_random_policy_rarely_scores() -> None:
    matches = duel((27.0, 0.0), (38.0, 1.0), range(150))
    random_play(matches, 400)
    assert (matches["ended"] != RUNNING).all()
    assert np.mean(matches["score"][:, 0] > 0) < 0.12


def test_idling_before_a_keeper_loses_the_ball() -> None:
    """No deadlock: he comes and takes it, or kicks it as far as the striker's own keeper."""
    matches = play(duel((27.0, 0.0), (38.0, 1.0), range(50)), [0] * 300)
    ended = matches["ended"] != RUNNING
    assert ended.mean() > 0.9 and (ended | (matches["carrier"] == 2)).all()
    assert matches["score"].sum() == 0
