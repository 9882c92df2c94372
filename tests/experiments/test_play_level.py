"""A row of levels.csv is a level: `regista play --level` and `ued.read_level` find what was played."""

import csv

import numpy as np
import pytest

import ued
from regista.experiments.__main__ import main
from regista.experiments.run.config import EngineConfig
from regista.experiments.run.level_stage import LevelStage

SMALL = ["--total-env-steps", "1024", "--num-envs", "4", "--num-steps", "64", "--eval-every", "0", "--no-record"]
TASK = """
import gymnasium
import numpy as np
import ued

class Cave(gymnasium.Env):
    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}
    observation_space = gymnasium.spaces.Box(0, 1, (3,), np.float32)
    action_space = gymnasium.spaces.Discrete(2)
    render_mode = "rgb_array"

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.walls, self.t = self.np_random.random(3).astype(np.float32), 0
        return self.walls, {}

    def step(self, action):
        self.t += 1
        return self.walls, float(action), self.t >= 4, False, {}

    def render(self):
        return np.full((16, 16, 3), int(255 * self.walls[0]), np.uint8)

def put(env, values):
    pass

def make(num_envs):
    return ued.GymUPOMDP(Cave, put, {"depth": (0, 1)}, num_envs)

caves = ued.Task(make)
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("caves")
    (folder / "caves.py").write_text(TASK)
    words = ["train", f"{folder / 'caves.py'}:caves", "--method", "plr", *SMALL, "--out", str(folder / "run")]
    assert main(words) == 0
    return folder / "run"


def rows(run):
    with open(run / "levels.csv", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_a_row_is_the_level_to_the_last_bit(run):
    seen: dict[str, set[tuple[str, str]]] = {}
    for row in rows(run):
        seen.setdefault(row["id"], set()).add((row["seed"], row["theta/depth"]))
        level = ued.read_level(run, int(row["id"]), int(row["visit"]))
        assert int(level["seed"][0]) == int(row["seed"]) and level["theta"][0, 0] == float(row["theta/depth"])
    assert all(len(levels) == 1 for levels in seen.values())
    stage = LevelStage.of_run(run, int(rows(run)[3]["id"]), None, EngineConfig())
    walls = np.random.default_rng(int(rows(run)[3]["seed"])).random(3).astype(np.float32)
    assert (stage.env.vector.envs[0].unwrapped.walls == walls).all()


@pytest.mark.slow
def test_a_level_is_played_and_filmed(run, tmp_path, capsys):
    row = rows(run)[5]
    assert main(["play", "--level", str(run), "--id", row["id"], "--video", str(tmp_path / "cave.gif")]) == 0
    shown = capsys.readouterr().out
    numbers = f", random numbers of visit {row['visit']}" if row["visit"] != "0" else ""
    assert f"level of seed {row['seed']}{numbers}: depth = " in shown and "4 steps by random actions" in shown
    assert (tmp_path / "cave.gif").stat().st_size > 0


@pytest.mark.slow
def test_what_is_no_level_is_said(run, capsys):
    assert main(["play", "--level", str(run), "--id", "999999"]) != 0
    assert "has no level 999999" in capsys.readouterr().err
    assert main(["play", "--level", str(run)]) == 2
    assert main(["play", "1v1Free", "--level", str(run), "--id", "1"]) == 2
    assert main(["play", "--level", str(run), "--id", "1", "--control", "all"]) == 2
    with pytest.raises(KeyError, match="has no level"):
        ued.read_level(run, 10**9)


@pytest.mark.slow
def test_a_task_is_no_start_for_football(run, tmp_path, capsys):
    assert main(["train", "1v1Free", "--from", str(run), "--out", str(tmp_path / "out"), *SMALL]) != 0
    assert "which has other observations" in capsys.readouterr().err


@pytest.mark.slow
def test_a_minigame_in_a_python_file_is_played_by_random_actions(tmp_path, capsys):
    file = tmp_path / "football_task.py"
    file.write_text("from regista.minigames import MINIGAMES\n\ngame = MINIGAMES['1v1Restricted'].task()\n")
    out = str(tmp_path / "run")
    assert main(["train", f"{file}:game", "--method", "dr", *SMALL, "--out", out]) == 0
    capsys.readouterr()
    assert main(["play", "--level", out, "--id", "1"]) == 0
    assert "by random actions" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--replay", "x.npz", "--id", "3"], "it supports only --match, --video and --speed"),
        (["--replay", "x.npz", "1v1Free"], "it supports only --match, --video and --speed"),
        (["1v1Free", "--match", "0"], "--match needs --replay RECORD"),
        (["1v1Free", "--visit", "3"], "it needs --level RUN --id N"),
    ],
)
def test_flags_of_other_plays_are_refused(flags, message, capsys):
    assert main(["play", *flags]) == 2
    assert message in capsys.readouterr().err


def test_a_task_has_no_engine(run, capsys):
    assert main(["play", "--level", str(run), "--id", "1", "--engine", "grf"]) == 2
    assert main(["evaluate", str(run), "--engine", "grf"]) == 2
    assert capsys.readouterr().err.count("--engine grf plays football") == 2
