"""Tests of wheels: all files of Regista and no others, modules that can be imported, no undefined names."""

import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from regista.envs.football.version import SIMULATOR_VERSION
from regista.kernels import jit
from tests.wheels import LINKS, ROOT, build_sdist, build_wheel, clone, install, pip, run

pytestmark = pytest.mark.slow

FOLDERS = {f"regista/{name}": name for name in ("kernels", "envs", "minigames", "experiments")}
DATA = {".scenic", ".csv", ".pyi", ".typed", ".html", ".json", ".pt"}  # suffixes of data files that the package reads


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return clone(tmp_path_factory.mktemp("clone") / "regista")


@pytest.fixture(scope="module")
def wheel(source, tmp_path_factory):
    return build_wheel(source, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def unpacked(wheel, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    zipfile.ZipFile(wheel).extractall(folder)
    return folder


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    return install(wheel, tmp_path_factory.mktemp("environment"))


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as file:
        return {name: file.read(name) for name in file.namelist()}


@pytest.mark.long
def test_a_wheel_has_the_files_of_the_checkout_as_they_are(unpacked):
    for package in ("scenic_lite", "ued", *FOLDERS):
        folder = ROOT / FOLDERS.get(package, package)
        there = {path.relative_to(unpacked / package) for path in (unpacked / package).rglob("*") if path.is_file()}
        ours = {path.relative_to(folder) for path in folder.rglob("*") if path.suffix in DATA | {".py"}}
        assert there == ours
        assert all((unpacked / package / path).read_bytes() == (folder / path).read_bytes() for path in ours)


def test_a_wheel_has_nothing_at_the_top_but_what_others_import(unpacked):
    """No `envs` and no `tests`, which would clash: nearly every project has folders with these names."""
    names = {path.name for path in unpacked.iterdir() if not path.name.endswith(".dist-info")}
    assert names == {"regista", "scenic_lite", "ued"}


def test_a_wheel_has_nothing_of_the_lab_and_no_tests(wheel):
    parts = {part for name in contents(wheel) for part in Path(name).parts}
    assert not parts & {"lab", "tests", "torture", "studies", "benchmarks"}


@pytest.mark.parametrize("name", ["ued", "scenic_lite"])
@pytest.mark.parametrize("file", ["{}.py", "{}/__init__.py"])
def test_another_package_of_the_same_name_is_refused(unpacked, tmp_path, name, file):
    """The error names both paths in one sentence, and occurs before torch is imported."""
    other = tmp_path / file.format(name)
    other.parent.mkdir(exist_ok=True)
    other.touch()
    code = "import sys\ntry: import regista\nexcept ImportError as error: print(error, 'torch' in sys.modules)"
    done = run([sys.executable, "-c", code], tmp_path, PYTHONPATH=f"{tmp_path}:{unpacked}")
    assert done.stdout == (
        f"Regista needs its own package '{name}', at {unpacked / name}, but Python finds {other} first. "
        f"Rename that file, or put its folder later on sys.path. False\n"
    ), done.stderr


def test_type_checkers_read_what_is_installed(unpacked):
    """PEP 561: without the marker `py.typed`, mypy and editors treat a package as `Any`."""
    assert all((unpacked / package / "py.typed").is_file() for package in ("regista", "scenic_lite", "ued"))
    assert (unpacked / "ued" / "__init__.pyi").is_file()


@pytest.mark.long
def test_an_sdist_makes_the_same_wheel_and_has_no_tests(source, wheel, tmp_path):
    with tarfile.open(build_sdist(source, tmp_path / "sdist")) as file:
        assert not [name for name in file.getnames() if "/tests/" in name or "/lab/" in name]
        file.extractall(tmp_path / "elsewhere", filter="data")
    (tree,) = (tmp_path / "elsewhere").iterdir()
    assert contents(build_wheel(tree, tmp_path / "again")) == contents(wheel)


@pytest.mark.sample(1)
@pytest.mark.parametrize("words", [("wheel", "--wheel-dir", "out"), ("install", "--target", "out", "--editable")])
def test_a_tree_without_its_links_is_refused(tmp_path, words):
    tree = clone(tmp_path / "tree", links=False)
    done = pip(*words, tree, "--no-build-isolation", folder=tmp_path)
    assert done.returncode != 0
    assert f"Regista cannot be built from {tree}: {', '.join(LINKS)} must be symbolic links to ../kernels" in (
        done.stdout + done.stderr
    )
    assert not [*tmp_path.glob("out/*")]


def test_no_name_in_a_wheel_is_undefined(unpacked):
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--no-cache", "--select", "F821,F822,F823,E9"]
    done = subprocess.run([*command, unpacked], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


IMPORTS = """
import importlib, sys

OURS = {"regista", "kernels", "scenic_lite", "ued", "envs", "minigames", "experiments", ""}
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except ImportError as error:
        cause = error.__cause__ or error  # of a message that says which extra to install
        if (getattr(cause, "name", None) or "").partition(".")[0] in OURS:
            print(name, repr(error))
print("envs" in sys.modules, importlib.import_module("regista").__file__)
"""


@pytest.mark.long
def test_every_module_of_a_wheel_can_be_imported(unpacked, python, tmp_path):
    """An import may fail only if a package of another project is not installed."""
    files = [path.relative_to(unpacked) for path in unpacked.rglob("*.py")]
    names = sorted(".".join(path.with_suffix("").parts).removesuffix(".__init__") for path in files)
    done = run([python, "-c", IMPORTS, *names], tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n") == 1, done.stdout
    clash, file = done.stdout.split()
    assert clash == "False" and Path(file).is_relative_to(python.parents[1])


SOURCES = """
from regista.kernels import jit
from regista.envs.football.version import SIMULATOR_VERSION

print(jit.digest(), SIMULATOR_VERSION, *(path.relative_to(jit.ROOT) for path in jit.sources()))
"""


def test_an_installed_wheel_has_the_digests_of_the_checkout(python, tmp_path):
    """So the wheel shares the compiled kernels of the checkout, and its results have the same simulator version."""
    kernels, version, *sources = run([python, "-c", SOURCES], tmp_path).stdout.split()
    assert "regista/envs/football/constants.py" in sources
    assert sources == [path.relative_to(jit.ROOT).as_posix() for path in jit.sources()]
    assert (kernels, version) == (jit.digest(), str(SIMULATOR_VERSION))


def test_the_core_needs_three_packages():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert [line.partition(">")[0] for line in project["dependencies"]] == ["gymnasium", "numpy", "torch"]
