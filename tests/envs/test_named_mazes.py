"""The benchmark's test mazes, shortest paths, the task, pictures, and Gymnasium's names for mazes."""

from __future__ import annotations

import warnings
from collections import deque
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import regista
from regista.envs.maze import drawings
from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.envs.maze.generators import CROSSINGS, four_rooms, perfect_maze, simple_crossing
from regista.envs.maze.grid import BORDER
from regista.envs.maze.levels import maze_from
from regista.envs.maze.named_mazes import LARGE_MAZES, TEST_MAZES
from regista.envs.maze.painter import AGENT, CELL, FRONT, GOALS, SEEN, WALLS, MazePainter
from regista.envs.maze.paths import UNREACHABLE, path_lengths
from regista.envs.maze.picture import AGENT_COLOR, GOAL_COLOR, SEEN_WALL, WALL_COLOR
from regista.envs.maze.shortest_path import ShortestPath
from regista.envs.maze.task import make_mazes, maze
from ued import METHODS, PPOConfig
from ued.core.baselines import UniformPolicy
from ued.core.painter import details_of, tiles_of, trails_of
from ued.evaluation import evaluate

ALL = {**TEST_MAZES, **LARGE_MAZES}
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))  # right, down, left, up


def cells_from(walls, start):
    """Return how many cells there are on the way from a cell to each that can be reached from it."""
    found, queue = {start: 0}, deque([start])
    while queue:
        row, column = queue.popleft()
        for down, right in STEPS:
            cell = row + down, column + right
            if min(cell) >= 0 and max(cell) < len(walls) and not walls[cell] and cell not in found:
                found[cell] = found[row, column] + 1
                queue.append(cell)
    return found


def fewest_steps(level):
    """Return how many steps, turns included, it takes an agent to the goal, None if it cannot be reached."""
    first = (*level.start, level.direction)
    found, queue = {first: 0}, deque([first])
    while queue:
        row, column, direction = queue.popleft()
        steps = found[row, column, direction]
        if (row, column) == level.goal:
            return steps
        ahead = row + STEPS[direction][0], column + STEPS[direction][1]
        options = [(row, column, (direction + turn) % 4) for turn in (1, 3)]
        if min(ahead) >= 0 and max(ahead) < len(level.walls) and not level.walls[ahead]:
            options.append((*ahead, direction))
        for option in options:
            if option not in found:
                found[option] = steps + 1
                queue.append(option)
    return None


# ---------------------------------------------------------------- layouts


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_every_test_maze_can_be_solved_within_its_time(name):
    test, rng = ALL[name], np.random.default_rng(0)
    for _ in range(30):
        level = test.draw(rng)
        assert level.walls.shape == (test.side, test.side)
        assert level.start != level.goal and not level.walls[level.start] and not level.walls[level.goal]
        assert fewest_steps(level) <= test.max_steps


@pytest.mark.parametrize(
    ("name", "layouts", "starts", "goals", "directions"),
    [
        *((name, 1, 1, 1, 4) for name in ("SixteenRooms", "Labyrinth", "Labyrinth2", "Maze", "Maze2", "Maze3")),
        ("SixteenRoomsFewerDoors", 1, 1, 1, 4),
        ("SmallCorridor", 1, 1, 10, 4),
        ("LargeCorridor", 1, 1, 16, 4),
        ("SimpleCrossing", 300, 1, 1, 1),
        ("FourRooms", 300, 150, 150, 4),
        ("PerfectMazeMedium", 300, 4, 4, 4),
    ],
)
def test_what_varies_from_episode_to_episode(name, layouts, starts, goals, directions):
    rng = np.random.default_rng(1)
    drawn = [TEST_MAZES[name].draw(rng) for _ in range(400)]
    counts = [
        len({level.walls.tobytes() for level in drawn}),
        len({level.start for level in drawn}),
        len({level.goal for level in drawn}),
        len({level.direction for level in drawn}),
    ]
    for count, expected in zip(counts, (layouts, starts, goals, directions), strict=True):
        assert count == expected if expected < 100 else count >= expected


def test_rooms_are_joined_by_doors():
    lines = (3, 6, 9)
    for drawing, doors in ((drawings.SIXTEEN_ROOMS, 23), (drawings.SIXTEEN_ROOMS_FEWER_DOORS, 16)):
        walls = maze_from(drawing.replace("S", ">")).walls
        inside = [place for place in range(13) if place not in lines]
        assert (~walls[np.ix_(lines, inside)]).sum() + (~walls[np.ix_(inside, lines)]).sum() == doors
        assert walls[np.ix_(lines, lines)].all() and not walls[np.ix_(inside, inside)].any()
        assert len(cells_from(walls, (0, 0))) == (~walls).sum()


@pytest.mark.parametrize(("drawing", "moves"), [(drawings.LABYRINTH, 118), (drawings.LABYRINTH_2, 118)])
def test_labyrinths_take_no_more_moves_than_dcd_says(drawing, moves):
    """DCD's docstrings give the length of a way that need not be the shortest."""
    assert fewest_steps(maze_from(drawing.replace("S", ">"))) <= moves


@pytest.mark.parametrize(("drawing", "dead_ends"), [(drawings.SMALL_CORRIDOR, 10), (drawings.LARGE_CORRIDOR, 16)])
def test_goals_of_corridors_lie_in_dead_ends_beside_the_wall(drawing, dead_ends):
    rows = drawing.split()
    goals = [(row, column) for row, text in enumerate(rows) for column, mark in enumerate(text) if mark == "G"]
    for row, column in goals:
        beside = [rows[row + down][column + right] for down, right in STEPS]
        assert beside.count("#") == 3 and rows[2 * (len(rows) // 2) - row][column] == "G"
    assert len(goals) == dead_ends


@pytest.mark.parametrize("side", [3, 19, 49])
def test_one_way_joins_any_two_cells_of_a_perfect_maze(side):
    nodes = (side + 1) // 2
    for seed in range(5):
        level = perfect_maze(side, np.random.default_rng(seed))
        assert (~level.walls).sum() == 2 * nodes**2 - 1  # a tree: its nodes, and an edge less
        assert len(cells_from(level.walls, level.start)) == (~level.walls).sum()


def test_perfect_mazes_are_drawn_over_all_their_trees():
    rng = np.random.default_rng(0)
    assert len({perfect_maze(3, rng).walls.tobytes() for _ in range(200)}) == 4  # spanning trees of a square


def test_four_rooms_have_a_gap_in_each_wall():
    rng = np.random.default_rng(0)
    for _ in range(50):
        walls = four_rooms(rng).walls
        assert [(~part).sum() for part in (walls[8, :8], walls[8, 9:], walls[:8, 8], walls[9:, 8])] == [1] * 4
        assert walls[8, 8] and walls.sum() == 2 * 17 - 1 - 4


def test_crossings_are_passed_once_each():
    rng = np.random.default_rng(0)
    for _ in range(100):
        level = simple_crossing(rng)
        rows, columns = level.walls.sum(1) >= 5, level.walls.sum(0) >= 5
        assert rows.sum() + columns.sum() == CROSSINGS and not rows[::2].any() and not columns[::2].any()
        across = int(rows.sum()) * 9 + int(columns.sum()) * 9 - int(rows.sum()) * int(columns.sum())
        assert level.walls.sum() == across - CROSSINGS  # one gap for each wall that is crossed
        rooms = cells_from(level.walls, level.start)
        assert level.goal in rooms and (level.start, level.goal, level.direction) == ((0, 0), (8, 8), 0)


# ---------------------------------------------------------------- shortest paths


def test_shortest_paths_are_those_of_a_search():
    mazes = Mazes(300, MazeConfig(side=6, num_walls=18))
    mazes.reset(seed=0)
    levels = [mazes.level_family.decode(row) for row in mazes.levels["theta"]]
    expected = [fewest_steps(level) for level in levels]
    assert expected.count(None) > 20
    assert path_lengths(mazes.layouts, mazes.width) == [UNREACHABLE if one is None else one for one in expected]
    told = mazes.describe(mazes.levels["theta"])
    assert [one["shortest path"] for one in told] == ["none" if n is None else f"{n} steps" for n in expected]
    assert [one["walls"] for one in told] == [int(level.walls.sum()) for level in levels]


@pytest.mark.parametrize("name", ["Labyrinth", "FourRooms", "PerfectMazeMedium"])
def test_the_shortest_path_policy_takes_that_many_steps(name):
    mazes = TEST_MAZES[name].make(5)
    played = evaluate(ShortestPath(Mazes(2)), mazes, 20, seed=3)  # made for others, as baselines are
    layouts = mazes.layouts_of(played.levels["theta"])
    assert played.success.all() and played.lengths.tolist() == path_lengths(layouts, mazes.width)
    np.testing.assert_allclose(played.returns, 1 - 0.9 * played.lengths / TEST_MAZES[name].max_steps)


def test_nobody_solves_what_cannot_be_solved():
    level = maze_from(">..\n...\n..G")
    level.walls[[0, 1, 1], [1, 0, 1]] = True
    mazes = Mazes(3, MazeConfig(side=3, max_steps=9))
    mazes.reset(seed=0)
    levels = mazes.make_levels(mazes.theta_of(level)[None])
    played = evaluate(ShortestPath(mazes), mazes, 3, 0, levels)
    assert not played.success.any() and played.lengths.tolist() == [9] * 3


# ---------------------------------------------------------------- the task


def test_the_task_tests_mazes_of_other_sizes_with_the_same_view():
    assert len(maze.tests) == 12 and set(maze.held_out) == {"PerfectMazeLarge"} and set(maze.about) == set(ALL)
    trained = maze.make(2)
    sizes = set()
    for name, make in {**maze.tests, **maze.held_out}.items():
        test = make(3)
        sizes.add(test.config.side)
        assert test.single_observation_space == trained.single_observation_space, name
        seen, _ = test.reset(seed=0)
        assert test.observation_space.contains(seen)
        twin = make(3)
        np.testing.assert_array_equal(twin.reset(seed=0)[0], seen)
        np.testing.assert_array_equal(twin.levels["theta"], test.levels["theta"])
    assert sizes == {9, 13, 17, 19, 49}


@pytest.mark.slow
@pytest.mark.parametrize("representation", ["features", "image"])
def test_walls_hide_cells_in_minigrids_own_mazes(representation):
    config = MazeConfig(representation=representation)
    for name, test in ALL.items():
        hidden, known = test.make(50, config), test.make(50, replace(config, see_through=False))
        seen, full = hidden.reset(seed=0)[0], known.reset(seed=0)[0]
        np.testing.assert_array_equal(hidden.levels["theta"], known.levels["theta"])
        inside = slice(0, 75) if representation == "image" else slice(0, 50)
        opaque = name in ("FourRooms", "SimpleCrossing")
        assert (seen[:, inside] == full[:, inside]).all() == opaque, name


@pytest.mark.long
def test_one_student_plays_them_all_and_baselines_are_its_bounds():
    mazes = make_mazes(8)
    method = METHODS["dr"].load()(mazes, PPOConfig(num_steps=16, num_minibatches=1, memory="gru", hidden_size=16))
    method.update()
    policies = maze.make_baselines(mazes)
    assert set(policies) == {"shortest path", "random"} and isinstance(policies["random"], UniformPolicy)
    for name, make in maze.tests.items():
        best = evaluate(policies["shortest path"], make(4), 4, seed=0)
        found = evaluate(method.student, make(4), 4, seed=0)
        np.testing.assert_array_equal(best.levels, found.levels)
        assert best.success.all() and (best.lengths <= found.lengths).all(), name


# ---------------------------------------------------------------- pictures


def test_a_picture_shows_walls_goal_and_agent():
    mazes = Mazes(2, MazeConfig(), "rgb_array")
    mazes.reset(seed=0)
    for picture, row in zip(mazes.render(), mazes.levels["theta"], strict=True):
        level = mazes.level_family.decode(row)
        size = len(picture) // 15
        corners = picture[1::size, 1::size][:15, :15]  # away from the arrow head
        dark = (corners == WALL_COLOR).all(-1) | (corners == SEEN_WALL).all(-1)
        np.testing.assert_array_equal(dark, np.pad(level.walls, 1, constant_values=True))
        assert tuple(corners[level.goal[0] + 1, level.goal[1] + 1]) == GOAL_COLOR
        agent = np.argwhere((picture == AGENT_COLOR).all(-1)) // size - 1
        assert {tuple(cell) for cell in agent.tolist()} == {level.start}
    assert Mazes(1).render() is None
    with pytest.raises(ValueError, match="render_mode"):
        Mazes(1, render_mode="human")


def test_an_agent_is_drawn_facing_where_it_looks():
    heads = []
    for arrow in ">v<^":
        level = maze_from(f"...\n.{arrow}.\n..G")
        mazes = Mazes(1, MazeConfig(side=3), "rgb_array")
        mazes.reset(options={"theta": mazes.theta_of(level)[None]})
        picture = mazes.render()[0]
        size = len(picture) // 5
        agent = np.argwhere((picture[2 * size : 3 * size, 2 * size : 3 * size] == AGENT_COLOR).all(-1)) - size / 2
        row, column = agent.mean(0)  # the base is heavier than the tip
        heads.append(int(np.argmax([-column, -row, column, row])))
    assert heads == [0, 1, 2, 3]


@pytest.mark.parametrize("see_through", [True, False])
def test_the_painter_puts_everything_in_its_place(see_through):
    mazes = Mazes(1, MazeConfig(side=5, num_walls=7, see_through=see_through))
    mazes.reset(seed=4)
    painter, level = MazePainter(mazes), mazes.level_family.decode(mazes.levels["theta"][0])
    (points,), frame = painter.positions(mazes.levels["theta"]), painter.frame(mazes)

    def cells(places, kind):
        known = places[(painter.classes == kind) & np.isfinite(places).all(1)]
        columns, rows = (known / CELL - 0.5).T
        return {(int(4 - row), int(column)) for row, column in zip(rows, columns, strict=True)}

    for places in (points, frame):
        assert cells(places, WALLS) == {tuple(cell) for cell in np.argwhere(level.walls).tolist()}
        assert (cells(places, GOALS), cells(places, AGENT)) == ({level.goal}, {level.start})
    x, y = (points[painter.classes == FRONT] - points[painter.classes == AGENT])[0]
    assert level.direction == int(np.argmax([x, -y, -x, y]))
    shown = {(at // mazes.width - BORDER, at % mazes.width - BORDER) for at in mazes.seen()[0].tolist()}
    assert not cells(points, SEEN)
    assert cells(frame, SEEN) == {cell for cell in shown if min(cell) >= 0 and max(cell) < 5}
    assert (len(shown) == 25) == see_through
    kinds = painter.classes
    assert tiles_of(painter).tolist() == (kinds == WALLS).tolist()
    assert trails_of(painter).tolist() == np.isin(kinds, (GOALS, AGENT)).tolist()
    assert (details_of(painter) | trails_of(painter) | tiles_of(painter)).all()
    assert painter.positions(np.zeros((0, mazes.theta_dim))).shape == (0, len(kinds), 2)


# ---------------------------------------------------------------- Gymnasium


def test_gymnasium_makes_mazes():
    name = "regista/Maze-v0"
    assert regista.minigames  # importing it registers them
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(name, side=7, num_walls=9, render_mode="rgb_array")
        check_env(env.unwrapped)
    assert env.reset(seed=3)[0].shape == (54,)
    given = env.reset(seed=3)[1]["theta"]
    played = env.reset(options={"theta": given})[1]
    assert (played["theta"] == given).all() and played["replaced"] is False
    assert env.reset(options={"theta": np.zeros(len(given))})[1]["replaced"] is True  # start and goal in one cell
    assert (env.reset()[1]["theta"] != given).any()
    assert env.render().shape[2] == 3
    batch = gymnasium.make_vec(name, num_envs=4, max_steps=5)
    assert isinstance(batch, Mazes) and batch.config == replace(MazeConfig(), max_steps=5)
    batch.reset(seed=0)
    before = batch.levels["theta"].copy()
    for _ in range(5):
        info = batch.step(np.zeros(4, int))[4]
    assert info["_final_obs"].all() and (batch.levels["theta"] != before).any(1).all()  # new mazes


def test_one_maze_is_a_batch_of_one():
    env = gymnasium.make("regista/Maze-v0", max_steps=40)
    batch, rng = Mazes(1, MazeConfig(max_steps=40)), np.random.default_rng(0)
    seen = env.reset(seed=5)[0]
    np.testing.assert_array_equal(batch.reset(seed=5)[0][0], seen)
    ended = False
    while not ended:
        action = int(rng.integers(3))
        ours, theirs = env.step(action), batch.advance(np.array([action]))
        np.testing.assert_array_equal(ours[0], theirs[0][0])
        assert ours[1:4] == tuple(part[0] for part in theirs[1:4])
        assert ours[4]["success"] == theirs[4]["success"][0]
        ended = ours[2] or ours[3]
