"""Tests of the minigames: columns of θ, share of valid levels, test scenes within the training distribution."""

import numpy as np
import pytest

from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import METRES_PER_X, METRES_PER_Y
from regista.envs.football.scenic.domain import FOOTBALL
from regista.envs.football.scenic.lineup import Lineup
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames import BENCHMARK, MINIGAMES
from scenic_lite import load
from ued.core.baselines import Untrained
from ued.evaluation import evaluate

OBJECTS = {
    "1v1Restricted": ["LeftCM", "RightGK", "LeftGK", "Ball"],
    "1v1Free": ["LeftCM", "RightGK", "LeftGK", "Ball"],
    "ChoosePassing": ["LeftCM", "LeftCF", "LeftCF", "RightGK", "RightCB", "LeftGK", "Ball"],
    "3v2FourBehaviors": ["LeftCM", "LeftLM", "LeftRM", "RightCB", "RightGK", "LeftGK", "Ball"],
}
RANGES = {  # of the first columns of θ, in the program's units
    "1v1Restricted": [(40, 60), (-10, 10), (60, 80), (-25, 25)],
    "1v1Free": [(0, 80), (-25, 25), (0, 80), (-25, 25)],
    "ChoosePassing": [(58, 62), (-3, 3), (70, 76), (-3, 3), (78, 90), (-15, 15)],
    "3v2FourBehaviors": [(72, 78), (-6, 6), (76, 86), (8, 20), (76, 86), (-20, -8), (84, 92), (-8, 8)],
}
DIMENSIONS = {"3v2FourBehaviors": 9}  # the last column selects the strategy; other games have 6 columns
PLACED = {"ChoosePassing": [0, 3, 4], "3v2FourBehaviors": [0, 1, 2, 3]}  # objects in the order of the columns
AREAS = {"1v1Restricted": 400_000, "1v1Free": 16_000_000}  # thesis, section 4.3: "0.4M" and "16M"


def program_of(path):
    return load(path, FOOTBALL)


@pytest.mark.parametrize("name", MINIGAMES)
def test_the_training_program_has_the_columns_of_the_game(name):
    program = program_of(MINIGAMES[name].program)
    assert [info.class_name for info in program.objects] == OBJECTS[name]
    assert program.dim == DIMENSIONS.get(name, 6)
    found = [(draw.low, draw.high) for draw in program.draws]
    assert found[: len(RANGES[name])] == RANGES[name]
    if name in AREAS:
        assert np.prod([high - low for low, high in RANGES[name]]) == AREAS[name]


@pytest.mark.parametrize("name", MINIGAMES)
def test_nearly_every_draw_is_valid(name):
    program = program_of(MINIGAMES[name].program)
    theta = np.random.default_rng(0).uniform(-1, 1, (2000, program.dim))
    assert program.valid(theta).mean() > 0.97


@pytest.mark.parametrize("name", MINIGAMES)
def test_every_program_is_the_same_match_of_400_steps(name):
    game = MINIGAMES[name]
    lineups = [Lineup(program_of(path)) for path in (game.program, *(path for _, path in game.tests))]
    for lineup in lineups:
        assert lineup.config == lineups[0].config
        assert lineup.config.game_duration == 400 and lineup.config.end_episode_on_possession_change
        assert (np.asarray(lineup.roster.roles) == np.asarray(lineups[0].roster.roles)).all()


@pytest.mark.parametrize("name", MINIGAMES)
def test_the_test_scenes_lie_within_the_training_distribution(name):
    low, high = np.array(RANGES[name]).T
    movable = PLACED.get(name, [0, 1])
    for label, path in MINIGAMES[name].tests:
        program = program_of(path)
        if program.dim:
            continue  # the training distribution of a smaller game
        places = program.instantiate(np.zeros((1, 0))).positions[0, movable].ravel()
        assert ((low <= places) & (places <= high)).all(), label


# ---------------------------------------------------------------- the four strategies of the 3v2


STRATEGIES = {"A": 0.125, "B": 0.375, "C": 0.625, "D": 0.875}


def courses_of(label, steps=40, count=32):
    """Return positions of the defender (match index 5) and the ball, `[T, count, 2]`, and actions of the defender.

    They are of a strategy's test scene, where the learner stands still. The actions have shape `[T, count]`. After the
    end of a match, positions are nan and actions are -1.
    """
    path = next(path for name, path in MINIGAMES["3v2FourBehaviors"].tests if name.startswith(label))
    env = FootballVectorEnv(path, count)
    env.reset(seed=0)
    defender = env.lineup.object_to_player[[info.name for info in env.program.objects].index("defender")]
    over = np.zeros(count, bool)
    places, balls, pressed = [], [], []
    for _ in range(steps):
        matches = env.matches
        unit = np.array([METRES_PER_X, METRES_PER_Y])
        player = matches["players"][:, defender]
        places.append(np.where(over[:, None], np.nan, np.stack([player["x"], player["y"]], 1) / unit))
        balls.append(np.where(over[:, None], np.nan, np.stack([matches["ball"]["x"], matches["ball"]["y"]], 1) / unit))
        _, _, terminated, truncated, _ = env.step(np.full(count, 14))
        over |= terminated | truncated
        pressed.append(np.where(over, -1, env.matches["players"]["action"][:, defender]))
    return np.array(places), np.array(balls), np.array(pressed)


def test_the_selector_of_a_test_scene_is_its_strategy():
    for label, selector in STRATEGIES.items():
        path = next(path for name, path in MINIGAMES["3v2FourBehaviors"].tests if name.startswith(label))
        assert program_of(path).instantiate(np.zeros((1, 0))).behavior_arguments[3] == {"selector": selector}


def test_the_chaser_runs_at_the_ball():
    places, balls, _ = courses_of("A")
    gap = np.linalg.norm(places - balls, axis=2)
    assert (np.nanmean(gap[12]) < np.nanmean(gap[0]) - 5) and np.nanmin(gap, axis=0).max() < 4


@pytest.mark.long
def test_the_marker_runs_at_the_ball_until_somebody_owns_it():
    places, _, _ = courses_of("B")
    assert np.nanmean(places[10, :, 0]) < 84


def test_the_lane_cutter_leaves_the_middle_for_a_lane_and_then_chases():
    places, balls, _ = courses_of("C", steps=60)
    assert np.nanmax(np.abs(places[15, :, 1])) > 1.5  # the lane between two attackers does not go through y = 0
    gap = np.linalg.norm(places - balls, axis=2)
    assert np.nanmin(gap[30:], initial=np.inf) < np.nanmin(gap[0])


def test_the_goal_guard_stays_before_his_goal_while_the_ball_is_far():
    places, balls, pressed = courses_of("D")
    far = np.linalg.norm(places - balls, axis=2) > 12
    assert np.nanmin(np.where(far, places[:, :, 0], np.nan)) > 84
    assert np.abs(np.where(far, places[:, :, 1], 0)).max() < 6
    assert (pressed[25:] == 14).any()  # the defender has arrived and stands


def test_every_strategy_comes_up_in_training():
    env = FootballVectorEnv(MINIGAMES["3v2FourBehaviors"].program, 64)
    env.reset(seed=0)
    selectors = (env.levels["theta"][:, 8] + 1) / 2
    counts = np.histogram(selectors, bins=4, range=(0, 1))[0]
    assert (counts > 5).all()


class Idle(Untrained):
    def play(self, observation, generator, greedy=False, memory=None):
        return np.zeros(len(observation), np.int64)


def test_the_built_in_ai_is_a_baseline_that_leaves_the_environments_alone():
    """The AI scores where idle players do not, its play is reproducible, and it does not control later policies."""
    task = MINIGAMES["1v1Restricted"].task()
    upomdp = task.scenes()["easy"](16)
    built_in = task.make_baselines(upomdp)["built-in"]
    first, again = (evaluate(built_in, upomdp, 48, 0) for _ in range(2))
    assert first.success.tolist() == again.success.tolist() and first.success.mean() > 0.3
    assert not upomdp.scripted
    assert evaluate(Idle(), upomdp, 48, 0).success.sum() == 0
    by_hand = evaluate(Idle(), upomdp.with_scripted_policy(), 48, 0)
    assert by_hand.returns.tolist() == first.returns.tolist() and by_hand.lengths.tolist() == first.lengths.tolist()


def test_grf_has_no_built_in_baseline():
    config = FootballConfig(engine="grf")
    task = MINIGAMES["1v1Restricted"].task(config, make=lambda *_, **__: None)
    assert set(task.baselines) == {"shoot", "random"}


@pytest.mark.slow
@pytest.mark.parametrize("name", BENCHMARK)
def test_defences_say_that_they_are(name):
    game = BENCHMARK[name]
    for path in (game.program, *(path for _, path in game.tests)):
        assert Lineup(program_of(path)).config.defending == name.startswith("defense/")


def test_a_minigame_is_a_task():
    task = MINIGAMES["1v1Restricted"].task()
    assert list(task.scenes()) == ["training distribution", "easy", "medium", "hard"]
    assert list(task.scenes(held_out=True)) == ["training distribution", "in", "near", "clear"]
    assert task.success_word == "goals"
    for scene in task.scenes().values():
        upomdp = task.make_scene(scene)(2)
        seen, _ = upomdp.reset(seed=0)
        assert seen.shape[0] == 2 and task.painter(upomdp).positions(upomdp.levels["theta"]).shape == (2, 4, 2)
    assert list(task.make_baselines(upomdp)) == ["shoot", "random", "built-in"]
    assert BENCHMARK["defense/2vs2"].task().success_word == "success"
