"""The outlines of what a program is about, for pictures: its workspace, and the regions from which points are drawn.

Read next: `program`, which lists them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from scenic_lite.errors import ScenicError
from scenic_lite.frame import DrawnPoint
from scenic_lite.polygons import Point2
from scenic_lite.regions import Filtered, PolylineRegion, Region


class Area(NamedTuple):
    """A region as lines: `strips`, each [n, 2] in the program's units; `what` is "workspace" or "drawn"."""

    what: str
    strips: list[np.ndarray]


def areas_of(workspace: Region | None, points: Iterable[DrawnPoint]) -> tuple[Area, ...]:
    """The workspace, and every region from which a point is drawn, once each; not those that are random or endless."""
    found = [Area("workspace", strips_of(workspace))] if workspace is not None else []
    regions = {id(each.region): each.region for each in points}
    found += [Area("drawn", strips_of(region)) for region in regions.values() if region is not workspace]
    return tuple(area for area in found if area.strips)


def strips_of(region: Region) -> list[np.ndarray]:
    """The boundary of a region; nothing where it is random or endless."""
    if isinstance(region, Filtered):
        return strips_of(region.region)
    if isinstance(region, PolylineRegion):
        return [np.asarray(region.points)]
    try:
        return boundary(region.pieces())
    except ScenicError:
        return []


def boundary(pieces: list[list[Point2]]) -> list[np.ndarray]:
    """The edges that only one of some convex pieces has, joined to strips [n, 2] where one ends as the next begins."""
    edges: dict[tuple, tuple] = {}  # from rounded start to end; two pieces have an inner edge in opposite directions
    for piece in pieces:
        for start, end in zip(piece, piece[1:] + piece[:1], strict=True):
            a, b = rounded(start), rounded(end)
            if (b, a) in edges:
                del edges[b, a]
            elif a != b:
                edges[a, b] = (start, end)
    strips: list[list[Point2]] = []
    for start, end in edges.values():
        if strips and rounded(strips[-1][-1]) == rounded(start):
            strips[-1].append(end)
        else:
            strips.append([start, end])
    return [np.array(strip, dtype=float) for strip in strips]


def rounded(point: Point2) -> Point2:
    return round(point[0], 6), round(point[1], 6)
