"""Tests of the kernel decorator: the folder of the cache, its contents, and stale caches."""

from __future__ import annotations

import ast
import fnmatch
import gc
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core import errors
from numba.core.types.functions import BaseFunction

from regista.kernels import jit
from regista.kernels.rng import streams, uniform
from tests.floors import imported, modules, own_name


def cache_folder(tmp_path: Path, **environment: str) -> str:
    """Return the cache folder of a new process; the folder of this process is not changed."""
    return asked(tmp_path, **environment)[0]


def asked(tmp_path: Path, **environment: str) -> tuple[str, str]:
    """Return the cache folder of a new process, and its messages on stderr."""
    command = [sys.executable, "-c", "from regista.kernels import jit; print(jit.CACHE)"]
    inherited = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    inherited |= {"PYTHONPATH": str(jit.ROOT), "TMPDIR": str(tmp_path), **environment}
    done = subprocess.run(command, env=inherited, capture_output=True, text=True, check=True)
    return done.stdout.strip(), done.stderr.strip()


@pytest.mark.slow
def test_the_cache_is_where_the_user_wants_it(tmp_path: Path) -> None:
    assert cache_folder(tmp_path, XDG_CACHE_HOME=str(tmp_path / "xdg")) == str(
        tmp_path / "xdg" / "regista" / jit.digest()
    )
    assert cache_folder(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "numba")) == str(tmp_path / "numba" / jit.digest())


@pytest.mark.slow
def test_an_impossible_cache_folder_is_no_obstacle(tmp_path: Path) -> None:
    blocker = tmp_path / "file"
    blocker.write_text("not a folder")
    found = cache_folder(tmp_path, NUMBA_CACHE_DIR=str(blocker))
    assert found == str(tmp_path / f"regista-{os.getuid()}" / jit.digest())
    assert Path(found).stat().st_mode & 0o777 == 0o700


@pytest.mark.slow
@pytest.mark.parametrize("depth", [0, 1])
def test_a_cache_into_which_others_may_write_is_not_used(tmp_path: Path, depth: int) -> None:
    folder = tmp_path / "numba"
    shared = folder if depth == 0 else folder / jit.digest()
    shared.mkdir(parents=True)
    shared.chmod(0o777)
    fallback = tmp_path / f"regista-{os.getuid()}"
    fallback.mkdir(mode=0o700)
    found, said = asked(tmp_path, NUMBA_CACHE_DIR=str(folder))
    assert found == str(fallback / jit.digest())
    assert said == f"regista: {shared} is not used as a cache of compiled kernels: others may write into it"


@pytest.mark.slow
@pytest.mark.skipif(os.getuid() != 0, reason="only root can give a folder away")
def test_a_cache_of_somebody_else_is_not_used(tmp_path: Path) -> None:
    for folder in (tmp_path / "numba", tmp_path / f"regista-{os.getuid()}"):
        folder.mkdir(mode=0o700)
        os.chown(folder, 12345, 12345)
    found, said = asked(tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "numba"))
    assert said.count("it belongs to another user") == 2
    assert said.endswith(f"regista: compiled kernels are cached in {found} until this program ends")
    assert not Path(found).exists()


@pytest.mark.slow
def test_old_caches_are_removed_and_foreign_files_kept(tmp_path: Path) -> None:
    for i in range(8):
        folder = tmp_path / f"{i:016x}"
        folder.mkdir()
        os.utime(folder, (1000 + i, 1000 + i))
    (tmp_path / "mine").mkdir()
    cache_folder(tmp_path, NUMBA_CACHE_DIR=str(tmp_path))
    left = {path.name for path in tmp_path.iterdir()}
    assert "mine" in left
    assert jit.digest() in left
    assert len(left) == 1 + jit.KEPT_CACHES


@pytest.mark.slow
def test_a_cache_that_a_program_may_use_just_now_stays(tmp_path: Path) -> None:
    for i in range(8):
        (tmp_path / f"{i:016x}").mkdir()
    cache_folder(tmp_path, NUMBA_CACHE_DIR=str(tmp_path))
    assert len(list(tmp_path.iterdir())) == 9


def test_the_digest_follows_every_file_that_a_kernel_can_see(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in jit.PACKAGES:
        (tmp_path / package).mkdir(parents=True)
    envs = tmp_path / "regista" / "envs"
    (envs / "numbers.py").write_text("G = 9.81\n")
    (envs / "ball.py").write_text("from regista.envs.numbers import G\nfrom regista.kernels.jit import kernel\n")
    (envs / "drawing.py").write_text("import math\n")
    (tmp_path / "regista" / "kernels" / "jit.py").write_text("\n")
    monkeypatch.setattr(jit, "ROOT", tmp_path)
    before = jit.digest()
    (envs / "drawing.py").write_text("import math, os\n")
    assert jit.digest() == before
    (envs / "numbers.py").write_text("G = 1.62\n")
    assert jit.digest() != before


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of all sources that may contain kernels, laid out as in a checkout: `regista/envs` is a link."""
    folder = tmp_path_factory.mktemp("copied")
    for inside, package in {"scenic_lite": "scenic_lite", "regista/envs": "envs", "regista/kernels": "kernels"}.items():
        shutil.copytree(jit.ROOT / inside, folder / package, ignore=lambda _, names: fnmatch.filter(names, "__*__"))
    (folder / jit.RECORDS).parent.mkdir(parents=True)
    shutil.copy(jit.ROOT / jit.RECORDS, folder / jit.RECORDS)
    (folder / "regista").mkdir()
    for name in ("envs", "kernels"):
        (folder / "regista" / name).symlink_to(f"../{name}")
    return folder


@pytest.mark.slow
@pytest.mark.sample(14)
@pytest.mark.parametrize(
    ("file", "stale"),
    [
        ("envs/football/constants.py", True),  # at least two imports away from `play`
        ("envs/football/observation/units.py", True),
        ("envs/football/scenic/world_fields.py", True),
        ("scenic_lite/values/formulas.py", True),
        ("scenic_lite/dynamics/machine/opcodes.py", True),
        ("kernels/numba_linking.py", True),
        ("kernels/rollout/lanes.py", True),
        ("ued/core/compiled.py", True),
        ("envs/football/vector_env.py", False),
        ("envs/grf/engine.py", False),
        ("scenic_lite/syntax/parser.py", False),
        ("scenic_lite/core/scope.py", False),
        ("scenic_lite/values/graph.py", False),
        ("scenic_lite/evaluation/expressions.py", False),
        ("scenic_lite/dynamics/compiler/compile.py", False),
        ("scenic_lite/dynamics/machine/compiled.py", False),
    ],
)
def test_an_edit_compiles_anew_only_what_compiled_code_can_see(
    copied: Path, monkeypatch: pytest.MonkeyPatch, file: str, stale: bool
) -> None:
    monkeypatch.setattr(jit, "ROOT", copied)
    before = jit.digest()
    with (copied / file).open("a") as source:
        source.write("EDITED = 1\n")
    assert (jit.digest() != before) == stale


def covered() -> set[str]:
    """Return the modules that the digest covers, by the names of their folders."""
    return {own_name(str(path.relative_to(jit.ROOT).with_suffix("")).replace("/", ".")) for path in jit.sources()}


@pytest.mark.slow
def test_the_digest_misses_no_import() -> None:
    """The digest finds imports by a pattern, for speed; this test uses Python's parser, also inside functions."""
    sources = covered()
    ours = {own_name(name) for package in jit.PACKAGES for name in modules(package.removeprefix("regista/"))}
    assert "envs.football.simulator" in sources & ours
    for path in jit.sources():
        for name in imported(path):
            module = name if name in ours else name.rpartition(".")[0]
            assert module not in ours or {module, f"{module}.__init__"} & sources, f"{path} imports {name}"


@pytest.mark.parametrize("package", ["experiments", "tests"])
def test_kernels_elsewhere_see_only_themselves_and_what_the_digest_covers(package: str) -> None:
    known = covered()
    for path in modules(package).values():
        if "@kernel" not in path.read_text():
            continue
        tree = ast.parse(path.read_text())
        homes = {
            name.asname or name.name: (own_name(f"{node.module}.{name.name}"), own_name(str(node.module)))
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for name in node.names
        }
        for function in ast.walk(tree):
            if isinstance(function, ast.FunctionDef) and any(
                "kernel" in ast.unparse(d) for d in function.decorator_list
            ):
                seen = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)} & homes.keys()
                ours = {
                    name for name in seen if homes[name][1].split(".")[0] in ("envs", "kernels", "scenic_lite", package)
                }
                assert all(known & {*homes[name]} for name in ours), f"{path}: {function.name} uses {ours}"


def test_compiled_tells_whether_a_call_will_be_quick() -> None:
    @jit.kernel
    def fresh(x):
        return x + 1

    if not hasattr(fresh, "signatures"):
        pytest.skip("kernels run uncompiled")
    assert fresh(1) == 2
    assert jit.compiled(fresh)
    assert jit.compiled(len)


@jit.kernel
def twice(x):
    return 2 * x


@jit.kernel
def twice_and_one(x):
    return twice(x) + 1


def test_a_kernel_that_only_kernels_call_is_no_program_of_its_own() -> None:
    if not hasattr(twice, "signatures"):
        pytest.skip("kernels run uncompiled")
    assert twice_and_one(3) == 7
    assert not twice.signatures
    assert twice(3) == 6
    assert len(twice.signatures) == 1


def test_numba_is_left_as_it_was_also_after_an_error() -> None:
    if not hasattr(twice, "signatures"):
        pytest.skip("kernels run uncompiled")

    def state() -> tuple:
        return BaseFunction.get_call_type, type(errors.termcolor()).errmsg, gc.get_threshold()

    before, during = state(), []

    watched = jit.kernel(lambda x: x.no_such_attribute)
    usual = watched._compiler.compile
    watched._compiler.compile = lambda *args: (during.append(state()), usual(*args))[1]
    with pytest.raises(errors.TypingError, match="no_such_attribute"):
        watched(1)
    assert all(now != then for now, then in zip(during[0], before, strict=True))
    assert state() == before


def test_compiled_functions_of_others_can_call_kernels() -> None:
    @numba.njit
    def thrice(x):
        return twice_and_one(x) + x - 1

    assert thrice(5) == 15


@pytest.mark.slow
def test_a_numba_that_is_not_known_inside_compiles_in_the_usual_way(monkeypatch: pytest.MonkeyPatch) -> None:
    if not hasattr(twice, "signatures"):
        pytest.skip("kernels run uncompiled")
    monkeypatch.setattr(jit, "KNOWN_INSIDE", ((0, 1), (0, 2)))

    @jit.kernel
    def thrice(x):
        return 3 * x

    @jit.kernel
    def thrice_and_one(x):
        return thrice(x) + 1

    assert type(thrice) is type(numba.njit(lambda x: x)) and type(thrice) is not type(twice)
    assert thrice_and_one(3) == 10


AT_ONCE = """
import sys
from regista.kernels.jit import kernel

@kernel
def quadruple(x):
    return 4 * x

print("begun", flush=True)
sys.stdin.readline()
assert quadruple(2) == 8
print(sum(quadruple.stats.cache_misses.values()))
"""


@pytest.mark.long
def test_a_kernel_is_compiled_once_by_programs_that_begin_together(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(jit.ROOT), "NUMBA_CACHE_DIR": str(tmp_path)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    script = tmp_path / "at_once.py"
    script.write_text(AT_ONCE)
    options = {"env": environment, "stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    programs = [subprocess.Popen([sys.executable, str(script)], **options) for _ in range(2)]
    assert [program.stdout.readline() for program in programs] == ["begun\n"] * 2
    for program in programs:
        program.stdin.write("go\n")
        program.stdin.flush()
    assert sum(int(program.communicate(timeout=300)[0]) for program in programs) == 1


MISSES = """
import numpy as np
from regista.kernels import jit, rng

holder = np.zeros(1, [("random", "u8")]).view(np.recarray)[0]
holder.random = rng.streams([3])[0]
rng.uniform(holder)
print(sum(rng.uniform.stats.cache_misses.values()), jit.ROOT)
"""


@pytest.mark.long
def test_equal_copies_of_regista_share_what_is_compiled(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    environment.pop("NUMBA_DISABLE_JIT", None)
    misses = []
    for copy in (tmp_path / "first", tmp_path / "second", tmp_path / "edited"):
        for package in ("kernels", "minigames", "scenic_lite", "ued"):
            shutil.copytree(jit.ROOT / package, copy / package)
        shutil.copytree(jit.ROOT / "regista", copy / "regista", symlinks=True)
        if copy.name == "edited":
            with (copy / "kernels" / "rng.py").open("a") as source:
                source.write("EDITED = 1\n")
        command = [sys.executable, "-c", MISSES]
        options = {
            "env": environment | {"PYTHONPATH": str(copy)},
            "cwd": tmp_path,
            "capture_output": True,
            "text": True,
        }
        told = subprocess.run(command, check=True, **options).stdout.split()
        assert told[1] == str(copy)
        misses.append(int(told[0]))
    assert misses == [1, 0, 1]


WITHOUT_LINKING = """
import numba
from regista.kernels import jit, rng

@jit.kernel
def two_draws(holder):
    return rng.uniform(holder) + rng.uniform(holder)

import numpy as np
holder = np.zeros(1, [("random", "u8")]).view(np.recarray)[0]
holder.random = rng.streams([3])[0]
assert type(two_draws) is type(numba.njit(lambda: 0)), type(two_draws)
print(two_draws(holder), jit.digest())
"""


@pytest.mark.slow
def test_kernels_work_without_the_linking_of_their_own(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(jit.ROOT), "NUMBA_CACHE_DIR": str(tmp_path)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    environment["REGISTA_NUMBA_LINKING"] = "0"
    script = tmp_path / "two_draws.py"
    script.write_text(WITHOUT_LINKING)
    result = subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    total, digest = result.stdout.split()
    holder = np.zeros(1, [("random", "u8")]).view(np.recarray)[0]
    holder.random = streams([3])[0]
    assert float(total) == uniform(holder) + uniform(holder)
    assert digest != jit.digest()  # neither kind reads the other's cache
