"""The page of football lists what its library has, no more and no less, and says the signatures as they are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from regista.envs.football.scenic.domain import FOOTBALL, MODULES
from scenic_lite import load
from tests.floors import FLOORS

PAGE = (Path(__file__).parents[2] / "envs" / "football" / "README.md").read_text()
NAME = r"^(class|behavior|def) (\w+)(\(.*\))?:$|^(\w+) = "
SECTION = r"^### [^\n]* \(([\w, ]+)\)\n(.*?)(?=^##|\Z)"


def library(module: str) -> dict[str, str]:
    """Return every name at the top of a file of the library, with its signature if it is called."""
    text = MODULES[module].read_text()
    names = {}
    for kind, named, signature, assigned in re.findall(NAME, text, re.MULTILINE):
        names[named or assigned] = "" if kind == "class" else signature
    return names


def listed() -> dict[str, str]:
    """Return every name in the sections of the page, with what stands in brackets behind it."""
    names = {}
    for _, body in re.findall(SECTION, PAGE, re.MULTILINE | re.DOTALL):
        body = body.split("What can be read of them")[0]
        names |= dict(re.findall(r"`(\w+)`(\([^)]*\))?", body))
    return names


def test_the_page_lists_the_library() -> None:
    real = {name: signature for module in MODULES for name, signature in library(module).items()}
    told = listed()
    assert told.keys() == real.keys()
    assert {name: told[name] for name in real if real[name]} == {name: real[name] for name in real if real[name]}


def test_every_name_is_in_the_section_of_its_module() -> None:
    for modules, body in re.findall(SECTION, PAGE, re.MULTILINE | re.DOTALL):
        known = set().union(*(library(module) for module in modules.split(", ")))
        mentioned = set(re.findall(r"`(\w+)`", body.split("What can be read of them")[0]))
        assert mentioned <= known, modules


def test_a_program_that_names_no_part_of_the_library_has_all_of_it() -> None:
    program = load(
        "ego = LeftCF with behavior dribbleToAndShoot(right_goal_midpoint)\nball = Ball ahead of ego by 2\n", FOOTBALL
    )
    assert program.objects[0].behavior == "dribbleToAndShoot"


@pytest.mark.parametrize("module", MODULES)
def test_the_page_names_every_module_and_its_alias(module: str) -> None:
    assert f"| `football.{module}` | `scenic.simulators.gfootball.{module}`" in PAGE


def test_the_page_shows_the_modules_in_their_order() -> None:
    table = PAGE[PAGE.index("| module | content |") : PAGE.index("A file imports")]
    cells = [row.split("|")[1] for row in table.splitlines() if row]
    assert re.findall(r"`(\w+)/?`", "".join(cells)) == [
        floor.removeprefix("football.") for floor in FLOORS["envs"] if floor.startswith("football.")
    ]
