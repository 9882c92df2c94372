"""Saving and resuming by a list of names: a class lists its mutable attributes once.

Read next: `checkpoint`, the file of such states.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

NUMBER, WHOLE = "a number", "an integer"


class Resumable:
    """An object whose mutable attributes are listed in `state_fields`.

    They may be numbers, arrays, generators of numpy or torch, and objects with their own `state_dict`.
    `optional_fields` holds the types of attributes that may be None.
    """

    state_fields: tuple[str, ...] = ()
    optional_fields: ClassVar[Mapping[str, type]] = {}

    def state_dict(self) -> dict[str, Any]:
        """Return a copy of the whole state."""
        return {name: _saved(getattr(self, name)) for name in self.state_fields}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Restore a state returned by `state_dict`.

        The first axis of arrays may have another length, since some arrays grow; subclasses check it where it may not.
        Raises ValueError for other types or shapes, KeyError for missing fields.
        """
        for name in self.state_fields:
            value, saved = getattr(self, name), state[name]
            if name in self.optional_fields:
                value = None if saved is None else self.optional_fields[name]()
            setattr(self, name, restored(value, saved, name))


def _saved(value: Any) -> Any:
    if isinstance(value, np.random.Generator):
        return value.bit_generator.state
    if hasattr(value, "state_dict"):  # torch's modules and optimizers return their own tensors, which learning changes
        return copy.deepcopy(value.state_dict())
    return value.get_state() if hasattr(value, "get_state") else copy.deepcopy(value)


def restored(value: Any, state: Any, name: str) -> Any:
    """Return `value` with this state restored, or for plain data a copy of the state."""
    if isinstance(value, np.random.Generator):
        value.bit_generator.state = state
    elif hasattr(value, "load_state_dict"):
        value.load_state_dict(copy.deepcopy(state))
    elif hasattr(value, "set_state"):
        value.set_state(state)
    else:
        kinds = (_kind(value), _kind(state))
        if kinds[0] != kinds[1] and kinds != (NUMBER, WHOLE):
            raise ValueError(f"{name} is {kinds[1]} and must be {kinds[0]}")
        return copy.deepcopy(state)
    return value


def _kind(value: Any) -> str:
    """Describe the type of plain data; for an array its dtype and all but its first axis."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype}, {['N', *value.shape[1:]] if value.ndim else 'one number'}"
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return WHOLE if -(2**63) <= value < 2**63 else "a number of more than 64 bits"
    return NUMBER if isinstance(value, float | np.floating) else f"a {type(value).__name__}"
