"""Uniform points of a fixed shape from two uniform numbers: the first gives x, the second y.

The shape is cut at the x of every corner into vertical slabs, in each of which it is a stack of trapezoids. x is the
inverse of the share of the area left of it, y divides what lies on the vertical line through x. So both grow with
their numbers, and near numbers give near points wherever the shape is not interrupted. Read next: `values.polygons`.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np


class Slabs:
    """edges [E, 4] (x, y of both ends) of closed rings that do not cross; S slabs of up to K trapezoids each."""

    def __init__(self, edges: Any) -> None:
        xs = np.unique(edges[:, [0, 2]])
        stacks = [stack_between(edges, *pair) for pair in pairwise(xs)]
        deepest = max(len(stack) for stack in stacks)
        sides = np.zeros((len(stacks), deepest, 4))  # lower left, lower right, upper left, upper right
        for slab, stack in zip(sides, stacks, strict=True):
            slab[: len(stack)] = stack
            slab[len(stack) :] = stack[-1][[2, 3, 2, 3]] if len(stack) else 0.0
        self.start, self.width = xs[:-1], np.diff(xs)
        self.low, self.low_step = sides[..., 0], sides[..., 1] - sides[..., 0]
        self.high = sides[..., 2:] - sides[..., :2]  # heights at the left and right, [S, K, 2]
        self.left, self.right = self.high.sum(axis=1).T  # of the whole stack, [S]
        areas = self.width * (self.left + self.right) / 2
        self.ends = np.cumsum(areas) / areas.sum()
        self.before = np.concatenate([[0.0], self.ends[:-1]])

    def __call__(self, u: Any, v: Any) -> tuple[Any, Any]:
        """[N], [N] -> x [N], y [N]."""
        which = np.minimum(np.searchsorted(self.ends, u, side="right"), len(self.ends) - 1)
        share = np.clip((u - self.before[which]) / np.maximum(self.ends[which] - self.before[which], 1e-300), 0.0, 1.0)
        left, right = self.left[which], self.right[which]
        root = left + np.sqrt(left * left + (right * right - left * left) * share)
        t = np.minimum(share * (left + right) / np.maximum(root, 1e-300), 1.0)
        low, height = self._stack(which, t)
        ends = np.cumsum(height, axis=1)
        target = v * ends[:, -1]
        level = np.minimum((target[:, None] > ends[:, :-1]).sum(axis=1), low.shape[1] - 1)
        rows = np.arange(len(which))
        y = low[rows, level] + target - (ends[rows, level] - height[rows, level])
        return self.start[which] + t * self.width[which], y

    def _stack(self, which: Any, t: Any) -> tuple[Any, Any]:
        """The lower ends and the heights of the trapezoids on the verticals at t of some slabs, each [N, K]."""
        t = t[:, None]
        height = self.high[which]
        return self.low[which] + t * self.low_step[which], height[..., 0] * (1 - t) + height[..., 1] * t


def stack_between(edges: Any, start: float, end: float) -> Any:
    """The trapezoids between two neighbouring xs, the lowest first: [K, 4]."""
    low, high = np.minimum(edges[:, 0], edges[:, 2]), np.maximum(edges[:, 0], edges[:, 2])
    x0, y0, x1, y1 = edges[(low <= start) & (high >= end)].T
    at_start, at_end = (y0 + (y1 - y0) * ((x - x0) / (x1 - x0)) for x in (start, end))
    order = np.argsort(at_start + at_end, kind="stable")
    lines = np.stack([at_start, at_end], axis=1)[order]
    return np.hstack([lines[::2], lines[1::2]])
