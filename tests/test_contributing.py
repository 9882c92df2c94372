"""Follows the how-to pages for extensions: creates their files, adds their rows, runs their commands and tests.

Read next: `pages`, which reads the pages.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from itertools import groupby
from operator import itemgetter

import pytest

from tests.pages import ROOT, add_row, blocks, write

PAGES = ("minigame", "simulator", "method")
COPIED = (
    "kernels",
    "envs",
    "examples",
    "experiments",
    "minigames",
    "regista",
    "scenic_lite",
    "tests",
    "ued",
    "pyproject.toml",
)


@pytest.fixture
def checkout(tmp_path):
    """Return a copy of the checkout with its symbolic links; the copy shares the compiled kernels."""
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, tmp_path / name, symlinks=True)
        else:
            shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


REGISTA = """
import sys
from regista.experiments.__main__ import main

for words in {lines}:
    try:
        code = main(words)
    except SystemExit as end:  # of --help
        code = end.code
    if code:
        sys.exit(code)
"""


def run(lines, folder):
    """Run a block of commands; consecutive `regista` commands share one process."""
    for program, group in groupby(map(shlex.split, lines), itemgetter(0)):
        words = [line[1:] for line in group]
        if program == "regista":
            commands = [["-c", REGISTA.format(lines=words)]]
        else:
            commands = [["-m", "pytest", "-p", "no:cacheprovider"] * (program == "pytest") + line for line in words]
        for command in commands:
            environment = os.environ | {"PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"}
            options = {"cwd": folder, "env": environment, "capture_output": True, "text": True, "timeout": 600}
            done = subprocess.run([sys.executable, *command], **options)
            assert done.returncode == 0, f"{words}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"


def carry_out(page, folder):
    """Follow the blocks of a page in order, with shorter training; return the number of blocks."""
    steps = blocks(re.sub(r"(env_steps < |--total-env-steps )[\d_]+", r"\g<1>2_000", page))
    for step in steps:
        if step.language == "sh":
            run(step.text.splitlines(), folder)
        elif "at the end of `" in step.where:
            add_row(folder / step.names[0], step.names[1], step.text)
        elif "at the end of the file" in step.where:
            path = folder / step.names[0]
            path.write_text(path.read_text() + "\n\n" + step.text)
        else:
            write(folder / step.names[0], step.text)
    return len(steps)


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
@pytest.mark.long
def test_a_page_can_be_followed(name, checkout):
    assert carry_out((ROOT / "docs" / "howto" / f"{name}.md").read_text(), checkout) >= 4
    style = [sys.executable, "-m", "ruff"]
    for check in (["format", "--check"], ["check"]):
        done = subprocess.run([*style, *check, "."], cwd=checkout, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout
