"""Rendered frames of environments as pictures, for recordings, videos and `inspect --png`."""

from __future__ import annotations

from typing import Any

import numpy as np

from regista.experiments.run.errors import CommandError
from ued.core.upomdp import UPOMDP

BACKGROUND = (128, 128, 128)  # around pictures that are smaller than the video


def rendered(env: UPOMDP) -> list[np.ndarray] | None:
    """Return one picture per environment, uint8 `[height, width, 3]`; None unless the render mode is `rgb_array`.

    Gray pictures `[height, width]` or `[height, width, 1]` get three equal channels; the alpha channel of RGBA pictures
    is dropped.

    Raises:
        CommandError: `render` failed, or returned something else.
    """
    if env.render_mode != "rgb_array":
        return None
    try:
        images: Any = env.render()
    except Exception as error:  # any error of the environment
        raise CommandError(f"the environment cannot render: {type(error).__name__}: {error}") from error
    if images is None:
        raise _not_a_picture("None")
    return [picture(image) for image in images]


def picture(image: Any) -> np.ndarray:
    """Return a rendered image as uint8 `[height, width, 3]`. Raises `CommandError` for anything else."""
    try:
        array = np.asarray(image)
    except ValueError:  # a list of frames of different sizes
        raise _not_a_picture(f"a {type(image).__name__}") from None
    if array.dtype == object or array.dtype.kind not in "biuf":
        raise _not_a_picture("None" if image is None else f"a {type(image).__name__}")
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or array.shape[2] not in (1, 3, 4) or not array.size:
        raise _not_a_picture(f"an array of shape {list(array.shape)}")
    if array.dtype != np.uint8:
        if array.dtype.kind not in "iu" or array.min() < 0 or array.max() > 255:
            raise _not_a_picture(f"{array.dtype} values from {array.min():g} to {array.max():g}")
        array = array.astype(np.uint8)
    return np.repeat(array, 3, 2) if array.shape[2] == 1 else array[..., :3]


def fitted(image: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Return a picture in the size of another, as a video requires: shrunk if larger, and centered on gray."""
    if image.shape == like.shape:
        return image
    from PIL import Image, ImageOps

    height, width = like.shape[:2]
    inside = Image.fromarray(image)
    if image.shape[0] > height or image.shape[1] > width:
        inside = ImageOps.contain(inside, (width, height))
    page = Image.new("RGB", (width, height), BACKGROUND)
    page.paste(inside, ((width - inside.width) // 2, (height - inside.height) // 2))
    return np.asarray(page)


def _not_a_picture(found: str) -> CommandError:
    return CommandError(
        f"the environment's render() returned {found}; for render_mode='rgb_array' it must return a picture, an array "
        "[height, width, 3] of uint8 values from 0 to 255"
    )
