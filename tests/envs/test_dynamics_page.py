"""The page of the dynamics names modules that exist, leaves none out that holds laws, and has their numbers."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

FOOTBALL = Path(__file__).parents[2] / "envs" / "football"
PAGE = (FOOTBALL / "DYNAMICS.md").read_text()
ROW = re.compile(r"^\| (?P<law>[^|\n]+) \| (?P<modules>`[^|\n]+`) \| (?P<agreement>[^|\n]+) \|$", re.MULTILINE)
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?")
ROOMS = ("physics", "skills", "ai", "rules", "control")
NO_LAWS = {"physics/vectors.py", "physics/pitch.py", "skills/touch.py"}


def laws() -> list[tuple[str, tuple[str, ...]]]:
    """Return every law of the page, and the modules in which it says that it is."""
    return [(row["law"], tuple(re.findall(r"`([^`]+)`", row["modules"]))) for row in ROW.finditer(PAGE)]


@cache
def constants(module: str) -> set[float]:
    """Return the numbers that stand in the code of a module."""
    nodes = ast.walk(ast.parse((FOOTBALL / module).read_text()))
    return {
        float(node.value) for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, int | float)
    }


def test_the_page_has_a_row_for_every_module_of_laws() -> None:
    named = {module for _, modules in laws() for module in modules}
    there = {f"{room}/{path.name}" for room in ROOMS for path in (FOOTBALL / room).glob("[!_]*.py")}
    assert there - named == NO_LAWS
    assert {name for name in named if not (FOOTBALL / name).is_file()} == set()


@pytest.mark.parametrize(("law", "modules"), laws(), ids=[law[:40] for law, _ in laws()])
def test_the_numbers_of_a_law_stand_in_its_modules(law: str, modules: tuple[str, ...]) -> None:
    known = set.union(*(constants(module) for module in modules))
    assert [number for number in NUMBER.findall(law) if float(number) not in known] == []
