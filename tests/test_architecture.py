"""Tests of the architecture: allowed imports, lazy imports, lengths of files and functions.

Read next: `tests/floors.py`, the import layers in order.
"""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from regista.experiments.__main__ import COMMANDS
from tests.floors import FLOORS, ROOT, imported, modules, ringed, tree, upward

OURS = ("kernels", "scenic_lite", "ued", "envs", "minigames", "experiments", "regista")
STANDARD = set(sys.stdlib_module_names)

# Allowed imports of each package, folder or file beyond the standard library; the longest matching name applies.
MAY_IMPORT = {
    "kernels": {"kernels", "numpy", "numba", "llvmlite"},
    "scenic_lite": {"scenic_lite", "kernels", "numpy", "numba", "shapely"},
    "ued": {"ued", "numpy", "gymnasium", "torch"},
    "ued/core": {"ued.config", "ued.core", "numpy", "gymnasium", "torch"},
    "ued/core/columns.py": {"ued.core", "numpy", "pyarrow"},
    "ued/core/upomdp.py": {"ued.core", "numpy", "gymnasium"},
    "ued/adapters": {"ued", "numpy", "gymnasium", "torch", "stable_baselines3", "torchrl", "tensordict"},
    "ued/recorder": {"ued", "numpy", "rerun"},
    "envs": {"envs", "kernels", "scenic_lite", "ued.core", "numpy", "numba", "gymnasium"},
    "envs/football/view": {
        "envs",
        "kernels",
        "scenic_lite",
        "ued.core",
        "numpy",
        "matplotlib",
        "PIL",
        "imageio_ffmpeg",
    },
    "envs/scenic3": {"envs.scenic3", "ued.core", "numpy", "gymnasium", "scenic", "greenlet"},
    "minigames": {"minigames", "scenic_lite", "envs", "ued.core", "gymnasium"},
    "regista": {"regista", "minigames", "experiments", "ued"},  # files in the folder itself, not in linked folders
}
EXCEPTIONS = {
    "kernels/__init__.py": {"regista.bare_names"},  # linked folders: each can be imported under two names
    "envs/__init__.py": {"regista.bare_names"},
    "minigames/__init__.py": {"minigames", "regista.bare_names"},
    "envs/grf/worker.py": {"numpy", "gfootball", "gfootball_engine"},  # runs in an environment without Regista
    "envs/football/parallel_env.py": {
        "envs",
        "scenic_lite",
        "ued.core",
        "numpy",
        "gymnasium",
        "pettingzoo",
    },  # the interface of an optional extra
}

# Known violations. Remove an entry together with its cause: the tests also fail for entries that no longer apply.
KNOWN_UPWARD: set[str] = set()
KNOWN_RINGED: set[str] = set()
KNOWN_LOST_POINTERS: set[str] = set()
KNOWN_LONG_FILES: set[str] = set()

# Functions that may be longer than forty lines.
LONG_FUNCTIONS = {
    "scenic_lite/dynamics/machine/vm.py: run_thread",  # the machine's dispatch, flat for the branch predictor
}


def sources(package):
    return sorted((ROOT / package).rglob("*.py"))


def pointers(path: Path) -> list[str]:
    """Return the modules and files that a file's docstring names after "Read next:"."""
    text = ast.get_docstring(tree(path)) or ""
    marked = re.findall(r"`(\w[\w./]+)`", text.partition("Read next:")[2])
    return [name for at, name in enumerate(marked) if at == 0 or "." in name]


def leads_somewhere(pointer: str, path: Path) -> bool:
    """Return whether a pointer names a module or a file, in full or relative to a package that contains `path`."""
    inside = pointer if "/" in pointer else pointer.replace(".", "/")
    packages = [ROOT, *(folder for folder in path.parents if folder.is_relative_to(ROOT))]
    places = [folder / inside for folder in packages]
    return any(place.exists() or place.with_suffix(".py").exists() for place in places)


def long_functions(path: Path, most: int) -> Iterator[str]:
    """Yield the functions of a file that have more lines than `most`."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.end_lineno - node.lineno >= most:
            yield node.name


def within(module, allowed):
    return any(module == name or module.startswith(name + ".") for name in allowed)


def allowed_in(name: str) -> set[str]:
    """Return the allowed imports of a file: its exception, or the entry with the longest prefix of its name."""
    prefixes = [place for place in MAY_IMPORT if name == place or name.startswith(place + "/")]
    return EXCEPTIONS.get(name, MAY_IMPORT[max(prefixes, key=len)])


@pytest.mark.slow
@pytest.mark.parametrize("package", [place for place in MAY_IMPORT if "/" not in place])
def test_packages_import_only_what_the_design_allows(package):
    for path in sources(package):
        allowed = allowed_in(path.relative_to(ROOT).as_posix())
        for name in imported(path):
            assert name.split(".")[0] in STANDARD or within(name, allowed), f"{path} imports {name}"


@pytest.mark.slow
def test_what_is_installed_needs_no_lab_and_no_tests():
    for package in OURS:
        for path in sources(package):
            assert not [name for name in imported(path) if within(name, {"lab", "tests"})], path


@pytest.mark.slow
def test_tests_need_no_lab():
    for path in sources("tests"):
        assert not [name for name in imported(path) if within(name, {"lab"})], path


@pytest.mark.slow
def test_only_recordings_import_rerun():
    users = [p.name for package in OURS for p in sources(package) if any(within(m, {"rerun"}) for m in imported(p))]
    assert users == [
        "buffer_log.py",
        "film_log.py",
        "layout.py",
        "recorder.py",
        "rows.py",
        "scene_log.py",
        "theta_log.py",
        "writer.py",
        "runs_recording.py",
        "scene_recording.py",
        "side_by_side.py",
    ]


# Packages that an import must not load. One process imports all modules in this order, so imports accumulate.
# `tests/ued/test_package.py` has the rule for all names of `ued`.
LIGHT = {
    "ued.core.upomdp": {"torch"},
    "ued": {"torch"},
    "regista.minigames": {"numba", "torch"},
    "scenic_lite": {"numba", "torch"},
    "regista.envs.football.scenic.domain": {"numba", "torch"},
    "regista.kernels": {"numba"},
    "regista.experiments.__main__": {"torch", "numba", "matplotlib"},
}


def loaded(code):
    """Run a program in a new process and return its output, the heavy packages that it has loaded."""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_importing_a_package_stays_light():
    code = f"""
import importlib, sys
for name, heavy in {LIGHT!r}.items():
    importlib.import_module(name)
    if found := heavy & sys.modules.keys():
        print(name, "loads", *sorted(found))"""
    assert loaded(code) == ""


@pytest.mark.slow
def test_help_waits_for_nothing_heavy():
    code = f"""
import contextlib, io, sys
from regista.experiments.__main__ import main
for command in {list(COMMANDS)!r}:
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.suppress(SystemExit):
        main([command, "--help"])
    if not shown.getvalue().startswith(f"usage: regista {{command}}"):
        print(command, "shows", shown.getvalue())
    if found := {{"matplotlib", "numba", "rerun", "torch"}} & sys.modules.keys():
        print(command, "--help loads", *sorted(found))"""
    assert loaded(code) == ""


@pytest.mark.slow
def test_no_import_runs_up():
    assert {arrow for package in FLOORS for arrow in upward(package)} == KNOWN_UPWARD


@pytest.mark.slow
def test_no_imports_run_in_a_ring():
    assert {module for package in FLOORS for module in ringed(package)} == KNOWN_RINGED


@pytest.mark.parametrize("package", FLOORS)
def test_every_room_is_there(package):
    folder = ROOT / package.replace(".", "/")
    for room in FLOORS[package]:
        place = folder / room.replace(".", "/")
        assert place.is_dir() or place.with_suffix(".py").is_file(), f"no {room} in {package}"


def test_every_file_sends_its_reader_to_one_that_exists():
    lost = {
        f"{path.relative_to(ROOT)}: {pointer}"
        for package in OURS
        for path in sources(package)
        for pointer in pointers(path)
        if not leads_somewhere(pointer, path)
    }
    assert lost == KNOWN_LOST_POINTERS


def test_files_are_short():
    every = [path for folder in (*OURS, "tests", "lab", "examples") for path in sources(folder)]
    long = {str(path.relative_to(ROOT)) for path in every if len(path.read_text().splitlines()) > 450}
    assert long == KNOWN_LONG_FILES


@pytest.mark.slow
def test_functions_are_short():
    every = [path for package in OURS for path in sources(package)]
    assert {
        f"{path.relative_to(ROOT)}: {name}" for path in every for name in long_functions(path, 40)
    } == LONG_FUNCTIONS


def test_the_language_stays_compact():
    files = list(modules("scenic_lite").values())
    lines = sum(len(path.read_text().splitlines()) for path in files)
    assert lines <= 18_700 and len(files) <= 95, f"{lines} lines in {len(files)} files"


def test_there_is_exactly_one_parallel_loop():
    loops = [p.name for package in OURS for p in sources(package) if "in prange(" in p.read_text()]
    assert loops == ["batch.py"]


def test_a_program_is_data():
    """The language package never evaluates text as Python and never accesses attributes by name."""
    forbidden = {"eval", "exec", "compile", "__import__", "getattr", "setattr"}
    for path in sources("scenic_lite"):
        for node in ast.walk(tree(path)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in forbidden, f"{path}:{node.lineno} calls {node.func.id}"
