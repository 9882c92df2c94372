"""Agreement with real Scenic on small programs: the same constants, distributions and places of errors.

`tests/oracle/README.md` says what the programs are and how real Scenic ran them.
"""

import json
from functools import cache
from pathlib import Path

import pytest

from tests.oracle.compare import differences
from tests.oracle.runner import KINDS, header, run_program, world_of

OURS = Path(__file__).parents[1] / "oracle" / "programs"
OPEN = OURS.parent / "open"
EXPECTED = {
    (OURS, 3): OURS / "expected_scenic3.json",
    (OURS, 2): OURS / "expected_scenic2.json",
    (OPEN, 3): OPEN / "expected.json",
    (OPEN, 2): OPEN / "expected_scenic2.json",
}
# What real Scenic gets wrong, or refuses for reasons of its translator, and means something here all the same.
BETTER = {
    3: {
        "dist_functions": "Scenic 3.1.1 gives x for x // 1 where x is random",
        "err_missing_new": "the form of Scenic 2 is understood in both dialects",
    },
    2: {
        "broken_bracket": "the bracket that is never closed says more than the end of the file",
        "class_methods_and_lists": "a comprehension in a call needs no brackets of its own",
        "contained_in": "`contained in` is understood in both dialects",
        "discrete_range_random_ends": "the ends of a DiscreteRange are fixed numbers in Scenic 2",
        "dist_functions": "so is //",
        "facing_forms": "a random position cannot be faced from in Scenic 2",
        "loop_objects": "Scenic 2 takes the `for` of a comprehension into the specifier before it",
        "require_names": "a requirement means the names as they are where it stands, not at the end of the file",
        "require_function": "an internal error of Scenic 2",
        "str_of_random": "int() of a random value is refused by Scenic 2",
    },
}
# What our programs of Python's forms that the language leaves out are refused with: the line and the first words.
LEFT_OUT = {
    "dictionaries_and_sets": (9, "sets are not supported"),
    "except_around_interrupts": (11, "`except` is not supported"),
    "exceptions_and_asserts": (8, "`except` is not supported"),
    "match_in_behavior": (5, "`match` is not supported"),
    "py_class_methods2": (15, "there is no super() here"),
    "function_with_global": (6, "`global` is not supported"),
    "globals_and_params": (8, "`global` is not supported"),
    "py_ego_global_function": (5, "`global` is not supported"),
    "functions_of_all_kinds": (6, "a parameter behind `*` is not supported"),
    "py_dict_methods": (10, "`**` before a value or parameter is not supported"),
    "py_star_args": (5, "a parameter behind `*` is not supported"),
    "py_decorator": (9, "decorators are not supported"),
    "py_list_methods": (6, "there is no insert() here"),
    "py_float_format": (6, "the {} of an f-string holds a value and a plain format"),
    "py_generator_function": (8, "`yield` is not supported"),
    "py_nested_try": (12, "`except` is not supported"),
    "py_percent_format": (5, "`%` formats no text"),
    "py_text_methods": (6, "texts have no method 'lower' here"),
    "py_static_class_method": (6, "decorators are not supported"),
    "py_try_else": (8, "`except` is not supported"),
    "py_try_loop_finally": (10, "`finally` is not supported"),
    "py_try_order": (14, "`raise` is not supported"),
    "py_try_reraise": (8, "`raise` is not supported"),
    "words": (7, "texts have no method 'join' here"),
}


LONG = {"area_rand_inter", "helpers_in_requires", "draws_in_behaviors", "requirement_with_helpers"}  # to evaluate


@cache
def expected_records(path):
    return json.loads(path.read_text())


@cache
def world(folder):
    return world_of(folder)


def cases():
    for (folder, dialect), path in EXPECTED.items():
        for name, record in sorted(expected_records(path).items()):
            if record["kind"] in KINDS:
                many = folder == OPEN or dialect == 2 or name in LONG
                marks = [pytest.mark.slow] * many
                yield pytest.param(folder, dialect, name, id=f"{folder.name}-{name}-{dialect}", marks=marks)


@pytest.mark.slow
@pytest.mark.sample(200)
@pytest.mark.parametrize(("folder", "dialect", "name"), list(cases()))
def test_program_agrees_with_real_scenic(folder, dialect, name):
    path = folder / f"{name}.scenic"
    record = run_program(path, dialect, world(folder))
    if record is None:
        pytest.skip("it fails only when it is simulated")
    if name in LEFT_OUT and folder == OURS:
        line, words = LEFT_OUT[name]
        error = record["error"]
        assert error["line"] == line and error["message"].startswith(words)
        assert error["type"] in ("InvalidScenarioError", "RandomControlFlowError")
        return
    said = differences(expected_records(EXPECTED[folder, dialect])[name], record)
    if name in BETTER[dialect]:
        assert said and record.get("error", {}).get("stage") not in ("crash", "time")
    else:
        assert not said, "\n".join(said)


def test_every_program_of_ours_is_expected():
    named = {path.stem for path in OURS.glob("*.scenic") if "id" in header(path)}
    assert named == set(expected_records(EXPECTED[OURS, 3]))
    assert all(header(OURS / f"{name}.scenic")["id"] == name for name in named)
