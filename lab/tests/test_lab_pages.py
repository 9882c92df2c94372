"""Commands of the lab on pages exist and have the flags shown; every script has its line in the README."""

import io
import re
import shlex
from contextlib import redirect_stdout, suppress
from functools import cache

import pytest

from lab.benchmarks.__main__ import main as benchmarks
from lab.studies.__main__ import main as studies
from tests.floors import ROOT

LAB = ROOT / "lab"
PAGES = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), LAB / "README.md", LAB / "grf" / "data" / "README.md"]
QUOTED = sorted(
    {
        command.partition("  #")[0].strip()
        for page in PAGES
        if page.name != "CHANGELOG.md"
        for command in re.findall(r"python -m lab\.(?:(?! -->)[^`\n])+", page.read_text())
    }
)


@cache
def flags(module, study=""):
    """Return the flags in the help of a module."""
    shown, main = io.StringIO(), {"lab.studies": studies, "lab.benchmarks": benchmarks}[module]
    with redirect_stdout(shown), suppress(SystemExit):
        main([*study.split(), "--help", "all"] if study else ["--help"])
    return set(re.findall(r"(?<![\w-])--[a-z][\w.-]*", shown.getvalue()))


@pytest.mark.slow
@pytest.mark.parametrize("command", QUOTED)
def test_commands_of_pages_can_be_run(command):
    _, _, module, *words = shlex.split(command)
    if module.isupper() or "NAME" in module:
        return
    place = ROOT / module.replace(".", "/")
    assert place.with_suffix(".py").is_file() or (place / "__main__.py").is_file()
    if module in ("lab.studies", "lab.benchmarks"):
        study = words[0] if module == "lab.studies" and words else ""
        typed = {word for word in words if word.startswith("--")}
        assert not typed - flags(module, study), command


def test_every_script_has_a_line():
    page = (LAB / "README.md").read_text()
    scripts = {path.name for path in LAB.glob("*.py")} | {f"{path.parent.name}/" for path in LAB.glob("*/__main__.py")}
    assert scripts <= set(re.findall(r"^\| \[`([^`]+)`\]", page, re.M))
    for name in re.findall(r"^\| \[`([^`]+)`\]", page, re.M):
        assert (LAB / name).exists()
