"""Fixed polygons: triangles, clipping, and membership of many points at once.

A polygon is a list of (x, y) pairs; a convex piece likewise, anticlockwise. Read next: `regions`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scenic_lite.errors import ScenicError

Point2 = tuple[float, float]
CLOSENESS = 1e-9  # a point this near a boundary belongs to it


def signed_area(points: list[Point2]) -> float:
    """Positive if the points run anticlockwise."""
    pairs = zip(points, points[1:] + points[:1], strict=True)
    return 0.5 * math.fsum(px * qy - qx * py for (px, py), (qx, qy) in pairs)


def triangulated(points: list[Point2]) -> list[list[Point2]]:
    """Triangles that tile a simple polygon, by cutting off ears. Raises ScenicError if it crosses itself."""
    ring = points if signed_area(points) > 0 else points[::-1]
    ring = list(ring)
    triangles = []
    while len(ring) > 3:
        ear = next((i for i in range(len(ring)) if _is_ear(ring, i)), None)
        if ear is None:
            raise ScenicError("value", "the polygon crosses itself or has no area")
        triangles.append([ring[ear - 1], ring[ear], ring[(ear + 1) % len(ring)]])
        del ring[ear]
    triangles.append(ring)
    return [triangle for triangle in triangles if signed_area(triangle) > 0]


def _is_ear(ring: list[Point2], i: int) -> bool:
    a, b, c = ring[i - 1], ring[i], ring[(i + 1) % len(ring)]
    if _turn(a, b, c) < 0:
        return False
    others = (point for point in ring if point not in (a, b, c))
    return not any(_turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0 for p in others)


def _turn(a: Any, b: Any, c: Any) -> Any:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def clipped(piece: list[Point2], start: Point2, end: Point2) -> list[Point2]:
    """The part of a convex piece on the left of the line from `start` to `end`."""
    kept: list[Point2] = []
    for p, q in zip(piece, piece[1:] + piece[:1], strict=True):
        side_p, side_q = _turn(start, end, p), _turn(start, end, q)
        if side_p >= 0:
            kept.append(p)
        if side_p * side_q < 0:
            t = side_p / (side_p - side_q)
            kept.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
    return kept


def intersection(first: list[list[Point2]], second: list[list[Point2]]) -> list[list[Point2]]:
    """The convex pieces of the common part of two sets of convex pieces."""
    pieces = []
    for a in first:
        for b in second:
            if _boxes_meet(a, b):
                piece = a
                for start, end in zip(b, b[1:] + b[:1], strict=True):
                    piece = clipped(piece, start, end) if piece else piece
                pieces.append(piece)
    return [piece for piece in pieces if len(piece) > 2 and signed_area(piece) > 1e-12]


def difference(first: list[list[Point2]], second: list[list[Point2]]) -> list[list[Point2]]:
    """The convex pieces of what is in `first` and not in `second`."""
    pieces = first
    for b in second:
        pieces = [part for piece in pieces for part in _outside(piece, b)]
    return pieces


def _outside(piece: list[Point2], hole: list[Point2]) -> list[list[Point2]]:
    """Cut a convex piece along each edge of a convex hole, keeping what lies outside."""
    if not _boxes_meet(piece, hole):
        return [piece]
    parts = []
    for start, end in zip(hole, hole[1:] + hole[:1], strict=True):
        part = clipped(piece, end, start)
        if len(part) > 2 and signed_area(part) > 1e-12:
            parts.append(part)
        piece = clipped(piece, start, end)
        if not piece:
            break
    return parts


class EdgesCross:
    """Whether an edge of a rectangle, given by its corners, crosses the boundary of a polygon into its outside."""

    def __init__(self, ring: list[Point2]) -> None:
        self.ring = ring

    def __call__(self, *corners: Any) -> Any:
        """x, y of four corners, arrays [N] or scalars -> [N]."""
        points = [(corners[i], corners[i + 1]) for i in range(0, 8, 2)]
        crossed: Any = False
        for p, q in zip(self.ring, self.ring[1:] + self.ring[:1], strict=True):
            for a, b in zip(points, points[1:] + points[:1], strict=True):
                apart = _turn(p, q, a) * _turn(p, q, b) < -CLOSENESS
                crossed = crossed | (apart & (_turn(a, b, p) * _turn(a, b, q) < -CLOSENESS))
        return crossed


def _boxes_meet(a: list[Point2], b: list[Point2]) -> bool:
    return all(
        min(p[axis] for p in a) <= max(q[axis] for q in b) and min(q[axis] for q in b) <= max(p[axis] for p in a)
        for axis in (0, 1)
    )


class PieceSampler:
    """Uniform points of a set of convex pieces from two uniform numbers; preserves area."""

    def __init__(self, pieces: list[list[Point2]]) -> None:
        fans = [[piece[0], piece[i], piece[i + 1]] for piece in pieces for i in range(1, len(piece) - 1)]
        self.triangles = np.array(fans)  # [K, 3, 2]
        areas = np.array([abs(signed_area(fan)) for fan in fans])
        self.ends = np.cumsum(areas) / np.sum(areas)
        self.starts = np.concatenate([[0.0], self.ends[:-1]])

    def __call__(self, u: Any, v: Any) -> Any:
        """[N], [N] -> x [N], y [N]. The first number picks a triangle; what is left of it is used again inside."""
        which = np.minimum(np.searchsorted(self.ends, u, side="right"), len(self.ends) - 1)
        start, end = self.starts[which], self.ends[which]
        root = np.sqrt(np.clip((u - start) / (end - start), 0.0, 1.0))
        corners = self.triangles[which]  # [N, 3, 2]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        points = a + (b - a) * (root * (1 - v))[:, None] + (c - a) * (root * v)[:, None]
        return points[:, 0].copy(), points[:, 1].copy()


def distance_to_pieces(pieces: list[list[Point2]], x: Any, y: Any) -> Any:
    """Distance of points from the nearest of some convex pieces, 0 inside; arrays [N] or scalars."""
    nearest: Any = np.inf
    for piece in pieces:
        for (px, py), (qx, qy) in zip(piece, piece[1:] + piece[:1], strict=True):
            dx, dy = qx - px, qy - py
            along = np.clip(((x - px) * dx + (y - py) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
            nearest = np.minimum(nearest, np.hypot(x - px - along * dx, y - py - along * dy))
    return np.where(PieceMembership(pieces)(x, y), 0.0, nearest)


class PieceMembership:
    """Whether points lie in any of a set of convex pieces, boundaries included."""

    def __init__(self, pieces: list[list[Point2]]) -> None:
        self.pieces = [np.array(piece) for piece in pieces]

    def __call__(self, x: Any, y: Any) -> Any:
        inside = np.zeros(np.broadcast(x, y).shape, dtype=bool)
        for piece in self.pieces:
            within = np.ones(inside.shape, dtype=bool)
            for (px, py), (qx, qy) in zip(piece, np.roll(piece, -1, axis=0), strict=True):
                length = math.hypot(qx - px, qy - py)
                within &= (qx - px) * (y - py) - (qy - py) * (x - px) >= -CLOSENESS * length
            inside |= within
        return inside
