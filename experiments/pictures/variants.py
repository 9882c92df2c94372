"""Looks of variants: the hue of their method at another lightness, with distinct dashes of lines and hatches of bars.

A variant is a named set of settings of a method. Read next: `pictures.plots`, which uses the looks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

LIGHTNESS = (61, 30, 46, 18)  # CIELAB lightness of variants; the lightest has a contrast ratio of 3 on white
APART = 11  # minimum difference in lightness from the method's color
DASHES: tuple[Any, ...] = ((0, (4, 1.6)), (0, (1.2, 1.2)), (0, (7, 1.6, 1.2, 1.6)), (0, (2, 3)), (0, (9, 3)))
HATCHES = ("////", "....", "xxxx", "\\\\\\\\", "----")
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])  # from linear sRGB
WHITE = TO_XYZ.sum(1)
BEND = 6 / 29  # below it, CIELAB is linear


class Look(NamedTuple):
    """The look of a variant: an RGB color, a Matplotlib line style, and a hatch."""

    color: str
    dashes: Any
    hatch: str


def looks(variants: Mapping[str, str], colors: Mapping[str, str]) -> dict[str, Look]:
    """Return the look of each variant.

    Args:
        variants: the method of each variant, by name.
        colors: the color of each method, as "#rrggbb".

    A method has at least three shades and five pairs of dashes and hatches for its variants; further variants repeat
    them.
    """
    found, seen = {}, Counter[str]()
    for name, method in variants.items():
        shades, index = shades_of(colors[method]), seen[method]
        shade = shades[index % len(shades)]
        found[name] = Look(shade, DASHES[index % len(DASHES)], HATCHES[index % len(HATCHES)])
        seen[method] += 1
    return found


def shades_of(color: str) -> list[str]:
    """Return at least three colors of the same hue with other lightness."""
    from matplotlib.colors import to_hex

    lightness, *ab = to_lab(color)
    found = [from_lab(other, np.array(ab)) for other in LIGHTNESS if abs(other - lightness) >= APART]
    return [to_hex((red, green, blue)) for red, green, blue in found]


def to_lab(color: Any) -> np.ndarray:
    """Return a color in CIELAB `[3]`: lightness from 0 to 100, a, b."""
    from matplotlib.colors import to_rgb

    rgb = np.array(to_rgb(color))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    share = TO_XYZ @ linear / WHITE
    f = np.where(share > BEND**3, np.cbrt(share), share / (3 * BEND**2) + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def from_lab(lightness: float, ab: np.ndarray) -> np.ndarray:
    """Return the sRGB color `[3]` in [0, 1] of this lightness and hue; reduce the chroma until sRGB contains it."""
    for chroma in np.linspace(1, 0, 41):
        f = (lightness + 16) / 116 + np.array([ab[0] / 500, 0, -ab[1] / 200]) * chroma
        share = np.where(f > BEND, f**3, 3 * BEND**2 * (f - 4 / 29))
        linear = np.linalg.solve(TO_XYZ, share * WHITE)
        if (linear >= 0).all() and (linear <= 1).all():
            break
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
