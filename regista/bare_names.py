"""`import envs` in a checkout returns the modules of `regista.envs`, not a second copy of them under another name.

The root of a checkout is often on `sys.path`, and with it the folders to which `regista.kernels`, `regista.envs`,
`regista.minigames` and `regista.experiments` link. Each folder calls `lead_inside` when it is imported under its bare
name.
"""

import sys
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_loader
from types import ModuleType
from typing import Any


class _Inside(MetaPathFinder, Loader):
    """Find `envs.x` as `regista.envs.x` if `envs` is the package of Regista."""

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        top = fullname.partition(".")[0]
        inside = sys.modules.get(f"regista.{top}")
        if top == fullname or inside is None or sys.modules.get(top) is not inside:
            return None
        spec = find_spec(f"regista.{fullname}")
        package = spec is not None and spec.submodule_search_locations is not None
        return spec and spec_from_loader(fullname, self, origin=spec.origin, is_package=package)

    def exec_module(self, module: ModuleType) -> None:
        sys.modules[module.__name__] = import_module(f"regista.{module.__name__}")

    def get_code(self, fullname: str) -> Any:
        """Return the code of a module for `python -m`."""
        spec: Any = find_spec(f"regista.{fullname}")
        return spec.loader.get_code(spec.name)


def lead_inside(name: str) -> None:
    """Make `name`, one of the four folders, and its modules aliases of the package `regista.name`."""
    if not any(isinstance(finder, _Inside) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Inside())
    sys.modules[name] = import_module(f"regista.{name}")
