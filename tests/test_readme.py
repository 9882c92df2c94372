"""Tests of claims in the README and its linked pages: tables, extras, commands, citation. Read next: `test_docs`."""

import re
import shutil
import subprocess
import tomllib
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import pytest
import torch

from regista.experiments.__main__ import COMMANDS
from tests import pages
from tests.pages import ROOT
from ued.methods import METHODS

README = (ROOT / "README.md").read_text()
HOWTO = ROOT / "docs" / "howto"
STEPS = "200_000"  # of training in the example; the test takes fewer


def blocks(text, *languages):
    """Return the texts of a page's fenced blocks in the given languages."""
    return [block.text for block in pages.blocks(text) if block.language in languages]


@pytest.mark.slow
def test_the_wrapper_on_an_environment_of_ones_own(capsys):
    torch.set_num_threads(1)
    python = blocks((HOWTO / "environment.md").read_text(), "python")
    (example,) = [text for text in python if "GymUPOMDP(" in text and "Paired(" in text]
    assert example.count(STEPS) == 1
    names = {}
    exec(example.replace(STEPS, "6_000"), names)
    method, upomdp = names["method"], names["upomdp"]
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == method.updates + 1 and method.env_steps >= 6_000
    assert "'return/protagonist'" in lines[0] and "'regret'" in lines[-2]
    values = upomdp.describe(method.last.theta)
    assert values and str(values) == lines[-1]
    for draw in upomdp.parameters:
        assert all(draw.low <= level[draw.name] <= draw.high for level in values)


def test_a_task_of_ones_own_can_be_made_tested_and_described():
    (example,) = [text for text in blocks((HOWTO / "environment.md").read_text(), "python") if "ued.Task(" in text]
    names = {}
    exec(example, names)
    upomdp = names["pendulum"].make(2)
    theta = upomdp.theta_of(names["pendulum"].tests["usual"])
    assert upomdp.describe(theta) == [{"gravity": 10.0, "mass": pytest.approx(1.0), "length": 1.0}]
    upomdp.reset(options={"theta": [theta, -theta]})
    assert upomdp.vector.envs[0].unwrapped.g == 10.0 and len(upomdp.render()) == 2


@pytest.mark.slow
def test_the_curriculum_with_a_trainer_of_ones_own():
    """The trainer's student never improves: it solves a level with probability 0.5 - theta[0], clipped to [0, 1]."""
    (example,) = [text for text in blocks((HOWTO / "trainer.md").read_text(), "python") if "propose(" in text]
    learned = []

    def play(theta, learn):
        learned.append(bool(learn))
        return float(np.random.default_rng(len(learned)).random() < 0.5 - theta[0])

    names = {"play": play}
    exec(example, names)
    assert len(learned) == 100 * 16 * 2
    assert names["metrics"]["buffer/fill_ratio"] > 0.5 and any(learned) and not all(learned)  # only replayed levels


def test_every_method_is_in_the_table():
    table = re.search(r"(^\|.*\n)+", (ROOT / "docs" / "methods.md").read_text(), re.M)[0]  # the first one
    shown = re.findall(r"^\| `\w+` .*$", table, re.M)
    assert shown == [f"| `{row.name}` | {row.paper} | {row.help} | {row.steps} |" for row in METHODS.values()]


def test_every_command_is_shown():
    """`test_docs` checks the flags of these commands."""
    shown = re.findall(r"^regista (\w+)", (ROOT / "docs" / "commands.md").read_text(), re.M)
    assert set(shown) == set(COMMANDS)


def test_the_first_screen_stays_short_and_names_every_method():
    assert len(README.splitlines()) <= 60
    table = re.search(r"(^\|.*\n)+", README, re.M)[0]
    assert set(re.findall(r"`(\w+)`", table)) == set(METHODS)
    assert "fourteen methods" in README.replace("\n", " ") and len(METHODS) == 14


def test_pip_takes_the_extras_that_are_named():
    named = re.findall(r"^pip install .*\[([\w,]+)\]", "".join(blocks(README, "console")), re.M)
    assert named
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(",".join(named).split(",")) <= set(project["optional-dependencies"])
    assert f"Python {project['requires-python'].removeprefix('>=')} or newer" in README


def test_the_citation_is_of_this_version():
    citation = (ROOT / "CITATION.cff").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert f"\nversion: {project['version']}\n" in citation and f"\nlicense: {project['license']}\n" in citation
    assert f"## {project['version']} " in (ROOT / "CHANGELOG.md").read_text()


def test_the_new_names_of_an_upgrade_are_there():
    """The right column names a module, modules beside it as `.name`, and attributes of the first module."""
    rows = re.findall(r"^\| .+ \| (.+) \|$", (ROOT / "docs" / "upgrading.md").read_text(), re.M)
    named = [[text for text in re.findall(r"`([^`]+)`", row) if not text.startswith("--")] for row in rows]
    modules = [names for names in named if names and names[0].split(".")[0] in ("scenic_lite", "regista", "ued")]
    assert len(modules) > 20
    for first, *others in modules:
        for name in [first, *(first.rpartition(".")[0] + other for other in others if other.startswith("."))]:
            assert find_spec(name) is not None, name
        for name in [other for other in others if "." not in other]:
            assert hasattr(import_module(first), name), f"{first}: {name}"


def test_make_clean_takes_all_that_running_and_testing_leave(tmp_path):
    shutil.copy(ROOT / "Makefile", tmp_path)
    left = [
        "runs/a/b.csv",
        "demo/c.png",
        "build/d",
        "ued/__pycache__/e.pyc",
        "f.egg-info/g",
        ".venv/h",
        ".hypothesis/i",
    ]
    for name in [*left, "ued/kept.py"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    subprocess.run(["make", "clean"], cwd=tmp_path, check=True, capture_output=True)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["Makefile", "kept.py", "ued"]
