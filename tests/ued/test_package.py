"""What `from ued import ...` offers, and what it costs."""

import re
import resource
import subprocess
import sys
from pathlib import Path

import pytest

import ued
from ued.methods import METHODS

HEAVY = ("numba", "matplotlib", "rerun", "shapely")


def test_every_name_is_there():
    for name in ued.__all__:
        assert name == "METHODS" or getattr(ued, name).__name__ == name
    assert dir(ued) == ued.__all__


def test_every_method_and_its_settings_are_there():
    for row in METHODS.values():
        assert getattr(ued, row.class_name) is row.load()
        assert type(row.settings()).__name__ in ued.__all__


def test_editors_are_told_of_names_that_are_there():
    """Of all but new methods, which need no line there."""
    stub = re.findall(r" as (\w+)$", (Path(ued.__file__).parent / "__init__.pyi").read_text(), re.M)
    assert set(stub) <= set(ued.__all__)
    assert {name for names in ued._EXPORTS.values() for name in names} | {"Paired", "PairedConfig"} <= set(stub)


def test_a_name_that_is_not_there():
    with pytest.raises(AttributeError, match="module 'ued' has no attribute 'PLR2'"):
        _ = ued.PLR2


@pytest.mark.slow
def test_nothing_heavy_comes_along():
    """With all that is offered: what a single name needs is among it."""
    code = f"import sys\nfrom ued import *\nsys.exit(', '.join(set({HEAVY}) & sys.modules.keys()) or 0)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, f"from ued import * loads {done.stderr}"


def seconds(statement):
    """Return the least processor time of two runs: what else the machine does only adds to it."""
    runs = []
    for _ in range(2):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", statement], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        runs.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(runs)


@pytest.mark.slow
@pytest.mark.long
def test_the_package_is_there_hardly_later_than_torch():
    assert seconds("from ued import Paired") < 1.5 * seconds("import torch")
