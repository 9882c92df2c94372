"""The rules of the house: who may import whom, what loads lazily, how long a file may be."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.__main__ import COMMANDS

ROOT = Path(__file__).parent.parent
OURS = ("scenic_lite", "ued", "envs", "minigames", "experiments")
STANDARD = set(sys.stdlib_module_names)

# What each package may import beyond the standard library; `ued.upomdp` stands for the seam alone.
MAY_IMPORT = {
    "scenic_lite": {"scenic_lite", "numpy", "numba", "shapely"},
    "ued": {"ued", "numpy", "gymnasium", "torch"},
    "envs": {"envs", "scenic_lite", "ued.upomdp", "numpy", "numba", "gymnasium", "matplotlib", "PIL", "imageio_ffmpeg"},
    "minigames": {"minigames", "scenic_lite", "envs", "gymnasium"},
}
EXCEPTIONS = {
    "ued/upomdp.py": {"numpy", "gymnasium"},
    "ued/gym_upomdp.py": {"numpy", "gymnasium", "ued.upomdp"},
    "ued/methods/alp_gmm.py": {"ued", "numpy", "sklearn", "threadpoolctl"},
    "ued/recorder/recorder.py": {"ued", "numpy", "rerun"},
    "ued/recorder/layout.py": {"ued", "numpy", "rerun"},
    "ued/recorder/scenes.py": {"ued", "numpy", "rerun"},
}


def sources(package):
    return sorted((ROOT / package).rglob("*.py"))


def imported(path):
    """Every module that a file imports, wherever in the file."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} has a relative import; write the package's name"
            yield node.module


def within(module, allowed):
    return any(module == name or module.startswith(name + ".") for name in allowed)


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_packages_import_only_what_the_design_allows(package):
    for path in sources(package):
        allowed = EXCEPTIONS.get(path.relative_to(ROOT).as_posix(), MAY_IMPORT[package])
        for module in imported(path):
            assert module.split(".")[0] in STANDARD or within(module, allowed), f"{path} imports {module}"


def test_only_the_recorder_imports_rerun():
    users = [p.name for package in OURS for p in sources(package) if any(within(m, {"rerun"}) for m in imported(p))]
    assert users == ["layout.py", "recorder.py", "scenes.py"]


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        ("ued", "torch"),
        ("ued.upomdp", "torch"),
        ("scenic_lite", "numba"),
        ("minigames", "numba"),
        ("experiments.__main__", "torch"),
        ("experiments.__main__", "numba"),
        ("experiments.__main__", "matplotlib"),
    ],
)
def test_importing_a_package_stays_light(module, heavy):
    code = f"import sys, {module}; sys.exit({heavy!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0, f"import {module} loads {heavy}"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_waits_for_nothing_heavy(command):
    code = f"""
import sys
from experiments.__main__ import main
try:
    main([{command!r}, "--help"])
except SystemExit:
    pass
sys.exit(", ".join({{"gymnasium", "matplotlib", "numba", "rerun", "torch"}} & sys.modules.keys()) or 0)"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, f"regista {command} --help loads {done.stderr}"
    assert done.stdout.startswith(f"usage: regista {command}")


@pytest.mark.parametrize("package", OURS)
def test_no_file_is_longer_than_five_hundred_lines(package):
    for path in sources(package):
        assert len(path.read_text().splitlines()) <= 500, path


def test_there_is_exactly_one_parallel_loop():
    loops = [p.name for package in OURS for p in sources(package) if "in prange(" in p.read_text()]
    assert loops == ["batch.py"]


def test_a_program_is_data():
    """Nothing in the language package evaluates text or touches Python objects by name."""
    forbidden = {"eval", "exec", "compile", "__import__", "getattr", "setattr"}
    for path in sources("scenic_lite"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in forbidden, f"{path}:{node.lineno} calls {node.func.id}"
