"""The oracle's programs: read where real Scenic reads them, refused where it refuses them."""

import json
from pathlib import Path

import pytest

from scenic_lite.errors import ScenicError
from scenic_lite.syntax.check import check
from scenic_lite.syntax.parser import parse

ORACLE = Path(__file__).parents[1] / "oracle"
PROGRAMS = [path for folder in ("open", "open/lib", "peer_bugs") for path in sorted((ORACLE / folder).glob("*.scenic"))]
SYNTAX = ("ScenicParseError", "ScenicSyntaxError")


def expected_error(path):
    expected = path.parent / "expected.json"
    return json.loads(expected.read_text()).get(path.stem, {}).get("error", {}) if expected.exists() else {}


@pytest.mark.slow
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: f"{path.parent.name}-{path.stem}")
@pytest.mark.parametrize("dialect", [2, 3])
def test_program(path, dialect):
    text = path.read_text()
    try:
        errors = check(parse(text, path.name, dialect), text, path.name)
    except ScenicError as error:
        errors = [error]
    wanted = expected_error(path)
    if wanted.get("type") in SYNTAX:
        assert errors and errors[0].kind == "syntax"
        assert wanted.get("line") in (None, errors[0].line)
    elif path.stem == "err_behavior_no_take":
        assert [error.line for error in errors] == [wanted["line"]]
    else:
        assert [error for error in errors if error.kind != "warning"] == []
