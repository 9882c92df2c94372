"""Tests of an installed Regista: its commands work in a project that has its own `envs` folder.

Read next: `test_build`, which checks the contents of wheels.
"""

import csv
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.wheels import ROOT, build_wheel, clone, install, run

pytestmark = pytest.mark.slow

TASK = """
import gymnasium
import envs.mine
import ued

def make(num_envs):
    return ued.GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), envs.mine.put, {"length": (0.2, 2.0)}, num_envs)
"""
PUT = "def put(env, values):\n    env.unwrapped.length = values['length']\n"
FOREIGN = "raise AssertionError('Regista imported a folder of the user')\n"
GAME = "1v1Restricted"
TINY = ["--num-envs", "4", "--num-steps", "32"]
SHORT = [*TINY, "--total-env-steps", "256", "--no-record", "--eval-every", "0"]
FEW = ["--episodes", "2", "--levels", "0"]


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Return the Python of an environment in which a wheel of this checkout is installed."""
    folder = tmp_path_factory.mktemp("installed")
    return install(build_wheel(clone(folder / "clone"), folder / "wheel"), folder / "environment")


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Return a user's project, whose folders have the same names as folders of Regista's repository."""
    folder = tmp_path_factory.mktemp("project")
    for name, text in {"envs": "", "kernels": FOREIGN, "minigames": FOREIGN, "experiments": FOREIGN}.items():
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(text)
    (folder / "envs" / "mine.py").write_text(PUT)
    (folder / "task.py").write_text(TASK)
    return folder


@pytest.fixture
def regista(python, project):
    """Return a function that runs a command in the project, whose folders come first on `sys.path`."""

    def call(*words):
        done = run([python, "-m", "regista", *words], project)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return call


@pytest.fixture(scope="module")
def trained(python, project):
    """Return a run that was killed after its first checkpoint, and resumed."""
    folder = project / "runs" / "paired"
    words = ["train", GAME, "--method", "paired", *TINY, "--checkpoint-seconds", "0.001", "--out", str(folder)]
    script = python.with_name("regista")
    with open(project / "said.txt", "w") as said:
        process = subprocess.Popen(
            [script, *words], cwd=project, stdout=said, stderr=said, env={"PATH": "/usr/bin:/bin"}
        )
    until = time.monotonic() + 280
    while not (folder / "checkpoint.pt").exists():
        assert process.poll() is None and time.monotonic() < until, (project / "said.txt").read_text()
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    done = run([script, "train", "--resume", folder, "--total-env-steps", "4096"], project)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_checkout_is_not_what_runs(python, project):
    told = run([python, "-c", "import regista, sys; print(regista.__file__, *sys.path, sep='\\n')"], project).stdout
    file, *places = told.splitlines()
    assert Path(file).is_relative_to(python.parents[1]) and str(ROOT) not in places


@pytest.mark.long
def test_a_killed_run_is_resumed_and_recorded(trained):
    with open(trained / "metrics.csv") as file:
        steps = [int(float(row["env_steps"])) for row in csv.DictReader(file)]
    assert steps == sorted(set(steps)) and steps[-1] >= 4096
    assert (trained / "curriculum.rrd").stat().st_size > 10_000


@pytest.mark.long
def test_a_run_is_evaluated(trained, regista):
    assert "easy" in regista("evaluate", str(trained), *FEW)


@pytest.mark.long
def test_a_shipped_policy_plays_and_is_evaluated(regista, project):
    regista("play", "--player", "shipped:maze", "--video", "maze.gif")
    assert (project / "maze.gif").stat().st_size > 1000
    assert "shipped:maze" in regista("list")
    assert "random" in regista("evaluate", "shipped:maze", "--episodes", "2", "--levels", "0")


@pytest.mark.long
def test_methods_are_compared(regista, project):
    regista(
        "compare", GAME, "--methods", "dr", "plr", "--seeds", "1", "--processes", "1", *FEW, *SHORT, "--out", "both"
    )
    assert "plr" in (project / "both" / "table.md").read_text()
    assert (project / "both" / "plr-0" / "checkpoint.pt").exists()


@pytest.mark.long
def test_a_match_is_played_and_replayed(regista, project):
    regista("play", GAME, "--steps", "20", "--video", "match.gif", "--record", "match.npz")
    assert (project / "match.gif").stat().st_size > 1000
    regista("play", "--replay", "match.npz", "--video", "again.gif")
    assert (project / "again.gif").read_bytes() == (project / "match.gif").read_bytes()


@pytest.mark.long
def test_a_program_is_inspected_and_all_are_listed(regista, project):
    assert "6" in regista("inspect", GAME, "--png", "scenes.png")
    assert (project / "scenes.png").stat().st_size > 1000
    assert GAME in regista("list")


@pytest.mark.long
def test_a_task_imports_the_envs_of_its_project(regista, project):
    settings = ["--methods", "plr", "--seeds", "1", "--processes", "1", *FEW]
    regista("compare", "task.py:make", *settings, *SHORT, "--out", "task")
    assert (project / "task" / "table.md").exists() and (project / "task" / "plr-0" / "checkpoint.pt").exists()


HELP = """
import contextlib, io, sys
from regista.experiments.__main__ import main

for command in sys.argv[1:]:
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.suppress(SystemExit):
        main([command, "--help"])
    print(command, shown.getvalue().startswith(f"usage: regista {command}"))
"""


def test_every_command_has_help(regista, python, project):
    commands = re.findall(r"^  (\w+)  ", regista("--help"), re.M)
    assert len(commands) >= 10
    told = run([python, "-c", HELP, *commands], project)
    assert told.stdout.splitlines() == [f"{command} True" for command in commands], told.stderr


@pytest.mark.long
def test_gymnasium_makes_a_minigame(python, project):
    code = "import gymnasium; print(gymnasium.make('regista:regista/1v1Free-v1').reset(seed=0)[0].shape)"
    done = run([python, "-c", code], project)
    assert done.stdout.startswith("("), done.stderr


def test_the_version_is_told(regista):
    assert re.fullmatch(r"regista \d+\.\d+\.\d+\n", regista("--version"))
