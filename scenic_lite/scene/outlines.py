"""The outlines of what a program is about, for pictures: its workspace, and the regions from which points are drawn.

Read next: `scene.program`, which lists them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from scenic_lite.core.state import DrawnPoint
from scenic_lite.errors import ScenicError
from scenic_lite.values.regions import Region


class Area(NamedTuple):
    """A region as lines: `strips`, each [n, 2] in the program's units; `what` is "workspace" or "drawn"."""

    what: str
    strips: list[np.ndarray]


def areas_of(workspace: Region | None, points: Iterable[DrawnPoint]) -> tuple[Area, ...]:
    """The workspace, and the regions from which points are drawn, as named; not those that are random or endless."""
    found = [Area("workspace", strips_of(workspace))] if workspace is not None else []
    regions = {id(region): region for region in (each.whole or each.region for each in points)}
    found += [Area("drawn", strips_of(region)) for region in regions.values() if region is not workspace]
    return tuple(area for area in found if area.strips)


def strips_of(region: Region) -> list[np.ndarray]:
    """The boundary of a region; nothing where it is random or endless."""
    try:
        return region.outlines()
    except ScenicError:
        return []
