"""Saving and resuming by a list of names: what changes while an object works, said once where the object is made.

Read next: `checkpoint`, the file in which such states end.
"""

from __future__ import annotations

import copy
from typing import Any

import numpy as np


class Resumable:
    """An object that names in `state_fields` the attributes that change while it works.

    They may be numbers, arrays, generators of numpy or torch, and objects with a `state_dict` of their own.
    """

    state_fields: tuple[str, ...] = ()

    def state_dict(self) -> dict[str, Any]:
        """Return a copy of everything that changes."""
        return {name: _saved(getattr(self, name)) for name in self.state_fields}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Take back what `state_dict` returned."""
        for name in self.state_fields:
            setattr(self, name, _restored(getattr(self, name), state[name]))


def _saved(value: Any) -> Any:
    if isinstance(value, np.random.Generator):
        return value.bit_generator.state
    if hasattr(value, "state_dict"):  # torch's modules and optimisers return their own tensors, which learning changes
        return copy.deepcopy(value.state_dict())
    return value.get_state() if hasattr(value, "get_state") else copy.deepcopy(value)


def _restored(value: Any, state: Any) -> Any:
    """Return `value` with this state put into it, or where it is plain data, a copy of the state."""
    if isinstance(value, np.random.Generator):
        value.bit_generator.state = state
    elif hasattr(value, "load_state_dict"):
        value.load_state_dict(copy.deepcopy(state))
    elif hasattr(value, "set_state"):
        value.set_state(state)
    else:
        return copy.deepcopy(state)
    return value
