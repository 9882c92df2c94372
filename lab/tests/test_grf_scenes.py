"""The academy's programs equal the GRF scenarios in `lab.grf.scenes`."""

import numpy as np
import pytest

from lab.grf.scenes import SCENES, stage_scene
from lab.grf.stage import OPEN_END
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import Lineup
from regista.minigames.suites import ACADEMY
from scenic_lite import load


def test_the_academy_has_the_scenes_whose_goals_were_counted():
    assert {name.removeprefix("academy/") for name in ACADEMY} <= set(SCENES)
    assert len(ACADEMY) == 8


@pytest.mark.parametrize("name", ACADEMY)
def test_everybody_stands_where_the_original_has_him(name):
    lineup = Lineup(load(ACADEMY[name].program, FOOTBALL), "active")
    mine = lineup.starts(np.zeros((1, 0)), np.zeros(1, np.uint64))[0]
    theirs = stage_scene(name.removeprefix("academy/"), OPEN_END, 1).matches[0]
    for field in ("team", "role", "shirt"):
        assert (mine["players"][field] == theirs["players"][field]).all(), field
    for axis in "xy":
        np.testing.assert_allclose(mine["players"][axis], theirs["players"][axis], atol=1e-3)
        np.testing.assert_allclose(mine["ball"][axis], theirs["ball"][axis], atol=1e-9)
    assert lineup.config.game_duration == 401  # steps; GRF plays 400 steps
    assert lineup.config.end_episode_on_possession_change and not lineup.config.offsides
