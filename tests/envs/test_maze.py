"""Mazes: steps, views, levels, states, and rollouts that run compiled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.envs.maze.levels import Maze, MazeFamily, maze_from
from tests.envs.minigrid_plays import RECORDED, compare_with_recorded
from ued import METHODS, ACCELConfig, BufferConfig, PPOConfig
from ued.core.parameters import LevelFamily
from ued.learning import worker
from ued.levels.record import Origin
from ued.probes import Frontier

LEFT, RIGHT, FORWARD = 0, 1, 2
CORRIDOR = """
>...G
#####
.....
.....
.....
"""
ROOMS = """
G.....
.#.##.
###.#.
.#..#.
.##...
..^...
"""
FIVE = MazeConfig(side=5, num_walls=6, max_steps=20)
OPAQUE = replace(FIVE, see_through=False)


def placed(drawing, num_envs=1, **settings):
    """Return environments that have begun the maze of a drawing."""
    maze = maze_from(drawing)
    mazes = Mazes(num_envs, MazeConfig(side=len(maze.walls), **settings))
    mazes.reset(options={"theta": np.tile(mazes.theta_of(maze), (num_envs, 1))})
    return mazes


def shown(mazes, index=0):
    """Return what an agent sees, a string per row: `?` unseen, `.` empty, `#` wall, `G` goal."""
    return [
        "".join({0: "?", 1: ".", 2: "#", 8: "G"}[thing] for thing in row) for row in mazes.images()[index, ..., 0].T
    ]


# ---------------------------------------------------------------- steps and views


def test_the_reward_of_the_goal_falls_with_time():
    mazes = placed(CORRIDOR)
    for _ in range(3):
        _, reward, terminated, truncated, info = mazes.advance(np.array([FORWARD]))
        assert (reward, terminated, truncated, info["success"]) == (0, False, False, 0)
    _, reward, terminated, truncated, info = mazes.advance(np.array([FORWARD]))
    assert reward == [1 - 0.9 * (4 / 250)]
    assert (terminated, truncated, info["success"]) == (True, False, 1)


def test_walls_and_the_border_stop_an_agent():
    mazes = placed(CORRIDOR)
    before = mazes.images()
    mazes.advance(np.array([RIGHT]))
    facing_a_wall = mazes.images()
    mazes.advance(np.array([FORWARD]))
    np.testing.assert_array_equal(mazes.images(), facing_a_wall)
    for action in (LEFT, LEFT, FORWARD, RIGHT):  # up, against the border
        mazes.advance(np.array([action]))
    np.testing.assert_array_equal(mazes.images(), before)
    assert mazes.directions() == [0]


def test_an_episode_ends_after_its_steps():
    mazes = placed(CORRIDOR, max_steps=3)
    ends = [mazes.advance(np.array([LEFT]))[2:4] for _ in range(3)]
    assert [(bool(terminated[0]), bool(truncated[0])) for terminated, truncated in ends] == [(False, False)] * 2 + [
        (False, True)
    ]


def test_a_goal_in_the_last_step_is_both_ends():
    mazes = placed(CORRIDOR, max_steps=4)
    for _ in range(4):
        _, reward, terminated, truncated, _ = mazes.advance(np.array([FORWARD]))
    assert (terminated, truncated) == (True, True)
    assert reward == [1 - 0.9 * (4 / 4)]


def test_the_view_is_ahead_and_turned():
    mazes = placed(CORRIDOR)
    assert shown(mazes) == ["##G#.", "##.#.", "##.#.", "##.#.", "##.#."]
    mazes.advance(np.array([RIGHT]))
    assert shown(mazes) == ["...##", "...##", "...##", "#####", "...##"]


def test_walls_hide_what_is_behind_them_if_they_are_opaque():
    mazes = placed(CORRIDOR, see_through=False)
    assert shown(mazes) == ["?#G#?", "?#.#?", "?#.#?", "?#.#?", "?#.#?"]
    mazes = placed(ROOMS, see_through=False)
    assert shown(mazes) == ["?#.##", "###.#", ".#..#", ".##..", "....."]  # as minigrid 3.2.0 shows it
    mazes.advance(np.array([LEFT]))
    assert shown(mazes) == ["?????", "?####", "?#...", "?#.#?", "?#.#?"]


@pytest.mark.parametrize("see_through", [True, False])
def test_both_representations_say_what_the_image_says(see_through):
    config = replace(FIVE, see_through=see_through)
    features, images = Mazes(64, config), Mazes(64, replace(config, representation="image"))
    vectors, others = features.reset(seed=0)[0], images.reset(seed=0)[0]
    image = features.images()
    things, rest = image[..., 0].reshape(64, 25), np.eye(4)[features.directions()]
    planes = [things == 2, things == 8] + ([] if see_through else [things > 0])
    np.testing.assert_array_equal(vectors, np.concatenate([*planes, rest], 1))
    np.testing.assert_array_equal(others, np.concatenate([image.reshape(64, 75) / np.float32(10), rest], 1))
    assert (things == 8).any() and (see_through or (things == 0).any())
    for mazes, seen in ((features, vectors), (images, others)):
        assert mazes.observation_space.contains(seen)
        assert mazes.observation_scale.shape == seen.shape[1:]


def test_sizes_share_compiled_code():
    from regista.envs.maze.dynamics import step_mazes

    Mazes(2, FIVE).reset(seed=0)
    placed(CORRIDOR).step(np.zeros(1, int))
    if hasattr(step_mazes, "signatures"):
        compiled = len(step_mazes.signatures)
        large = Mazes(3, MazeConfig(side=51, num_walls=900, see_through=False))
        large.reset(seed=0)
        large.step(np.full(3, FORWARD))
        assert len(step_mazes.signatures) == compiled
        assert large.single_observation_space == Mazes(1, OPAQUE).single_observation_space


@pytest.mark.parametrize(
    "config",
    [MazeConfig(see_through=False), MazeConfig(num_walls=60, random_count=True), OPAQUE],
    ids=["25", "60", "5 x 5"],
)
def test_mazes_play_as_those_of_minigrid(config):
    pytest.importorskip("minigrid")
    from tests.envs.minigrid_maze import compare

    counts = compare(config, num_mazes=40, num_steps=60, seed=3)
    assert counts["terminated"] > 0
    assert config is not OPAQUE or min(counts.values()) > 0


@pytest.mark.parametrize("name", RECORDED)
def test_mazes_play_as_recorded_in_minigrid(name):
    counts = compare_with_recorded(name)
    assert counts["truncated"] > 0 and (counts["hidden"] > 0) == ("hide" in name)
    assert name != "5 x 5, hide" or counts["terminated"] > 20


# ---------------------------------------------------------------- levels


def test_random_mazes_have_the_walls_of_their_setting():
    rng = np.random.default_rng(0)
    for family, least, most in (
        (MazeFamily(), 15, 25),
        (MazeFamily(num_walls=60, random_count=True), 0, 59),
        (MazeFamily(num_walls=0), 0, 0),
    ):
        mazes = [family.sample(rng) for _ in range(400)]
        walls = [int(maze.walls.sum()) for maze in mazes]
        assert least <= min(walls) and max(walls) <= most
        assert max(walls) - min(walls) > (most - least) // 3 or most == 0
        for maze in mazes:
            assert maze.start != maze.goal and not maze.walls[maze.start] and not maze.walls[maze.goal]
        assert {maze.direction for maze in mazes} == {0, 1, 2, 3}
        assert len({maze.goal for maze in mazes}) > 100
    assert isinstance(family, LevelFamily)


@pytest.mark.parametrize("side", [2, 5, 13])
def test_codes_are_those_of_their_mazes(side):
    family, rng = MazeFamily(side, 2 * side), np.random.default_rng(side)
    codes = family.draw_codes(rng, 50)
    assert family.valid(codes).all() and np.abs(codes).max() <= 1
    for code in codes:
        maze = family.decode(code)
        np.testing.assert_array_equal(family.encode(maze), code)


def test_any_numbers_are_a_maze():
    mazes, rng = Mazes(32, FIVE), np.random.default_rng(0)
    theta = rng.uniform(-1, 1, (500, mazes.theta_dim))
    good = mazes.valid(theta)
    assert 0.9 < good.mean() < 1
    family = MazeFamily(5)
    for row in theta[good]:
        maze = family.decode(row)
        assert not maze.walls[maze.start] and not maze.walls[maze.goal]
    levels = mazes.make_levels(np.concatenate([theta[~good][:1], theta[good][:31]]))
    assert mazes.reset_to_levels(levels)[1]["replaced"].tolist() == [True] + [False] * 31
    assert mazes._prepare(levels).tolist() == [-1, *range(1, 32)]  # no row for a level that must be replaced


def test_edits_change_one_cell():
    family, rng = MazeFamily(), np.random.default_rng(0)
    maze, changes = family.sample(rng), []
    for _ in range(3000):
        child = family.mutate(maze, rng)
        assert child.start != child.goal and not child.walls[child.start] and not child.walls[child.goal]
        changes.append((int((child.walls != maze.walls).sum()), child.start != maze.start, child.goal != maze.goal))
        maze = child
    walls, starts, goals = np.array(changes).T
    assert walls.max() == 1 and 0.25 < walls.mean() < 0.5
    assert 1 / 4 < goals.mean() < 1 / 2  # a third of all edits place the goal
    assert 0 < starts.mean() < 0.02  # only edits of its cell move the agent


@pytest.mark.slow
def test_accel_begins_with_empty_mazes_if_told_to():
    settings = ACCELConfig(new_levels="simplest", min_fill=0.01, buffer=BufferConfig(capacity=300))
    mazes = Mazes(8, MazeConfig(side=7, max_steps=20))
    method = METHODS["accel"].load()(mazes, PPOConfig(num_steps=64, num_minibatches=1), settings, seed=0)
    walls = {Origin.RANDOM: [], Origin.EDITED: []}
    for _ in range(8):
        method.update()
        for row in method.last.records:
            if row["origin"] in walls:
                walls[row["origin"]].append(mazes.level_family.decode(row["level"]["theta"]).walls.sum())
    assert not any(walls[Origin.RANDOM]) and len(walls[Origin.RANDOM]) > 8 and max(walls[Origin.EDITED]) > 1
    with pytest.raises(ValueError, match="these are vectors θ"):
        METHODS["accel"].load()(Frontier(4), PPOConfig(), settings, seed=0)


def test_a_maze_without_an_empty_cell_stays_as_it_is():
    family, rng = MazeFamily(2), np.random.default_rng(0)
    maze = Maze(np.array([[False, True], [True, False]]), (0, 0), (1, 1), 2)
    for _ in range(100):
        child = family.mutate(maze, rng)
        assert child.start != child.goal and not child.walls[child.start] and not child.walls[child.goal]


def test_a_drawing_that_is_no_maze_is_refused():
    for wrong, message in (
        (">G\n...", "as many rows"),
        (">x\nG.", "as many rows"),
        ("..\nG.", "one agent"),
        (">G\nG.", "one goal"),
        (">#.\n##.\n..G", r"walls separate the agent in \(0, 0\) from the goal in \(2, 2\)"),
    ):
        with pytest.raises(ValueError, match=message):
            maze_from(wrong)
    with pytest.raises(ValueError, match="5 x 5 cells"):
        Mazes(1, FIVE).theta_of(maze_from(">G\n.."))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"goal": (5, 5)}, r"goal of a maze is a row and a column from 0 to 4, got \(5, 5\)"),
        ({"start": (-1, 2)}, r"start of a maze is a row and a column from 0 to 4, got \(-1, 2\)"),
        ({"start": (0.5, 2)}, "start of a maze is"),
        ({"goal": (0, 0)}, r"different cells, both are \(0, 0\)"),
        ({"direction": 4}, "from 0 to 3, got 4"),
    ],
)
def test_a_maze_that_does_not_exist_has_no_code(change, message):
    with pytest.raises(ValueError, match=message):
        Mazes(1, FIVE).theta_of(maze_from(CORRIDOR)._replace(**change))


# ---------------------------------------------------------------- states


def test_mazes_that_were_never_reset_are_not_played():
    never = Mazes(2, FIVE)
    for mazes in (never, never.copy()):
        with pytest.raises(RuntimeError, match=r"^call reset\(\) before step\(\)$"):
            mazes.step(np.zeros(2, int))
    never.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(RuntimeError, match="1 of 2 environments were never reset"):
        never.step(np.zeros(2, int))


def test_a_copy_is_drawn_as_the_original():
    mazes = Mazes(2, FIVE, "rgb_array")
    mazes.reset(seed=0)
    np.testing.assert_array_equal(mazes.copy().render(), mazes.render())


def test_a_state_that_is_put_back_goes_on_alike():
    rng = np.random.default_rng(0)
    mazes, twin = Mazes(8, OPAQUE), Mazes(8, OPAQUE)
    mazes.level_sampler, twin.level_sampler = mazes.sample_levels, twin.sample_levels
    mazes.reset(seed=1)
    for _ in range(13):
        mazes.step(rng.integers(0, 3, 8))
    np.testing.assert_array_equal(twin.set_state(mazes.get_state()), mazes.observe())
    third = mazes.copy()
    third.level_sampler = third.sample_levels
    for _ in range(50):
        actions = rng.integers(0, 3, 8)
        ours = mazes.step(actions)
        for other in (twin, third):
            theirs = other.step(actions)
            for one, two in zip(ours[:4], theirs[:4], strict=True):
                np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"at": np.zeros(4, np.int64)}, "without its border"),
        ({"at": np.full(4, 10**6)}, "from 0 to"),
        ({"direction": np.full(4, 4)}, "from 0 to 3"),
        ({"clock": np.full(4, -1)}, "from 0 to"),
        ({"clock": np.zeros(3, np.int64)}, "4 integers"),
        ({"at": None}, "at"),
    ],
)
def test_a_state_that_does_not_fit_is_refused_and_changes_nothing(change, message):
    mazes = Mazes(4, FIVE)
    mazes.reset(seed=0)
    state = mazes.get_state()
    wrong = {name: value for name, value in (state | change).items() if value is not None}
    mazes.reset(seed=2)
    before = mazes.observe()
    with pytest.raises(ValueError, match=message):
        mazes.set_state(wrong)
    np.testing.assert_array_equal(mazes.observe(), before)


def test_misuse_is_reported():
    mazes = Mazes(4, FIVE)
    with pytest.raises(RuntimeError, match="reset"):
        mazes.step(np.zeros(4, int))
    mazes.reset(seed=0)
    for wrong, message in ((np.zeros(3, int), "4 integers"), (np.zeros(4), "4 integers"), (np.full(4, 3), "action 3")):
        with pytest.raises(ValueError, match=message):
            mazes.step(wrong)
    for name, value in (
        ("side", 1),
        ("num_walls", -1),
        ("max_steps", 0),
        ("max_steps", 2.5),
        ("representation", "rgb"),
        ("see_through", "no"),
        ("random_count", 1),
    ):
        with pytest.raises(ValueError, match=name):
            MazeConfig(**{name: value})


# ---------------------------------------------------------------- compiled rollouts

SMALL = PPOConfig(num_steps=64, hidden_size=24, num_minibatches=2, update_epochs=1)
GRU = replace(SMALL, memory="gru", hidden_size=19)
CASES = {
    f"{method}, {num_envs} environments, {name}": (method, num_envs, ppo, config)
    for method, num_envs, name, ppo, config in (
        ("dr", 5, "feed-forward", SMALL, FIVE),
        ("dr", 33, "GRU", replace(GRU, shared_torso=True), OPAQUE),
        ("plr", 33, "feed-forward", replace(SMALL, shared_torso=True), OPAQUE),
        ("plr", 5, "GRU", GRU, replace(FIVE, representation="image")),
        ("accel", 33, "GRU", GRU, FIVE),
        ("accel", 5, "feed-forward", SMALL, MazeConfig(side=7, max_steps=9)),
        ("cenie", 5, "GRU", GRU, FIVE),
        ("sfl", 5, "GRU", GRU, FIVE),
        ("ncc", 5, "GRU", GRU, FIVE),
    )
}


def trained(case, compiled, monkeypatch, updates=3):
    """Return a method after a few updates, and what each of them played: columns of its rollout, records, steps."""
    method_name, num_envs, ppo, config = case
    monkeypatch.setattr(worker, "COMPILED", compiled)
    method = METHODS[method_name].load()(Mazes(num_envs, config), ppo, None, seed=3, env_steps=20_000)
    method.keep_tapes()
    seen = []
    for _ in range(updates):
        metrics = method.update()
        rollouts = [{name: column.clone() for name, column in vars(one.rollout).items()} for one in method.learners]
        seen.append((rollouts, method.last.records.copy(), metrics["env_steps"]))
    assert all(learner.worker.is_compiled == compiled for learner in method.learners)
    return method, seen


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_compiled_rollout_is_the_one_of_single_steps(case, monkeypatch):
    (method, ours), (other, theirs) = (trained(case, compiled, monkeypatch) for compiled in (True, False))
    for (rollouts, records, steps), (others, other_records, other_steps) in zip(ours, theirs, strict=True):
        assert steps == other_steps
        for rollout, single in zip(rollouts, others, strict=True):
            for name, column in rollout.items():
                exact = column.dtype in (torch.bool, torch.int64) or name in ("observation", "reward")
                torch.testing.assert_close(column, single[name], atol=0 if exact else 1e-5, rtol=0, msg=name)
        for name in ("id", "visit", "origin", "level", "num_played", "returns", "success"):
            np.testing.assert_array_equal(records[name], other_records[name], name)
    ends = {
        name: sum(int(one[name].sum()) for rollouts, *_ in ours for one in rollouts)
        for name in ("terminated", "truncated")
    }
    assert min(ends.values()) > 0
    for learner, twin in zip(method.learners, other.learners, strict=True):
        state, expected = learner.upomdp.get_state(), twin.upomdp.get_state()
        for name in ("at", "direction", "clock", "levels", "visits", "episodes"):
            np.testing.assert_array_equal(state[name], expected[name], name)
        assert state["np_random"] == expected["np_random"]
        np.testing.assert_array_equal(learner.upomdp.images(), twin.upomdp.images())


@pytest.mark.slow
def test_a_checkpoint_continues_to_the_same_numbers(monkeypatch):
    case = CASES["accel, 33 environments, GRU"]
    method, _ = trained(case, True, monkeypatch)
    twin, _ = trained(case, True, monkeypatch, updates=1)
    twin.load_state_dict(method.state_dict())
    for _ in range(2):
        ours, theirs = (
            {name: value for name, value in one.update().items() if not name.startswith("time/")}
            for one in (method, twin)
        )
        assert ours == pytest.approx(theirs, rel=0, abs=0, nan_ok=True)
