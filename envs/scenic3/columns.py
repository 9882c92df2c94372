"""Scenic's random primitives as columns of θ: each is a function of numbers in [0, 1], uniform if θ is uniform.

Scenic samples a value by `sampleGiven`. We use the inverse cumulative distribution function instead, so uniform θ gives
the distribution of Scenic's sampler. A point in a region takes two columns (one on a line, three in a volume), and
moves continuously with them if the region is connected.
Read next: `program`, which finds the primitives of a program and samples with them.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Mapping
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from scenic.core.distributions import DiscreteRange, Distribution, Normal, Range, RejectionException, TruncatedNormal
from scenic.core.distributions import supportInterval as support
from scenic.core.lazy_eval import needsSampling
from scenic.core.regions import (
    CircularRegion,
    DifferenceRegion,
    IntersectionRegion,
    MeshVolumeRegion,
    PointInRegionDistribution,
    PolygonalRegion,
    PolylineRegion,
    RectangularRegion,
    Region,
    SectorRegion,
)
from scenic.core.vectors import OrientedVector, Vector

from regista.envs.scenic3.names import Place
from ued.core.parameters import Integer

TAIL = 1e-9  # probability of each tail of a normal distribution that the bounds -1 and 1 of θ cut off
STANDARD = NormalDist()
Given = Mapping[Any, Any]  # sampled values by their distributions


class ScenicColumn(NamedTuple):
    """One column of θ, with the fields of `scenic_lite.Draw`; for equally likely values, `kind` is `ued`'s name."""

    name: str
    kind: Any
    low: float
    high: float
    place: Place


class Part(NamedTuple):
    """A column of a primitive: the suffix of its name, its kind, and its bounds, NaN if random or infinite."""

    suffix: str
    kind: Any
    low: float = math.nan
    high: float = math.nan


# ---------------------------------------------------------------- numbers


def _range(draw: Range, given: Given, u: float) -> float:
    low, high = given[draw.low], given[draw.high]
    return low + u * (high - low)


def _normal(draw: Normal, given: Given, u: float) -> float:
    return given[draw.mean] + given[draw.stddev] * STANDARD.inv_cdf(min(max(u, TAIL), 1 - TAIL))


def _truncated(draw: TruncatedNormal, given: Given, u: float) -> float:
    mean, deviation = given[draw.mean], given[draw.stddev]
    low, high = (STANDARD.cdf((end - mean) / deviation) for end in (draw.low, draw.high))
    within = min(max(low + u * (high - low), TAIL), 1 - TAIL)
    return min(max(mean + deviation * STANDARD.inv_cdf(within), draw.low), draw.high)


def _integer(draw: DiscreteRange, given: Given, u: float) -> int:
    if draw.weights:
        cumulative = draw.cumulativeWeights
        return draw.low + min(bisect_left(cumulative, u * cumulative[-1]), len(cumulative) - 1)
    low, high = math.ceil(given[draw.low]), math.floor(given[draw.high])
    if high < low:
        raise RejectionException(draw.emptyMessage)
    return low + min(int(u * (high - low + 1)), high - low)


def _number_part(draw: Distribution, kind: Any) -> list[Part]:
    low, high = (math.nan if end is None else float(end) for end in support(draw))
    return [Part("", kind, low, high)]


def _integer_part(draw: DiscreteRange) -> list[Part]:
    fixed = not draw.weights and not needsSampling(draw.low) and not needsSampling(draw.high)
    low, high = math.ceil(draw.low) if fixed else 0, math.floor(draw.high) if fixed else -1
    return _number_part(draw, Integer(low, high) if low <= high else "integers")


# ---------------------------------------------------------------- points


class Slices:
    """Polygons cut into vertical slices: a share of the area gives x, a share of the slice gives y."""

    def __init__(self, region: PolygonalRegion) -> None:
        rings = [ring for shape in region.polygons.geoms for ring in (shape.exterior, *shape.interiors)]
        corners = [np.array(ring.coords)[:, :2] for ring in rings]  # the first corner is repeated at the end
        self.begins = np.vstack([ring[:-1] for ring in corners])  # [edges, 2]
        self.ends = np.vstack([ring[1:] for ring in corners])
        self.x = np.unique(self.begins[:, 0])  # between two neighboring x, the length of slices is linear in x
        width = np.diff(self.x)
        third, two_thirds = (
            np.array([self._length(x) for x in self.x[:-1] + share * width]) for share in (1 / 3, 2 / 3)
        )
        self.left, self.right = np.maximum(2 * third - two_thirds, 0), np.maximum(2 * two_thirds - third, 0)
        self.area = np.concatenate([[0.0], np.cumsum(width * (self.left + self.right) / 2)])

    def point(self, u: float, v: float) -> tuple[float, float]:
        """Return the point for two shares in [0, 1]."""
        area = u * self.area[-1]
        slab = int(np.clip(np.searchsorted(self.area, area, "right") - 1, 0, len(self.left) - 1))
        left, slope, width = self.left[slab], self.right[slab] - self.left[slab], self.x[slab + 1] - self.x[slab]
        ahead = (area - self.area[slab]) / width  # = left t + slope t² / 2, for the share t of the slab
        root = math.sqrt(max(left * left + 2 * slope * ahead, 0.0))
        t = 2 * ahead / (left + root) if left + root > 0 else 0.5
        x = float(np.clip(self.x[slab] + t * width, *_inside(self.x[slab], self.x[slab + 1])))
        crossed = self._crossings(x)
        along = v * self._length(x)
        for low, high in zip(crossed[::2], crossed[1::2], strict=True):
            if along <= high - low:
                return x, float(low + along)
            along -= high - low
        return x, float(crossed[-1])

    def _crossings(self, x: float) -> np.ndarray:
        """Return the intervals of the vertical line at x inside the polygon, from bottom to top."""
        (x0, y0), (x1, y1) = self.begins.T, self.ends.T
        cut = (x0 <= x) != (x1 <= x)
        share = (x - x0[cut]) / (x1[cut] - x0[cut])
        return np.sort(y0[cut] + share * (y1[cut] - y0[cut]))

    def _length(self, x: float) -> float:
        crossed = self._crossings(x)
        return float((crossed[1::2] - crossed[::2]).sum())


def _inside(low: float, high: float) -> tuple[float, float]:
    """Return bounds slightly inside an interval, since a slice at its exact end may be empty."""
    margin = 1e-9 * (high - low)
    return low + margin, high - margin


def _in_polygon(region: PolygonalRegion, u: float, v: float) -> Vector:
    if not hasattr(region, "_regista_slices"):
        region._regista_slices = Slices(region)  # cached on the region, as Scenic caches triangles
    return region.orient(Vector(*region._regista_slices.point(u, v), region.z))


def _in_rectangle(region: RectangularRegion, u: float, v: float) -> Vector:
    offset = Vector((2 * u - 1) * region.hw, (2 * v - 1) * region.hl, 0)
    return region.orient(region.position.offsetRotated(region.heading, offset))


def _in_disc(region: CircularRegion, u: float, v: float) -> Vector:
    """Map squares around the center to circles; areas and neighborhoods are preserved (Shirley and Chiu 1997)."""
    a, b = 2 * u - 1, 2 * v - 1
    if a == b == 0:
        return _polar(region, 0.0, 0.0)
    if abs(a) > abs(b):
        return _polar(region, a, math.pi / 4 * b / a)
    return _polar(region, b, math.pi / 2 - math.pi / 4 * a / b)


def _in_sector(region: SectorRegion, u: float, v: float) -> Vector:
    return _polar(region, math.sqrt(u), (v - 0.5) * region.angle + region.heading + math.pi / 2)


def _polar(region: CircularRegion | SectorRegion, share: float, angle: float) -> Vector:
    x, y, z = region.center
    radius = region.radius * share
    return region.orient(Vector(x + radius * math.cos(angle), y + radius * math.sin(angle), z))


def _on_line(region: PolylineRegion, u: float, _: float = 0.0) -> Vector:
    ends = region.cumulativeLengths
    index = min(bisect_left(ends, u * ends[-1]), len(ends) - 1)
    (x0, y0), (x1, y1) = (point[:2] for point in region.segments[index])
    t = 1 - (ends[index] - u * ends[-1]) / (ends[index] - (ends[index - 1] if index else 0.0))
    x, y = x0 + t * (x1 - x0), y0 + t * (y1 - y0)
    if region._usingDefaultOrientation:
        return OrientedVector(x, y, 0, math.atan2(y1 - y0, x1 - x0) - math.pi / 2)
    return region.orient(Vector(x, y, 0))


def _in_volume(region: MeshVolumeRegion, u: float, v: float, w: float) -> Vector:
    low, high = np.array(region.AABB)
    return Vector(*(low + np.array([u, v, w]) * (high - low)))


# The first matching class applies: the number of columns of a region, and the function from shares to a point.
REGIONS: dict[type, tuple[int, Callable[..., Vector]]] = {
    RectangularRegion: (2, _in_rectangle),
    CircularRegion: (2, _in_disc),
    SectorRegion: (2, _in_sector),
    PolygonalRegion: (2, _in_polygon),
    PolylineRegion: (1, _on_line),
    MeshVolumeRegion: (3, _in_volume),  # a point in its bounding box; points outside the volume are rejected
}


def _row(region: Region) -> tuple[int, Callable[..., Vector]] | None:
    return next((row for kind, row in REGIONS.items() if isinstance(region, kind)), None)


def _base(region: Region) -> Region:
    """Return the region in which a point is drawn; `point_in` then checks the rest of an intersection or difference."""
    if isinstance(region, DifferenceRegion):
        return _base(region.regionA)
    if isinstance(region, IntersectionRegion):
        return _base(min(region.regions, key=lambda part: part.dimensionality or math.inf))
    return region


def point_in(region: Region, *shares: float) -> Vector:
    """Return the point for these shares, one per column of the region. Raises `RejectionException` if there is none."""
    base = _base(region)
    row = _row(base)
    if row is None:  # the union of regions of different kinds
        return region.uniformPointInner()
    count, place = row
    point = place(base, *(*shares, 0.5, 0.5)[:count])
    if not isinstance(base, PolygonalRegion | PolylineRegion) or base is not region:
        if not region._trueContainsPoint(point):
            raise RejectionException(f"no point of {region}")
        return region.orient(point)
    return point


def _point_parts(draw: PointInRegionDistribution) -> list[Part]:
    if needsSampling(draw.region):  # the kind may differ between samples
        return [Part(".x", "point.x"), Part(".y", "point.y")]
    base = _base(draw.region)
    row = _row(base)
    if row is None:
        return []
    if row[0] == 1:
        return [Part(".along", "point.along", 0.0, float(base.length))]
    box = zip("xyz"[: row[0]], *base.AABB, strict=False)
    return [Part(f".{name}", f"point.{name}", float(low), float(high)) for name, low, high in box]


# ---------------------------------------------------------------- the table

# By exact class: the columns of a primitive, and its value from its dependencies and its shares in [0, 1].
PRIMITIVES: dict[type, tuple[Callable[[Any], list[Part]], Callable[..., Any]]] = {
    Range: (lambda draw: _number_part(draw, "range"), _range),
    Normal: (lambda draw: _number_part(draw, "normal"), _normal),
    TruncatedNormal: (lambda draw: _number_part(draw, "normal"), _truncated),
    DiscreteRange: (_integer_part, _integer),
    PointInRegionDistribution: (
        _point_parts,
        lambda draw, given, *shares: point_in(given[draw.region], *shares),
    ),
}
