"""What the README shows works as it stands there."""

import re
import shutil
import subprocess
import tomllib
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import torch

import envs.football.scenic.domain
import scenic_lite
from experiments.__main__ import COMMANDS, main
from ued.methods import METHODS

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()
STEPS = "200_000"  # of training, in the example; here fewer


def blocks(language):
    """The fenced blocks of a language, "" for those of none."""
    return [text for name, text in re.findall(r"^```(\w*)\n(.*?)^```", README, re.M | re.S) if name == language]


def test_the_wrapper_on_an_environment_of_ones_own(capsys):
    torch.set_num_threads(1)
    (example,) = [text for text in blocks("python") if "GymUPOMDP(" in text and "Paired(" in text]
    assert example.count(STEPS) == 1
    names = {}
    exec(example.replace(STEPS, "6_000"), names)
    method, upomdp = names["method"], names["upomdp"]
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == method.updates + 1 and method.env_steps >= 6_000
    assert "'return/protagonist'" in lines[0] and "'regret'" in lines[-2]
    values = upomdp.describe(method.last.theta)
    assert values and str(values) == lines[-1]
    for draw in upomdp.draws:
        assert all(draw.low <= level[draw.name] <= draw.high for level in values)


def test_a_task_of_ones_own_can_be_made_tested_and_described():
    (example,) = [text for text in blocks("python") if "ued.Task(" in text]
    names = {}
    exec(example, names)
    upomdp = names["pendulum"].make(2)
    theta = upomdp.theta_of(names["pendulum"].tests["usual"])
    assert upomdp.describe(theta) == [{"gravity": 10.0, "mass": pytest.approx(1.0), "length": 1.0}]
    upomdp.reset(options={"theta": [theta, -theta]})
    assert upomdp.vector.envs[0].unwrapped.g == 10.0 and len(upomdp.render()) == 2


def test_the_curriculum_with_a_trainer_of_ones_own():
    """The student of this trainer solves levels whose first parameter is below a frontier, which moves as it learns."""
    (example,) = [text for text in blocks("python") if "propose(" in text]
    learned = []

    def play(theta, learn):
        learned.append(bool(learn))
        return float(np.random.default_rng(len(learned)).random() < 0.5 - theta[0])

    names = {"play": play}
    exec(example, names)
    assert len(learned) == 100 * 16 * 2
    assert names["metrics"]["buffer/fill_ratio"] == 1.0 and any(learned) and not all(learned)  # replayed ones alone


def test_every_method_is_in_the_table():
    (section,) = re.findall(r"^## The methods\n(.*?)^## ", README, re.M | re.S)
    shown = re.findall(r"^\| `\w+` .*$", section, re.M)
    assert shown == [f"| `{row.name}` | {row.paper} | {row.help} | {row.steps} |" for row in METHODS.values()]


def test_the_scenario_has_the_free_parameters_that_are_promised():
    (text,) = blocks("")
    program = scenic_lite.load(text, envs.football.scenic.domain.FOOTBALL)
    assert f"here D = {program.dim}" in README
    assert program.sample(10, np.random.default_rng(0))[1].ok.all()


COMMAND_LINES = re.findall(r"^regista (\w+) ?([^#\n]*)", "".join(blocks("sh")), re.M)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_shown_with_flags_that_it_has(command, capsys):
    shown = [words for name, words in COMMAND_LINES if name == command]
    assert shown
    with pytest.raises(SystemExit):
        main([command, "--help", "all"])
    flags = set(re.findall(r"--[a-z.-]+", capsys.readouterr().out))
    assert set(re.findall(r"--[a-z.-]+", " ".join(shown))) <= flags


def test_pip_takes_the_extras_that_are_named():
    named = re.findall(r"^pip install .*\[([\w,]+)\]", "".join(blocks("console")), re.M)
    assert len(named) == 3
    extras = ",".join(named)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(extras.split(",")) <= set(project["optional-dependencies"])
    assert f"Python {project['requires-python'].removeprefix('>=')} or newer" in README


def test_the_citation_is_of_this_version():
    citation = (ROOT / "CITATION.cff").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert f"\nversion: {project['version']}\n" in citation and f"\nlicense: {project['license']}\n" in citation
    assert f"## {project['version']} " in (ROOT / "CHANGELOG.md").read_text()


def test_what_the_changelog_says_is_new_is_there():
    """Its right column names modules, in full or as `.name` beside the one before, and what is in them."""
    rows = re.findall(r"^\| .+ \| (.+) \|$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    named = [[text for text in re.findall(r"`([^`]+)`", row) if not text.startswith("--")] for row in rows]
    modules = [
        names for names in named if names and names[0].split(".")[0] in ("scenic_lite", "envs", "ued", "experiments")
    ]
    assert len(modules) > 20
    for first, *others in modules:
        for name in [first, *(first.rpartition(".")[0] + other for other in others if other.startswith("."))]:
            assert find_spec(name) is not None, name
        for name in [other for other in others if "." not in other]:
            assert hasattr(import_module(first), name), f"{first}: {name}"


def test_links_lead_somewhere():
    targets = [target for target in re.findall(r"\]\(([^)]+)\)", README) if "://" not in target]
    headings = {"#" + heading.lower().replace(" ", "-") for heading in re.findall(r"^#+ (.+)$", README, re.M)}
    assert targets and [name for name in targets if name not in headings and not (ROOT / name).exists()] == []


def test_make_can_do_what_is_shown():
    shown = set(re.findall(r"^make ([\w-]+)", "".join(blocks("sh")), re.M))
    assert shown and shown <= set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.M))


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
