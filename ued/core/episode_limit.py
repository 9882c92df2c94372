"""The maximum episode length that an environment declares. Read next: `adapters.gym`."""

from __future__ import annotations

from typing import Any

import gymnasium

ATTRIBUTES = ("_max_episode_steps", "max_episode_steps", "max_steps")  # Gymnasium's TimeLimit, and MiniGrid


def episode_limit(env: gymnasium.Env) -> int | None:
    """Return the smallest limit that an environment or one of its wrappers declares; None: there is none."""
    limits: list[Any] = [env.spec.max_episode_steps] if env.spec is not None else []
    layer: Any = env
    while layer is not None:
        limits += [vars(layer).get(name) for name in ATTRIBUTES]
        layer = getattr(layer, "env", None) if isinstance(layer, gymnasium.Wrapper) else None
    return min((int(limit) for limit in limits if _is_limit(limit)), default=None)


def _is_limit(value: Any) -> bool:
    try:
        return not isinstance(value, bool) and int(value) == value and value > 0
    except (TypeError, ValueError, OverflowError):
        return False
