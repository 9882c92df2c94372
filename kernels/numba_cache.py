"""The cache of machine code: its entries are named by a file's path within Regista, not by its path on the disk.

Numba names the folder after the path of the source file, so each clone and each environment would compile the same
kernels again. The cache folder of `kernels.jit` is named after a digest of all sources, so equal copies of Regista
share it. The stamp of another project's kernel covers all code that it uses; Numba's stamp covers only its own file.
Read next: `kernels.numba_linking`, whose kernels use this cache.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import numpy as np
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from regista.kernels.notices import names_in, reached, say_once

ROOT = Path(__file__).parents[2].resolve()  # a checkout, or site-packages
PACKAGES = ("regista", "scenic_lite")
CONSTANTS = (bool, int, float, str, bytes, tuple, np.generic, np.dtype)  # globals that are compiled into a kernel

_config: Any = numba.config


class _PlaceWithin(_CacheLocator):
    """The cache folder for the kernels of one folder of Regista, inside the cache of `kernels.jit`."""

    def __init__(self, py_func: Any, py_file: str, within: Path) -> None:
        self._py_file = py_file
        self._line = py_func.__code__.co_firstlineno
        self._folder = Path(_config.CACHE_DIR) / ".".join(within.parent.parts)

    @classmethod
    def from_function(cls, py_func: Callable, py_file: str) -> _PlaceWithin | None:
        """Return the locator of a function, or None outside Regista, where Numba chooses the folder."""
        within = _within(py_file)
        if not _config.CACHE_DIR or within is None:
            return None
        place = cls(py_func, py_file, within)
        try:
            place.ensure_cache_path()
        except OSError:
            return None
        return place

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return _digest(self._py_file)

    def get_disambiguator(self) -> str:
        return str(self._line)


def _within(py_file: str) -> Path | None:
    """Return the path of a source file within Regista; None for other files."""
    path = Path(py_file)
    within = path.relative_to(ROOT) if path.is_relative_to(ROOT) else Path()
    return within if within.parts[:1] in {(name,) for name in PACKAGES} else None


@cache
def _digest(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


def stamp_of(function: Callable) -> str:
    """Return a digest of the source and constants outside Regista that a function's compiled code and callees use."""
    texts = []
    for each in reached(function):
        if _within(each.__code__.co_filename) is None:
            texts.append(inspect.getsource(each))
            texts += (f"{name} = {_constant(each.__globals__.get(name))}" for name in sorted(names_in(each.__code__)))
    return hashlib.sha256("\0".join(sorted(texts)).encode()).hexdigest()


def _constant(value: Any) -> str:
    """Return the text of a global that is compiled into a kernel; for a module, the digest of its file."""
    if isinstance(value, ModuleType):
        file = str(getattr(value, "__file__", None))
        return _digest(file) if file.endswith(".py") else ""
    if isinstance(value, np.ndarray):
        return value.tobytes().hex()
    return repr(value) if isinstance(value, CONSTANTS) else ""


_PLACES: list[Any] = [_PlaceWithin, *CompileResultCacheImpl._locator_classes]


class _KernelCacheImpl(CompileResultCacheImpl):
    _locator_classes = _PLACES


class KernelCache(FunctionCache):
    """Numba's cache of one function, placed by `_PlaceWithin`. Read and write failures raise no errors."""

    _impl_class = _KernelCacheImpl
    _stamped = False

    def _stamp(self) -> None:
        """Stamp a kernel outside Regista at its first use, since its callees may be defined after it."""
        this: Any = self
        if not self._stamped and not isinstance(this._impl.locator, _PlaceWithin):
            this._cache_file._source_stamp = (this._cache_file._source_stamp, stamp_of(this._py_func))
        self._stamped = True

    def holds(self, sig: Any, target_context: Any) -> bool:
        """Return whether code for this signature is cached; only loading it detects damage."""
        this: Any = self  # untyped, since these attributes are private to Numba
        target_context.refresh()
        try:
            self._stamp()
            file = this._cache_file._load_index().get(this._index_key(sig, target_context.codegen()))
        except Exception:  # the type depends on the damage to the pickled index
            return False
        return file is not None and Path(this._cache_file._data_path(file)).exists()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached code, or None if it is missing or damaged, as after a power failure."""
        try:
            self._stamp()
            return super().load_overload(sig, target_context)
        except Exception as error:
            say_once(f"regista: cached kernels are damaged and compiled again ({type(error).__name__})")
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Cache the code; print a line if the disk does not accept it."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            say_once(f"regista: compiled kernels are not cached: {error.strerror or error}: {self.cache_path}")
