"""A match as a picture: `draw_match` draws one state as pixels, `write_video` many as a video.

Pictures are drawn with Pillow at twice the size and shrunk, so that edges are smooth. Pixels count from the upper left,
meters from the middle of the pitch with +y up. Read next: `view.render`, the lines of the pitch.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.envs.football.constants import GK, GOAL_HALF_WIDTH, HALF_LENGTH, HALF_WIDTH, LEFT, NOBODY, STEP
from regista.envs.football.view.render import (
    GOAL_DEPTH,
    LEFT_COLOR,
    LEFT_KEEPER_COLOR,
    PENALTY_SPOT,
    RIGHT_COLOR,
    RIGHT_KEEPER_COLOR,
    Color,
    pitch_lines,
)
from ued.core.files import partial_of

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

MODES = ("", "kick-off", "goal kick", "free kick", "corner", "throw-in", "penalty")
FRAMES_PER_SECOND = round(1 / STEP)
FAR = 32  # in steps of 255; a color further than this from the palette extends the palette
MOST_KEYS = 8  # maximum number of pictures from which the palette of a film is made
FASTEST = 50  # frames per second of .gif and .webp: viewers show faster ones slowly

SHARPER = 2  # oversampling factor
SCALE = 7 * SHARPER  # pixels per meter
BORDER = 4.0  # m of grass around the pitch
BAR = 34 * SHARPER  # pixels, the bar with the score above the pitch
WIDTH = round(2 * (HALF_LENGTH + BORDER) * SCALE)
HEIGHT = round(2 * (HALF_WIDTH + BORDER) * SCALE) + BAR
STRIPE = 5.5  # m, width of the stripes of mown grass

BODY = 1.3  # m, radius of a player, larger than life
BALL = 0.55  # m, likewise
RISE = 0.55  # m up in the picture, per meter of the ball's height
GROWTH = 0.12  # relative size increase, per meter of the ball's height
GRASS: tuple[Color, Color] = ((46, 125, 66), (54, 137, 74))
CHALK: Color = (232, 240, 232)
DARK: Color = (18, 24, 20)
MARKED: Color = (255, 235, 59)  # players moved by agents
CARD: Color = (255, 214, 0)


def draw_match(match: Any) -> np.ndarray:
    """Return the state of one match, a row of MATCH, as uint8 `[height, width, 3]`: 594 × 826 pixels.

    Keepers wear other colors, agents' players have a yellow ring, a nose shows a player's facing, and the ball has a
    shadow on the ground. The bar shows score, time, and the pending restart.
    """
    from PIL import Image
    from PIL.ImageDraw import Draw

    image = _pitch().copy()
    draw = Draw(image)
    players = [player for player in match["players"][: match["num_players"]] if not player["has_left"]]
    for player in sorted(players, key=lambda each: -each["y"]):
        _draw_player(draw, player)
    _draw_ball(draw, match["ball"])
    _draw_bar(draw, match)
    return np.asarray(image.resize((WIDTH // SHARPER, HEIGHT // SHARPER), Image.Resampling.BOX))


def write_video(path: str | Path, frames: Iterable[np.ndarray], speed: float = 1.0) -> None:
    """Write pictures uint8 `[height, width, 3]`, one per step, as a video at `speed` times real time.

    `.gif` and `.webp` need no other package; `.mp4` needs imageio-ffmpeg, `pip install regista[video]`. Raises
    ValueError for another suffix or without frames, ImportError if the package is missing.
    """
    path = Path(path)
    check_film(path)
    rate = FRAMES_PER_SECOND * speed
    rest = iter(frames)
    first = next(rest, None)
    if first is None:
        raise ValueError(f"{path.name}: there is no frame to write")
    partial = partial_of(path)  # after an error there is no file, or still the previous one
    try:
        if path.suffix == ".mp4":
            _write_mp4(partial, first, rest, rate)
        else:
            _write_animation(partial, path.suffix[1:], first, rest, rate)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def check_film(path: Path) -> None:
    """Raise the errors of `write_video` for this file early, before any picture is drawn."""
    if path.suffix not in (".gif", ".webp", ".mp4"):
        raise ValueError(f"{path.name}: the name of a video must end in .gif, .webp or .mp4")
    if not path.absolute().parent.is_dir():
        raise ValueError(f"{path}: the folder {path.parent} does not exist")
    if path.suffix == ".mp4" and find_spec("imageio_ffmpeg") is None:
        raise ImportError("writing .mp4 needs imageio-ffmpeg: pip install 'regista[video]'; or choose .gif")


def _write_animation(path: Path, kind: str, first: np.ndarray, rest: Iterable[np.ndarray], rate: float) -> None:
    """Write an animation; above FASTEST frames per second only every second, third, ... frame, at the same speed."""
    from PIL import Image

    every = math.ceil(rate / FASTEST)
    rest, rate = islice(rest, every - 1, None, every), rate / every

    if kind == "gif":
        images = _timed(map(_Palette(first).paged, chain([first], rest)), rate)
        next(images).save(path, kind, save_all=True, append_images=images, loop=0)
    else:
        more, duration = map(Image.fromarray, rest), round(1000 / rate)
        Image.fromarray(first).save(path, kind, save_all=True, append_images=more, duration=duration, loop=0)


def _timed(images: Iterable[Image], rate: float) -> Iterator[Image]:
    """Give each image its duration: whole hundredths of a second in GIF, rounded so that the speed stays correct."""
    end = 0
    for number, image in enumerate(images, start=1):
        begin, end = end, round(100 * number / rate)
        image.info["duration"] = 10 * (end - begin)
        yield image


class _Palette:
    """One palette for all frames, so that the pitch does not flicker, with room for rare colors such as the keepers'.

    The palette changes at a frame with colors that no earlier frame has.
    """

    def __init__(self, first: np.ndarray) -> None:
        self.keys = [first]
        self.palette = self._of_keys()

    def paged(self, frame: np.ndarray) -> Image:
        """Return a frame in the colors of the palette."""
        found = self._in_palette(frame)
        if len(self.keys) < MOST_KEYS and np.abs(np.asarray(found.convert("RGB")) - frame.astype(int)).max() > FAR:
            self.keys.append(frame)
            self.palette = self._of_keys()
            found = self._in_palette(frame)
        return found

    def _in_palette(self, frame: np.ndarray) -> Image:
        from PIL import Image

        return Image.fromarray(frame).quantize(palette=self.palette, dither=Image.Dither.NONE)

    def _of_keys(self) -> Image:
        from PIL import Image

        colors = np.concatenate([key.reshape(1, -1, 3) for key in self.keys], 1)
        return Image.fromarray(colors).quantize(256, Image.Quantize.MAXCOVERAGE)


def _write_mp4(path: Path, first: np.ndarray, rest: Iterable[np.ndarray], rate: float) -> None:
    import imageio_ffmpeg

    height, width = _even(first).shape[:2]
    writer = imageio_ffmpeg.write_frames(
        str(path), (width, height), fps=rate, macro_block_size=2, output_params=["-f", "mp4"]
    )
    writer.send(None)
    try:
        writer.send(_even(first))
        for frame in rest:
            writer.send(_even(frame))
    finally:
        writer.close()


def _even(frame: np.ndarray) -> np.ndarray:
    """Repeat the last row or column of a frame if their number is odd, which H.264 does not support."""
    height, width = frame.shape[:2]
    return np.ascontiguousarray(np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), "edge"))


# ---------------------------------------------------------------- the pitch


def _at(x: float, y: float) -> tuple[float, float]:
    """Return the pixel of a position in meters."""
    return (x + HALF_LENGTH + BORDER) * SCALE, (HALF_WIDTH + BORDER - y) * SCALE + BAR


def _disc(draw: ImageDraw, center: tuple[float, float], radius: float, **colors: Any) -> None:
    """Draw a disc with center and radius in pixels."""
    x, y = center
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), **colors)


@cache
def _pitch() -> Image:
    """Return the empty pitch."""
    from PIL import Image
    from PIL.ImageDraw import Draw

    image = Image.new("RGB", (WIDTH, HEIGHT), GRASS[0])
    draw = Draw(image)
    for stripe in range(0, round(2 * HALF_LENGTH / STRIPE), 2):
        left = -HALF_LENGTH + stripe * STRIPE
        draw.rectangle((*_at(left, HALF_WIDTH + BORDER), *_at(left + STRIPE, -HALF_WIDTH - BORDER)), fill=GRASS[1])
    for side in (-1, 1):
        _draw_net(draw, side)
    for strip in pitch_lines():
        draw.line([_at(x, y) for x, y in strip], fill=CHALK, width=2 * SHARPER)
    for x in (0.0, HALF_LENGTH - PENALTY_SPOT, PENALTY_SPOT - HALF_LENGTH):
        _disc(draw, _at(x, 0.0), 0.3 * SCALE, fill=CHALK)
    for x, y, start in ((1, 1, 90), (-1, 1, 0), (-1, -1, 270), (1, -1, 180)):
        middle, radius = _at(x * HALF_LENGTH, y * HALF_WIDTH), 1.0 * SCALE
        box = (middle[0] - radius, middle[1] - radius, middle[0] + radius, middle[1] + radius)
        draw.arc(box, start, start + 90, fill=CHALK, width=2 * SHARPER)
    return image


def _draw_net(draw: ImageDraw, side: int) -> None:
    """Draw the net behind one goal line."""
    inner, outer = side * HALF_LENGTH, side * (HALF_LENGTH + GOAL_DEPTH)
    for step in range(9):
        y = -GOAL_HALF_WIDTH + step * GOAL_HALF_WIDTH / 4
        draw.line([_at(inner, y), _at(outer, y)], fill=(150, 180, 150), width=1)
    for step in range(1, 5):
        x = inner + (outer - inner) * step / 5
        draw.line([_at(x, -GOAL_HALF_WIDTH), _at(x, GOAL_HALF_WIDTH)], fill=(150, 180, 150), width=1)


# ---------------------------------------------------------------- players and ball


def _draw_player(draw: ImageDraw, player: Any) -> None:
    x, y = _at(player["x"], player["y"])
    radius = BODY * SCALE
    shirts = (LEFT_COLOR, RIGHT_COLOR), (LEFT_KEEPER_COLOR, RIGHT_KEEPER_COLOR)
    shirt = shirts[int(player["role"] == GK)][0 if player["team"] == LEFT else 1]
    _disc(draw, (x + 0.25 * SCALE, y + 0.3 * SCALE), radius, fill=(36, 98, 52))  # shadow
    if player["agent"] != NOBODY:
        _disc(draw, (x, y), radius + 0.45 * SCALE, fill=MARKED)
    ahead = (x + 1.45 * radius * player["facing_x"], y - 1.45 * radius * player["facing_y"])
    draw.line([(x, y), ahead], fill=DARK, width=round(0.45 * SCALE))
    down = player["down_wait"] > 0.0
    _disc(draw, (x, y), radius, fill=_faded(shirt) if down else shirt, outline=DARK, width=SHARPER)
    number = str(int(player["shirt"]) + 1)
    draw.text((x, y), number, fill=DARK, font=_font(round(1.45 * SCALE)), anchor="mm", stroke_width=0)
    if player["cards"]:
        draw.rectangle((x + 0.7 * radius, y - 1.5 * radius, x + 1.2 * radius, y - 0.7 * radius), fill=CARD)


def _draw_ball(draw: ImageDraw, ball: Any) -> None:
    ground = _at(ball["x"], ball["y"])
    height = max(float(ball["z"]) - 0.11, 0.0)
    radius = BALL * SCALE * (1.0 + GROWTH * min(height, 8.0))
    shadow = 0.9 * BALL * SCALE
    lie = (ground[0] - 1.2 * shadow, ground[1] - 0.3 * shadow, ground[0] + 1.2 * shadow, ground[1] + 1.1 * shadow)
    draw.ellipse(lie, fill=(20, 62, 34))
    _disc(
        draw, (ground[0], ground[1] - RISE * height * SCALE), radius, fill=(255, 255, 255), outline=DARK, width=SHARPER
    )


def _draw_bar(draw: ImageDraw, match: Any) -> None:
    """Draw score and time in the middle, the pending restart to the right of it."""
    draw.rectangle((0, 0, WIDTH, BAR), fill=DARK)
    font, middle = _font(round(0.6 * BAR)), BAR / 2
    seconds = int(match["step"] * STEP)
    draw.text((WIDTH / 2, middle), f"{match['score'][0]} : {match['score'][1]}", fill=CHALK, font=font, anchor="mm")
    for side, color in ((-1, LEFT_COLOR), (1, RIGHT_COLOR)):
        _disc(draw, (WIDTH / 2 + side * 1.6 * BAR, middle), 0.25 * BAR, fill=color)
    clock = f"{seconds // 60}:{seconds % 60:02d}"
    draw.text((0.4 * BAR, middle), clock, fill=CHALK, font=font, anchor="lm")
    event = {1: "goal, left", -1: "goal, right"}.get(int(match["goal"]), MODES[int(match["game_mode"])])
    draw.text((WIDTH - 0.4 * BAR, middle), event, fill=MARKED, font=font, anchor="rm")


def _faded(color: Color) -> Color:
    """Draw a player on the ground."""
    return tuple(round(0.55 * part + 0.45 * grass) for part, grass in zip(color, GRASS[0], strict=True))  # type: ignore[return-value]


@cache
def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size)
