"""The minigames keep to their numbers: columns of θ, acceptance, tests that lie within the training distribution."""

import numpy as np
import pytest

from envs.football.casting import Casting
from envs.football.domain import FOOTBALL
from minigames import MINIGAMES
from scenic_lite import load

OBJECTS = {
    "1v1Restricted": ["LeftCM", "RightGK", "LeftGK", "Ball"],
    "1v1Free": ["LeftCM", "RightGK", "LeftGK", "Ball"],
    "ChoosePassing": ["LeftCM", "LeftCF", "LeftCF", "RightGK", "RightCB", "LeftGK", "Ball"],
}
RANGES = {  # of the columns that matter, in the program's units
    "1v1Restricted": [(40, 60), (-10, 10), (60, 80), (-25, 25)],
    "1v1Free": [(0, 80), (-25, 25), (0, 80), (-25, 25)],
    "ChoosePassing": [(58, 62), (-3, 3), (70, 76), (-3, 3), (78, 90), (-15, 15)],
}
AREAS = {"1v1Restricted": 400_000, "1v1Free": 16_000_000}  # thesis, section 4.3: "0.4M" and "16M"


def program_of(path):
    return load(path, FOOTBALL)


@pytest.mark.parametrize("name", MINIGAMES)
def test_the_training_program_has_the_columns_of_the_game(name):
    program = program_of(MINIGAMES[name].program)
    assert [info.class_name for info in program.objects] == OBJECTS[name]
    assert program.dim == 6
    found = [(draw.low, draw.high) for draw in program.draws]
    assert found[: len(RANGES[name])] == RANGES[name]
    if name in AREAS:
        assert np.prod([high - low for low, high in RANGES[name]]) == AREAS[name]


@pytest.mark.parametrize("name", MINIGAMES)
def test_nearly_every_draw_is_valid(name):
    theta = np.random.default_rng(0).uniform(-1, 1, (2000, 6))
    assert program_of(MINIGAMES[name].program).valid(theta).mean() > 0.97


@pytest.mark.parametrize("name", MINIGAMES)
def test_every_program_is_the_same_match_of_400_steps(name):
    game = MINIGAMES[name]
    castings = [Casting(program_of(path)) for path in (game.program, *(path for _, path in game.tests))]
    for casting in castings:
        assert casting.config == castings[0].config
        assert casting.config.game_duration == 400 and casting.config.end_episode_on_possession_change
        assert (np.asarray(casting.lineup.roles) == np.asarray(castings[0].lineup.roles)).all()


@pytest.mark.parametrize("name", MINIGAMES)
def test_the_test_scenes_lie_within_the_training_distribution(name):
    low, high = np.array(RANGES[name]).T
    movable = [0, 1] if name != "ChoosePassing" else [0, 3, 4]  # objects in the order of the columns
    for label, path in MINIGAMES[name].tests:
        program = program_of(path)
        if program.dim:
            continue  # the training distribution of a smaller game
        places = program.instantiate(np.zeros((1, 0))).positions[0, movable].ravel()
        assert ((low <= places) & (places <= high)).all(), label
