"""The maze study: a small study is trained, stored and tabulated."""

import csv

import numpy as np
import pytest

from lab import maze_tables, mazes
from regista.experiments.run import significance
from ued.statistics import Difference

SMALL = """
from functools import partial
from regista.envs.maze.config import MazeConfig
from regista.envs.maze.task import make_mazes
from ued.core.task import Task

make = partial(make_mazes, config=MazeConfig(side=4, num_walls=3, max_steps=16))
small = Task(make, tests={"Maze": make, "FourRooms": make}, held_out={"Labyrinth": make}, success_word="solved")
"""
BRIEF = "--num-envs 4 --num-steps 64 --eval-every 1024 --eval-episodes 1 --hidden-size 8"


@pytest.fixture
def stored(tmp_path, trained_here, monkeypatch):
    """Return two runs of two methods, trained and stored."""
    (tmp_path / "small_mazes.py").write_text(SMALL)
    rows = {"dr": f"--method dr {BRIEF}", "mine": f"--method plr {BRIEF}"}
    part = mazes.Part(f"{tmp_path}/small_mazes.py:small", "25 blocks", 2, 2048, rows)
    for name, value in (("EPISODES", 1), ("LEVELS", 10), ("ROWS", tmp_path)):
        monkeypatch.setattr(mazes, name, value)
    monkeypatch.setattr(maze_tables, "ROWS", tmp_path)
    monkeypatch.setitem(mazes.PARTS, "tiny", part)
    words = ["tiny", "--out", str(tmp_path), "--processes", "1"]
    assert mazes.main([*words, "--seeds", "1"]) == 0
    assert {row["seed"] for row in read(tmp_path / "maze_levels.csv")} == {"0"}
    assert mazes.main(words) == 0  # the second seed
    assert mazes.main(words) == 0  # nothing left to train
    (tmp_path / "maze_published.csv").write_text(
        "walls,env_steps,runs,method,maze,solved\n25 blocks,1,10,dr,Maze,0.5\n25 blocks,1,10,dr,Labyrinth,0.2\n"
    )
    return tmp_path


def read(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
@pytest.mark.drawn
@pytest.mark.long
def test_a_small_study_is_trained_stored_and_tabulated(stored):
    tests, levels, curves = (read(stored / f"maze_{kind}.csv") for kind in ("tests", "levels", "curves"))
    trained = [row for row in tests if row["method"] in ("dr", "mine")]
    assert len({(row["method"], row["seed"], row["maze"]) for row in trained}) == len(trained)
    assert {row["maze"] for row in trained} >= {"Maze", "FourRooms", "Labyrinth"}
    runs = {("dr", "0"), ("dr", "1"), ("mine", "0"), ("mine", "1")}
    assert {(row["method"], row["seed"]) for row in levels} == runs  # without baselines
    first = [row for row in curves if (row["method"], row["seed"]) == ("dr", "1")]
    assert first[-1]["env_steps"] == first[-1]["trained_steps"] == "2048"
    replayed = [row for row in curves if row["method"] == "mine"][-1]
    assert int(replayed["trained_steps"]) <= int(replayed["env_steps"])
    study = maze_tables.Study("tiny")
    assert study.methods == ["dr", "mine"]
    head, dr, mine = maze_tables.summary(study)
    assert dr[head.index("published")] == "35%" and mine[head.index("published")] == ""
    late = maze_tables.late_rates(study, "dr")
    last = [float(row["solved"]) for row in curves if row["method"] == "dr" and int(row["env_steps"]) == 2048]
    np.testing.assert_allclose(late, last)  # evaluations after 256, 1024 and 2048 steps
    cells = {row[0]: row for row in maze_tables.by_maze(study)[1:]}
    assert cells["Maze"][1].endswith("(50%)") and "(" not in cells["FourRooms"][1]
    table = maze_tables.equal_steps(study, 1024)
    assert [row[1] for row in table[1:]] == ["0.0M", "0.0M"]
    some = maze_tables.Study("tiny")
    some.levels, some.tests = (
        [row for row in rows if (row.method, row.seed) == ("dr", 1)] for rows in (study.levels, study.tests)
    )
    some.curves = first
    head, *long = maze_tables.long_runs(some, [1024, 2048])
    assert long[0][1:3] == [f"{float(row['solved']):.0%}" for row in first if int(row["env_steps"]) >= 1024]
    assert long[0][head.index("published")] == "35%"
    maze_tables.draw(study, stored / "curves.png")
    assert (stored / "curves.png").stat().st_size > 10_000


def test_a_difference_has_its_mark():
    assert significance.points(Difference(0.1, 0.02, 0.2, 0.001), "*") == "+10 [+2, +20] *"
    assert significance.points(Difference(0.1, np.nan, np.nan, np.nan), "") == "+10"


def test_seeds_of_the_study_are_not_those_of_tuning():
    tuned = {int(row["seed"]) for row in read(mazes.ROWS / "maze_tuning.csv")}
    assert tuned and not tuned & {seed for part in mazes.PARTS.values() for seed in range(part.seeds)}
