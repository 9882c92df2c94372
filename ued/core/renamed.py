"""Old names in files of older runs, mapped to current names when checkpoints and tables are read.

A field or key of a checkpoint, or a column of a table, that has an old name is read under its new name. Read next:
`checkpoint`, `columns` and `experiments/run/table.py`, which use it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

# Old name -> current name.
RENAMED = {"turn": "visit", "next_turn": "next_visit"}


def present_names(names: Iterable[str]) -> list[str]:
    """Return the current names of columns or fields that may have old names, in their order."""
    return [RENAMED.get(name, name) for name in names]


def present_keys(state: dict[Any, Any]) -> dict[Any, Any]:
    """Return a dictionary with the current names of its keys."""
    return {RENAMED.get(key, key): value for key, value in state.items()}


def present_fields(records: np.ndarray) -> np.ndarray:
    """Return records with the current names of their fields; other arrays unchanged."""
    names, fields = records.dtype.names, records.dtype.fields
    if names is None or fields is None or not RENAMED.keys() & set(names):
        return records
    parts = {"names": present_names(names), "formats": [fields[name][0] for name in names]}
    parts |= {"offsets": [fields[name][1] for name in names], "itemsize": records.dtype.itemsize}
    return records.view(np.dtype(parts))  # type: ignore[call-overload]  # names of a dtype are shared: not set in place
