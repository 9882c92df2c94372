"""Checkpoints: the full state of a run in one file, written atomically.

The file is written to a temporary name, synced and renamed. It is read with `weights_only=True`, so an untrusted file
cannot execute code. Types that torch does not support in this mode (numpy arrays and integers of more than 64 bits, as
in generator states) are encoded as tensors, numbers and strings. Read next: `methods`.
"""

from __future__ import annotations

import ast
import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import torch

from ued.core.files import write_whole
from ued.core.renamed import present_fields, present_keys

FORMAT = "regista checkpoint"
VERSION = 3  # 1: methods without learners; 2: normalizers without a floor
ARRAY, INTEGER, TUPLE, RESERVED = "__array__", "__integer__", "__tuple__", ("__array__", "__integer__", "__tuple__")


class CheckpointError(Exception):
    """A checkpoint that cannot be written or read; the message gives the reason."""


def save(path: str | Path, state: dict[str, Any]) -> None:
    """Write a checkpoint atomically: at any time `path` holds either the old or the new checkpoint.

    `state` may hold dicts, lists, tuples, tensors, numpy arrays, numbers, strings and None.
    Raises `CheckpointError` for other types, and if the file cannot be written.
    """
    path = Path(path)
    content = io.BytesIO()  # torch reports an archive error, not a full disk, if it writes the file itself
    torch.save({"format": FORMAT, "version": VERSION, "state": encode(state)}, content)
    try:
        write_whole(path, content.getbuffer())
    except OSError as error:
        kept = " (the previous checkpoint is kept)" if path.exists() else ""
        raise CheckpointError(f"cannot write {path}: {_reason(error)}{kept}") from error


def load(path: str | Path) -> dict[str, Any]:
    """Read a checkpoint. Raises `CheckpointError` for a file that is missing, truncated, foreign or too new."""
    return _entry(Path(path), None)


def load_entry(path: str | Path, key: str) -> Any:
    """Read one entry of a checkpoint without loading the arrays of others. Raises like `load`."""
    return _entry(Path(path), key)


def _entry(path: Path, key: str | None) -> Any:
    """Read one entry of a checkpoint, or all of it."""
    content = _content(path, mapped=key is not None)
    try:
        return decode(content if key is None else content[key])
    except Exception as error:  # any error that damaged values can cause
        raise CheckpointError(_damaged(path)) from error


def _damaged(path: Path) -> str:
    return f"{path} is not a checkpoint, or it is truncated or damaged"


def _content(path: Path, mapped: bool) -> dict[str, Any]:
    damaged = _damaged(path)
    try:
        with open(path, "rb") as file:
            if not zipfile.is_zipfile(file):
                raise CheckpointError(damaged)
        content = torch.load(path, map_location="cpu", weights_only=True, mmap=mapped)
    except FileNotFoundError as error:
        raise CheckpointError(f"there is no checkpoint at {path}") from error
    except OSError as error:
        raise CheckpointError(f"cannot read {path}: {_reason(error)}") from error
    except CheckpointError:
        raise
    except Exception as error:  # any error of torch with a damaged archive
        raise CheckpointError(damaged) from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise CheckpointError(f"{path} is not a checkpoint of this program")
    if content.get("version") != VERSION:
        raise CheckpointError(
            f"{path} has version {content.get('version')} of the checkpoint format; this program reads {VERSION}"
        )
    if not isinstance(content.get("state"), dict):
        raise CheckpointError(damaged)
    return content["state"]


def encode(value: Any, where: str = "state") -> Any:
    """Encode `value` as dicts, lists, tensors, strings and numbers of at most 64 bits."""
    if isinstance(value, dict):
        _check_keys(value, where)
        return {key: encode(item, f"{where}[{key!r}]") for key, item in value.items()}
    if isinstance(value, list):
        return [encode(item, f"{where}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, tuple):
        return {TUPLE: [encode(item, f"{where}[{i}]") for i, item in enumerate(value)]}
    if isinstance(value, np.ndarray):
        return _encode_array(value, where)
    if isinstance(value, np.generic):
        return encode(value.item(), where)
    if isinstance(value, int) and not isinstance(value, bool) and not -(2**63) <= value < 2**63:
        return {INTEGER: str(value)}
    if value is None or isinstance(value, (bool, int, float, str, torch.Tensor)):
        return value
    raise CheckpointError(f"{where} is a {type(value).__name__}, which a checkpoint cannot hold")


def decode(value: Any) -> Any:
    """Decode the output of `encode`; old names of keys and fields become the current names, see `renamed`."""
    if isinstance(value, list):
        return [decode(item) for item in value]
    if not isinstance(value, dict):
        return value
    if ARRAY in value:
        return _decode_array(value)
    if INTEGER in value:
        return int(value[INTEGER])
    if TUPLE in value:
        return tuple(decode(item) for item in value[TUPLE])
    return present_keys({key: decode(item) for key, item in value.items()})


def _check_keys(value: dict[Any, Any], where: str) -> None:
    for key in value:
        if not isinstance(key, (str, int)) or key in RESERVED:
            raise CheckpointError(f"{where} has the key {key!r}; keys must be strings or integers, and not reserved")


def _encode_array(array: np.ndarray, where: str) -> dict[str, Any]:
    if array.dtype.hasobject:
        raise CheckpointError(f"{where} is an array of Python objects, which a checkpoint cannot hold")
    data = np.frombuffer(array.tobytes(), np.uint8).copy() if array.size else np.zeros(0, np.uint8)
    described = repr(np.lib.format.dtype_to_descr(array.dtype))
    return {ARRAY: torch.from_numpy(data), "dtype": described, "shape": list(array.shape)}


def _decode_array(value: dict[str, Any]) -> np.ndarray:
    described = ast.literal_eval(value["dtype"])  # older checkpoints hold a dictionary
    dtype = np.dtype(described) if "names" in described else np.lib.format.descr_to_dtype(described)
    return present_fields(np.frombuffer(value[ARRAY].numpy().tobytes(), dtype).reshape(value["shape"]).copy())


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
