"""`kernel`: the decorator that compiles all of Regista's Numba functions and caches the machine code.

Numba's own cache checks only the file that defines a function: after an edit of a constant or a callee in another file
it returns stale code. So the cache folder is named after a digest of all source files that kernels use. A file with
kernels must therefore import only other files with kernels and files without imports of their own. With any other
import, an unrelated edit would recompile the football simulator.
Read next: `regista.envs.football.simulator`, the largest user.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

# Numba and torch start an OpenMP pool each. Threads that spin while they wait take cores from the other pool: two
# threads then train ten times slower than one. The policy must be set before either library starts its pool.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import numba
import numpy as np

ROOT = Path(__file__).parents[2].resolve()  # a checkout, or site-packages
PACKAGES = ("regista/kernels", "scenic_lite", "regista/envs")
RECORDS = "ued/core/compiled.py"  # of compiled rollouts: kernels read their fields without importing this file
KNOWN_INSIDE = (
    (0, 61),
    (0, 69),
)  # Numba versions whose internals `numba_linking` supports: the first is included, the second is not
# `numba_linking` saves half of the first compilation, but relies on Numba's private classes: 0 disables it.
LINKING = os.environ.get("REGISTA_NUMBA_LINKING", "1") != "0"
OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False}  # `_nrt`: no reference counting
KEPT_CACHES = 4  # digests: the current one and a few that a developer may switch back to
KEPT_SECONDS = 86_400  # a younger cache may belong to a running program

_numba_config: Any = numba.config
_IMPORT = re.compile(r"^(?:from|import)\s+([\w.]+)(?:\s+import\s+(\([^)]*\)|.*))?", re.MULTILINE)


def kernel(function: Callable | None = None, *, parallel: bool = False, inline: bool = False) -> Any:
    """Compile a function with Numba, without fast-math (so that one and two threads agree), and cache it.

    Kernels create no arrays, so they skip reference counting, which would cost a tenth of their time. Kernels never
    raise: with `error_model="numpy"` a division by zero gives inf or nan, as in C. With `NUMBA_DISABLE_JIT=1` the
    function is returned unchanged and runs as plain Python. With `inline` the function is inlined into its callers:
    passing a batch of arrays costs more than many kernels take to run.
    """

    def decorate(undecorated: Callable) -> Any:
        if _numba_config.DISABLE_JIT:
            return undecorated
        previous = _numba_config.CACHE_DIR
        _numba_config.CACHE_DIR = str(CACHE)
        try:
            return _dispatcher(undecorated, {**OPTIONS, "parallel": parallel, "forceinline": inline})
        finally:
            _numba_config.CACHE_DIR = previous  # other libraries keep their own caches

    return decorate if function is None else decorate(function)


def linked() -> bool:
    """Return whether `numba_linking`, which shows progress, compiles kernels, instead of Numba alone."""
    return LINKING and KNOWN_INSIDE[0] <= numba.version_info[:2] < KNOWN_INSIDE[1]


def _dispatcher(function: Callable, options: dict[str, Any]) -> Any:
    """Return a `Kernel` of the function if this version of Numba supports it, else Numba's own dispatcher."""
    if not linked():
        return numba.njit(cache=True, **options)(function)
    from regista.kernels.numba_linking import Kernel

    made = Kernel(function, {"nopython": True, **options})
    made.enable_caching()
    return made


def compiled(function: Any) -> bool:
    """Return whether a call needs no compilation: the kernel runs as Python, or is in memory or in the cache."""
    if not hasattr(function, "signatures") or function.signatures:
        return True
    folder = Path(function.stats.cache_path)
    stem = f"{function.py_func.__module__.rpartition('.')[2]}.{function.py_func.__qualname__}-"
    return folder.is_dir() and any(path.name.startswith(stem) for path in folder.glob("*.nbc"))


def sources() -> list[Path]:
    """List the sources of compiled code: files with kernels, files of this project that they import, and `RECORDS`."""
    texts = {path: path.read_text() for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    seen: set[Path] = set()
    pending = [path for path in (ROOT / RECORDS,) if path.is_file()]
    texts |= {path: path.read_text() for path in pending}
    pending += (path for path, text in texts.items() if "regista.kernels.jit import" in text)
    pending += (path for path in texts if path.parent == ROOT / "regista" / "kernels")  # the compiler itself
    while pending:
        path = pending.pop()
        if path in seen:
            continue
        seen.add(path)
        for dotted, names in _IMPORT.findall(texts[path]):
            base = ROOT / Path(*dotted.split("."))
            modules = [base, *(base / name for name in re.findall(r"\w+", names))]  # a name may be a module, too
            pending += [
                file
                for module in modules
                for file in (module.with_suffix(".py"), module / "__init__.py")
                if file in texts
            ]
    return sorted(seen)


def digest() -> str:
    """Return the digest of `sources()` and of the compiler's versions and options: 16 hexadecimal digits.

    A checkout and an installed package with the same sources have the same digest and share compiled kernels.
    """
    config = _numba_config
    made_by = (numba.__version__, np.__version__, LINKING, config.BOUNDSCHECK, config.USING_SVML)
    state = hashlib.sha256(" ".join(map(str, made_by)).encode())
    for path in sources():
        state.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes() + b"\0")
    return state.hexdigest()[:16]


def _cache_folder() -> Path:
    """Create the cache folder of this digest in NUMBA_CACHE_DIR, else in the user's cache, else in a temporary folder.

    Cached code is executed, so a folder that another user could write into is rejected.
    """
    user_cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "regista"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    for parent in (Path(chosen) if chosen else user_cache, Path(tempfile.gettempdir()) / f"regista-{os.getuid()}"):
        folder = parent / digest()
        try:
            parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _private(parent.resolve()):
                continue
            folder.mkdir(mode=0o700, exist_ok=True)
            if not _private(folder):
                continue
            folder.chmod(0o700)
            folder.touch()  # marks the folder as the newest: `_forget` sorts by age
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError:
            continue
        _forget(parent)
        return folder
    fresh = Path(tempfile.mkdtemp(prefix="regista-"))
    atexit.register(_remove, fresh, os.getpid())
    print(f"regista: compiled kernels are cached in {fresh} until this program ends", file=sys.stderr)
    return fresh


def _private(folder: Path) -> bool:
    """Return whether a folder belongs to the user and is writable only by the user; print a warning if not."""
    status = folder.lstat()
    mine, writable = status.st_uid == os.getuid(), bool(status.st_mode & 0o022)
    if mine and not writable and stat.S_ISDIR(status.st_mode):
        return True
    why = "it belongs to another user" if not mine else "others may write into it" if writable else "it is not a folder"
    print(f"regista: {folder} is not used as a cache of compiled kernels: {why}", file=sys.stderr)
    return False


def _remove(folder: Path, maker: int) -> None:
    """Remove a temporary cache at the end of the process that made it, but not at the end of its children."""
    if os.getpid() == maker:
        shutil.rmtree(folder, ignore_errors=True)


def _forget(parent: Path) -> None:
    """Remove the caches of old digests, except the newest few; leave other files in the folder unchanged."""
    ages = {}
    for path in parent.iterdir():
        with suppress(OSError):  # another program may be removing caches, too
            if re.fullmatch(r"[0-9a-f]{16}", path.name):
                ages[path] = time.time() - path.stat().st_mtime
    for path in sorted(ages, key=lambda path: ages[path])[KEPT_CACHES:]:
        if ages[path] > KEPT_SECONDS:
            shutil.rmtree(path, ignore_errors=True)


CACHE = _cache_folder()
