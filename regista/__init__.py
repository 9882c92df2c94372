"""Curriculum learning for reinforcement learning: the functions and classes that most programs need.

    import regista

    run = regista.train(make, method="plr", out="runs/pendulum", total_env_steps=100_000)
    print(regista.evaluate(run).text())
    policy = regista.load_policy(run)
    metrics = regista.load_run(run).metrics()

It also exports all names of `ued`: `regista.GymUPOMDP`, `regista.Range`, `regista.Paired` ... Names are loaded when
first used. `gymnasium.make("regista:regista/1v1Free-v1")` needs no import, since this package registers the minigames.
Read next: `regista.experiments.calls`: `train`, `evaluate`, `compare` and `inspect`; `ued`, the methods.
"""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any


def _check_siblings() -> None:
    """Raise `ImportError` if Python finds another `ued` or `scenic_lite` first, such as a user's own `ued.py`."""
    home = Path(__file__).resolve().parent.parent
    for name in ("ued", "scenic_lite"):
        spec = find_spec(name)
        found = Path(spec.origin).resolve() if spec and spec.origin else None
        if found and found.parent != home / name:
            raise ImportError(
                f"Regista needs its own package {name!r}, at {home / name}, but Python finds {found} first. "
                f"Rename that file, or put its folder later on sys.path."
            )


_check_siblings()  # before a module of Regista imports the wrong package

from regista import minigames as minigames  # noqa: E402

if TYPE_CHECKING:  # for editors and type checkers
    from regista.experiments.calls import compare as compare
    from regista.experiments.calls import evaluate as evaluate
    from regista.experiments.calls import inspect as inspect
    from regista.experiments.calls import train as train
    from regista.experiments.loaded import load_comparison as load_comparison
    from regista.experiments.loaded import load_run as load_run
    from ued import *  # type: ignore[assignment]  # noqa: F403

_CALLS = dict.fromkeys(("train", "evaluate", "compare", "inspect"), "regista.experiments.calls")
_CALLS |= dict.fromkeys(("load_run", "load_comparison"), "regista.experiments.loaded")


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return __dir__()
    if name == "__version__":
        from importlib.metadata import version

        return version("regista")
    return getattr(import_module(_CALLS.get(name, "ued")), name)


def __dir__() -> list[str]:
    return sorted({*_CALLS, "__version__", *dir(import_module("ued"))})
