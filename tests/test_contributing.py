"""What CONTRIBUTING.md shows is done here as it says: files are made, rows are added, commands run, tests pass."""

import ast
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "CONTRIBUTING.md").read_text()
PAGES = dict(re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", TEXT, re.M | re.S))
STEP = re.compile(r"(?:^(`[^`\n]+`|In `[^\n]+):\n\n)?^```(\w*)\n(.*?)^```", re.M | re.S)
COPIED = ("experiments", "minigames", "tests", "ued", "examples", "pyproject.toml")


@pytest.fixture
def checkout(tmp_path):
    """A copy without the packages that have kernels: those are compiled once, for where they are."""
    for name in COPIED:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, tmp_path / name)
    return tmp_path


def write(path, text):
    assert not path.exists(), f"{path} exists already"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def add_row(path, table, row):
    """Add the text of a row after the last one of a table: a tuple, alone or in a dict made of it."""
    text = path.read_text()
    for node in ast.parse(text).body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == table for target in targets):
            rows = next(part for part in ast.walk(node.value) if isinstance(part, ast.Tuple))
            lines = text.splitlines(keepends=True)
            lines.insert(rows.elts[-1].end_lineno, row)
            path.write_text("".join(lines))
            return
    raise AssertionError(f"{path} has no {table}")


def run(line, folder):
    program, *words = shlex.split(line)
    module = {"regista": ["-m", "experiments"], "pytest": ["-m", "pytest", "-p", "no:cacheprovider"], "python": []}
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)]), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, *module[program], *words]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, f"{line}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"


def carry_out(page, folder):
    """Do what a page says, in its order; return how many of its blocks there were."""
    steps = STEP.findall(page)
    for where, language, block in steps:
        names = re.findall(r"`([^`]+)`", where)
        if language == "sh":
            for line in block.splitlines():
                run(line, folder)
        elif "at the end of `" in where:
            add_row(folder / names[0], names[1], block)
        elif "at the end of the file" in where:
            path = folder / names[0]
            path.write_text(path.read_text() + "\n\n" + block)
        else:
            write(folder / names[0], block)
    return len(steps)


@pytest.mark.slow
@pytest.mark.parametrize("title", PAGES)
def test_a_page_can_be_followed(title, checkout):
    assert carry_out(PAGES[title], checkout) >= 4
    style = [sys.executable, "-m", "ruff"]
    for check in (["format", "--check"], ["check"]):
        done = subprocess.run([*style, *check, "."], cwd=checkout, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout


def test_links_lead_somewhere():
    targets = [target for target in re.findall(r"\]\(([^)#]+)\)", TEXT) if "://" not in target]
    assert targets and [target for target in targets if not (ROOT / target).exists()] == []
