"""The cache of machine code: named by a file's path within Regista, not by its path on the disk.

Numba names the folder after the path of the source file, so each clone and each environment would compile the same
kernels again. The cache folder of `kernels.jit` is named by a digest of all sources, so equal copies of Regista can
share it. Read next: `kernels.numba_linking`, whose kernels use this cache.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

from regista.kernels.notices import say_once

ROOT = Path(__file__).parents[2].resolve()  # a checkout, or site-packages
PACKAGES = ("regista", "scenic_lite")

_config: Any = numba.config


class _PlaceWithin(_CacheLocator):
    """The cache folder for the kernels of one folder of Regista, inside the cache of `kernels.jit`."""

    def __init__(self, py_func: Any, py_file: str, within: Path) -> None:
        self._py_file = py_file
        self._line = py_func.__code__.co_firstlineno
        self._folder = Path(_config.CACHE_DIR) / ".".join(within.parent.parts)

    @classmethod
    def from_function(cls, py_func: Callable, py_file: str) -> _PlaceWithin | None:
        """Return the locator of a function, or None for a function outside Regista, whose place Numba chooses."""
        path = Path(py_file)
        within = path.relative_to(ROOT) if path.is_relative_to(ROOT) else Path()
        if not _config.CACHE_DIR or within.parts[:1] not in {(name,) for name in PACKAGES}:
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


@cache
def _digest(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


_PLACES: list[Any] = [_PlaceWithin, *CompileResultCacheImpl._locator_classes]


class _KernelCacheImpl(CompileResultCacheImpl):
    _locator_classes = _PLACES


class KernelCache(FunctionCache):
    """Numba's cache of one function, placed by `_PlaceWithin`. A cache that cannot be read or written is no error."""

    _impl_class = _KernelCacheImpl

    def holds(self, sig: Any, target_context: Any) -> bool:
        """Return whether code for this signature is cached; damage is only found by loading it."""
        this: Any = self  # Numba's own names for its files
        target_context.refresh()
        try:
            file = this._cache_file._load_index().get(this._index_key(sig, target_context.codegen()))
        except Exception:  # what unpickling raises depends on the damage
            return False
        return file is not None and Path(this._cache_file._data_path(file)).exists()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached code, None if there is none or it is damaged, as after a loss of power."""
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:
            say_once(f"regista: cached kernels are damaged and compiled again ({type(error).__name__})")
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Cache the code, if the disk takes it."""
        try:
            super().save_overload(sig, data)
        except OSError as error:
            say_once(f"regista: compiled kernels are not cached: {error.strerror or error}: {self.cache_path}")
