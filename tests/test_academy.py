"""Tests of GRF's academy scenarios: random positions, Gymnasium names, and control of the active player."""

import gymnasium
import numpy as np
import pytest

from regista import minigames  # noqa: F401 (registers the games)
from regista.envs.football.constants import GK
from regista.envs.football.scenic.domain import FOOTBALL
from regista.experiments.__main__ import main
from regista.experiments.run.folder import RunFolder
from regista.minigames.suites import ACADEMY
from scenic_lite import load


def test_places_are_drawn_anew_for_every_level_where_it_is_asked_for():
    program = load(ACADEMY["academy/3_vs_1_with_keeper"].program, FOOTBALL, None, None, {"jitter": 1})
    fixed = load(ACADEMY["academy/3_vs_1_with_keeper"].program, FOOTBALL)
    assert fixed.dim == 0 and program.dim == 12
    middle = fixed.instantiate(np.zeros((1, 0))).positions
    theta = np.random.default_rng(0).uniform(-1, 1, (50, 12))
    off = np.abs(program.instantiate(theta).positions - middle)
    assert off[:, :6].max() <= 1 + 1e-9 and off[:, :6].mean() == pytest.approx(0.5, abs=0.05)
    assert (off[:, 6] == 0).all()  # the ball keeps its position


def test_gymnasium_knows_it_by_the_originals_name_and_moves_the_active_player():
    env = gymnasium.make("regista/academy_3_vs_1_with_keeper-v1", representation="simple115")
    observation, _ = env.reset(seed=0)
    assert observation.shape == (115,)
    assert np.flatnonzero(observation[97:108]).tolist() == [0]  # the keeper, as in GRF
    assert env.unwrapped.batch.matches[0]["players"]["role"][0] == GK
    assert np.flatnonzero(env.step(0)[0][97:108]).tolist() == [1]


@pytest.mark.long
def test_a_run_of_it_moves_the_active_player_unless_told_otherwise(tmp_path):
    flags = ["--method=dr", "--total-env-steps=400", "--num-envs=4", "--num-steps=8", "--eval-every=0", "--no-record"]
    for words, control in (([], "active"), (["--control", "closest1"], "closest1")):
        out = tmp_path / control
        assert main(["train", "academy/pass_and_shoot_with_keeper", *flags, *words, "--out", str(out)]) == 0
        assert RunFolder.open(out).config.env.control == control
