"""What is built installs beside a project with an `envs` folder of its own, trains there, and compares."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
TASK = """
import gymnasium
import regista.envs.mine
import ued

def make(num_envs):
    return ued.GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), envs.mine.put, {"length": (0.2, 2.0)}, num_envs)
"""
PUT = "def put(env, values):\n    env.unwrapped.length = values['length']\n"
SHORT = ["--total-env-steps", "512", "--num-envs", "4", "--num-steps", "32", "--no-record", "--eval-every", "0"]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Return a folder with what a wheel of ours holds, and nothing of the checkout."""
    folder = tmp_path_factory.mktemp("installed")
    source = folder / "source"
    source.mkdir()
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, tracked.split("\0")):
        if name.startswith("tests/") or not (ROOT / name).is_file():
            continue
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--target"]
    done = subprocess.run([*command, str(folder / "site"), str(source)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return folder / "site"


def call(installed, folder, *words):
    """Run Python in a folder, with what is installed before the checkout."""
    environment = os.environ | {"PYTHONPATH": str(installed), "OMP_NUM_THREADS": "1", "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, *words]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def test_nothing_of_ours_lies_at_the_top_but_what_others_import(installed):
    assert {path.name for path in installed.iterdir() if path.suffix == "" and path.name != "bin"} == {
        "regista",
        "scenic_lite",
        "ued",
    }
    assert (installed / "regista" / "envs" / "football" / "scenic" / "library").is_dir()
    assert list((installed / "regista" / "minigames").rglob("*.scenic"))


def test_type_checkers_read_what_is_installed(installed):
    """PEP 561: without its marker a package is `Any` to mypy and to editors."""
    assert all((installed / package / "py.typed").is_file() for package in ("regista", "scenic_lite", "ued"))
    assert "from regista.experiments.calls import train" in (installed / "regista" / "__init__.py").read_text()


def test_it_trains_and_compares_beside_an_envs_of_yours(installed, tmp_path):
    (tmp_path / "envs").mkdir()
    (tmp_path / "envs" / "__init__.py").touch()
    (tmp_path / "envs" / "mine.py").write_text(PUT)
    (tmp_path / "task.py").write_text(TASK)
    settings = ["--methods", "plr", "--seeds", "1", "--processes", "1", "--episodes", "4", "--levels", "0"]
    done = call(installed, tmp_path, "-m", "regista", "compare", "task.py:make", *settings, *SHORT, "--out", "both")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "both" / "table.md").exists() and (tmp_path / "both" / "plr-0" / "checkpoint.pt").exists()


def test_football_is_found_inside_regista(installed, tmp_path):
    told = call(
        installed,
        tmp_path,
        "-c",
        "import gymnasium, sys, regista, regista.envs.football.vector_env as football\n"
        "env = gymnasium.make('regista:regista/1v1Free-v0'); env.reset(seed=0)\n"
        "print(football.__file__, 'envs' in sys.modules)",
    )
    assert told.returncode == 0, told.stderr
    file, clash = told.stdout.split()
    assert Path(file).is_relative_to(installed) and clash == "False"


def test_the_core_needs_three_packages():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert [line.partition(">")[0] for line in project["dependencies"]] == ["gymnasium", "numpy", "torch"]


def test_the_version_is_told():
    done = call(ROOT, ROOT, "-m", "regista", "--version")
    assert done.stdout.startswith("regista ") and done.returncode == 0
