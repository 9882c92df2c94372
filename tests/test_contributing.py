"""What CONTRIBUTING.md shows is done here as it says: files are made, rows are added, commands run, tests pass."""

import ast
import os
import re
import shlex
import shutil
import subprocess
import sys
from itertools import groupby
from operator import itemgetter
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


REGISTA = """
import sys
from experiments.__main__ import main

for words in {lines}:
    try:
        code = main(words)
    except SystemExit as end:  # of --help
        code = end.code
    if code:
        sys.exit(code)
"""


def run(lines, folder):
    """Run a block of commands; those of regista, in a row, in one process."""
    for program, group in groupby(map(shlex.split, lines), itemgetter(0)):
        words = [line[1:] for line in group]
        if program == "regista":
            commands = [["-c", REGISTA.format(lines=words)]]
        else:
            commands = [["-m", "pytest", "-p", "no:cacheprovider"] * (program == "pytest") + line for line in words]
        for command in commands:
            environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)]), "OMP_NUM_THREADS": "1"}
            options = {"cwd": folder, "env": environment, "capture_output": True, "text": True, "timeout": 600}
            done = subprocess.run([sys.executable, *command], **options)
            assert done.returncode == 0, f"{words}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"


def carry_out(page, folder):
    """Do what a page says, in its order; return how many of its blocks there were."""
    steps = STEP.findall(page)
    for where, language, block in steps:
        names = re.findall(r"`([^`]+)`", where)
        if language == "sh":
            run(block.splitlines(), folder)
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
