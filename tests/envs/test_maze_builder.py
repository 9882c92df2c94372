"""Mazes built step by step: the rules of DCD, against the same rules written for one maze at a time."""

import numpy as np
import pytest
import torch

from regista.envs.maze.builder import NOWHERE, MazeBuilder
from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from regista.envs.maze.levels import MazeFamily, maze_from
from ued import METHODS, PPOConfig


def built(family, actions, luck=0):
    """Return the maze that these actions build."""
    builder, levels = family.builder, family.builder.begin(np.array([luck]))
    for action in actions:
        levels = builder.apply(levels, np.array([action]))
    return family.decode(builder.codes(levels)[0])


def same(maze, drawing):
    return family_of(maze).encode(maze).tolist() == family_of(maze).encode(maze_from(drawing)).tolist()


def family_of(maze):
    return MazeFamily(len(maze.walls))


def test_goal_and_agent_come_first():
    maze = built(MazeFamily(3, 4), [8, 0, 4, 4, 8, 0])  # a wall in its own cell, the goal's and the agent's: nothing
    assert same(maze, ">.. .#. ..G")


def test_goal_and_agent_that_come_last_remove_walls():
    maze = built(MazeFamily(3, 4, goal_last=True), [1, 3, 4, 8, 8, 1], luck=2)
    assert same(maze, ".<. ##. ..G")


@pytest.mark.parametrize("goal_last", [False, True])
def test_an_agent_on_the_goal_goes_to_a_random_free_cell(goal_last):
    family = MazeFamily(3, 3, goal_last=goal_last)
    actions = [0, 1, 2, 4, 4] if goal_last else [4, 4, 0, 1, 2]
    starts = [built(family, actions, luck).start for luck in range(400)]
    free = {divmod(cell, 3) for cell in (range(3, 9) if goal_last else range(9))} - {(1, 1)}
    assert set(starts) == free
    counts = [starts.count(start) for start in free]
    assert max(counts) - min(counts) <= 400 / len(free) / 2


def test_an_agent_is_placed_even_where_all_cells_are_walls():
    maze = built(MazeFamily(2, 4, goal_last=True), [0, 1, 2, 3, 1, 1], luck=4)
    assert maze.start != maze.goal and maze.walls.sum() == 2


@pytest.mark.parametrize("goal_last", [False, True])
@pytest.mark.parametrize("first, walls", [(0, 0), (12, 4), (24, 8)])
def test_the_first_action_limits_the_walls(goal_last, first, walls):
    family = MazeFamily(5, 9, random_count=True, goal_last=goal_last)
    places = [cell for cell in range(25) if cell not in (first, 20, 21)]
    actions = [first, *places[: walls - 1], 20, 21] if goal_last else [first, 20, *places[:walls]]
    if not walls and goal_last:
        actions = [first, 21]  # the goal, the agent
    maze = built(family, [*actions, *places[-1:] * (family.builder.steps - len(actions))])
    assert maze.walls.sum() == walls


def reference(actions, luck, side, most, random_count, goal_last):
    """Build one maze by `AdversarialEnv.step_adversary`, as it is written there; return walls, goal and agent."""
    walls, goal, agent, limit = set(), None, None, most + 2
    for step, cell in enumerate(actions):
        if random_count and step == 0:
            limit = int(cell / side**2 * most) + 2
        if step >= limit:
            continue
        if step == (limit - 2 if goal_last else 0):
            walls.discard(cell)
            goal = cell
        elif step == (limit - 1 if goal_last else 1):
            walls.discard(cell)
            free = [other for other in range(side**2) if other not in walls and other != goal]
            agent = free[luck // 4 % len(free)] if cell == goal else cell
        elif cell not in (goal, agent):
            walls.add(cell)
    return walls, goal, agent


@pytest.mark.parametrize("random_count", [False, True])
@pytest.mark.parametrize("goal_last", [False, True])
def test_a_batch_is_built_as_one_maze_after_the_other(random_count, goal_last):
    rng, side, most = np.random.default_rng(0), 4, 9
    builder, luck = MazeBuilder(side, most, random_count, goal_last), rng.integers(2**31, size=300)
    actions = rng.integers(side**2, size=(builder.steps, 300))
    levels = builder.begin(luck)
    for step, row in enumerate(actions):
        seen = builder.observe(levels)
        assert seen.shape == (300, 3 * side**2 + 4) and set(np.unique(seen)) <= {0.0, 1.0}
        placed = seen[:, side**2 : -4].reshape(300, 2, -1).sum(2)  # goal, agent
        assert (placed[:, 0] == (levels.goal != NOWHERE)).all() and (placed[:, 1] == (levels.start != NOWHERE)).all()
        assert step == levels.step
        levels = builder.apply(levels, row)
    family = MazeFamily(side, most, random_count, goal_last)
    for column, code in enumerate(builder.codes(levels)):
        walls, goal, agent = reference(actions[:, column], luck[column], side, most, random_count, goal_last)
        maze = family.decode(code)
        assert {int(cell) for cell in np.flatnonzero(maze.walls)} == walls
        assert (maze.goal, maze.start) == (divmod(goal, side), divmod(agent, side))
        assert maze.direction == luck[column] % 4
        np.testing.assert_array_equal(family.encode(maze), code)


def test_random_actions_with_the_goal_last_build_the_random_mazes_of_the_family():
    rng, family = np.random.default_rng(0), MazeFamily(6, 12, goal_last=True)
    levels = family.builder.begin(rng.integers(2**31, size=4000))
    for _ in range(family.builder.steps):
        levels = family.builder.apply(levels, rng.integers(36, size=4000))
    codes, random = family.builder.codes(levels), family.draw_codes(rng, 4000)
    assert (codes[:, :36] > 0).sum(1).mean() == pytest.approx((random[:, :36] > 0).sum(1).mean(), abs=0.3)
    assert (codes[:, :36] > 0).mean(0).std() < 0.03 and abs(codes[:, 36:].mean(0)).max() < 0.05


@pytest.mark.parametrize("side, most", [(5, 0), (19, 20), (25, 5)])
def test_columns_of_codes_are_declared_at_any_size(side, most):
    family = MazeFamily(side, most)
    columns = family.parameters
    assert len(columns) == family.size == side**2 + 3
    share = (family.draw_codes(np.random.default_rng(0), 500)[:, : side**2] > 0).mean()
    weights = columns["wall[0, 0]"].weights
    assert weights[1] / sum(weights) == pytest.approx(max(share, 0.5 / side**2), rel=0.15)


@pytest.mark.parametrize("memory", ["none", "gru"])
def test_literal_paired_goes_on_where_no_episode_ends_within_a_rollout(memory):
    mazes = Mazes(4, MazeConfig(side=5, num_walls=4, max_steps=20))
    ppo = PPOConfig(num_steps=2, num_minibatches=2, memory=memory, hidden_size=8)
    method = METHODS["paired_literal"].load()(mazes, ppo, None, seed=0, env_steps=1000)
    before = [weight.clone() for weight in method.student.parameters()]
    for _ in range(2):
        method.update()
    assert method.env_steps == 2 * 2 * 2 * 4
    assert all(torch.equal(*pair) for pair in zip(before, method.student.parameters(), strict=True))
