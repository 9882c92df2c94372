"""Places of labels in a scene such that labels neither overlap nor are cut off at the edge.

The viewer draws a label below its point, in pixels. Sizes are for a view 760 pixels wide, half of a window. Read next:
`recorder.scene_log`, which draws the labels.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# As shares of the view's width: the width of a label's character, its height, and its distance below its point.
CHARACTER, LINE, BELOW = 0.0078, 0.024, 0.021
PADDING = 3  # characters around a text
MOST_LINES = 12  # maximum distance in lines by which a label moves up or down


def spread(places: np.ndarray, texts: Sequence[str], bounds: Sequence[float]) -> np.ndarray:
    """Return the points below which labels are drawn, near their places.

    Args:
        places: `[n, 2]`, y-up.
        texts: the labels, in order of priority.
        bounds: bounds of the view: x low, x high, y low, y high.

    Returns points `[n, 2]`. A label without room within `MOST_LINES` lines overlaps others.
    """
    x_low, x_high, y_low, y_high = bounds
    character, line, below = (size * (x_high - x_low) for size in (CHARACTER, LINE, BELOW))
    found, half = np.zeros((len(texts), 2)), np.array([(len(text) + PADDING) * character / 2 for text in texts])
    moves = [*range(0, -MOST_LINES - 1, -1), *range(1, MOST_LINES + 1)]  # upward, a label covers its own place
    for k, (x, y) in enumerate(places):
        x = np.clip(x, x_low + half[k], max(x_high - half[k], x_low + half[k]))
        for move in moves:
            found[k] = x, np.clip(y + move * line, y_low + below + line / 2, y_high)
            apart = np.abs(found[:k] - found[k])  # [k, 2]
            if not ((apart[:, 0] < half[:k] + half[k]) & (apart[:, 1] < 0.99 * line)).any():
                break
    return found
