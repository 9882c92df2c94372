"""The animation of the README: a trained policy plays, beside the levels that a method proposed over training.

    python -m lab.hero            # trains PAIRED on 1v1Rare for half a minute; writes docs/pictures/hero.gif

Read next: `regista.experiments.pictures.level_plots`, which draws densities of levels.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from regista.envs.football.replay import load_record, replay
from regista.envs.football.view.picture import BAR, SCALE, SHARPER, draw_match
from regista.experiments.__main__ import main as regista
from regista.experiments.pictures import keys, plots
from regista.experiments.pictures.level_plots import draw_levels, kinds_of, read_periods
from regista.experiments.run import build
from regista.experiments.run.folder import RunFolder
from ued.core.task import TRAINING_SCENE

PICTURE = Path("docs/pictures/hero.gif")
GAME, STEPS = "1v1Rare", 1_200_000
SETTINGS = "--num-envs 16 --num-steps 512 --ent-coef 0.003 --paired.adversary.ent-coef 0.1 --no-record"
Bounds = tuple[float, float, float, float]  # x_low, x_high, y_low, y_high
STAGES = 12  # of the training
WIDTH, MARGIN, SCALES = 400, 26, 64  # pixels: width of each half, and margins above and below the pitch
SHOWN = ("start of the attacker", "start of the keeper")
MILLISECONDS = 80  # per frame
COLORS, SAMPLED = 256, 24  # colors of the palette, and frames from which it is made


def train(out: Path) -> RunFolder:
    """Return the run; train it if it is missing."""
    if not (out / "config.json").exists():
        words = ["train", GAME, "--method", "paired", "--total-env-steps", str(STEPS), *SETTINGS.split()]
        if regista([*words, "--out", str(out)]):
            raise SystemExit("the training was stopped")
    return RunFolder.open(out)


def matches(run: RunFolder, scene: str, seeds: Sequence[int], bounds: Bounds) -> list[np.ndarray]:
    """Return the frames of episodes of the run's student, cropped to `bounds`, in meters."""
    frames = []
    for seed in seeds:
        path = run.path / f"match_{seed}.npz"
        if regista(["play", "--player", str(run.path), "--scene", scene, "--seed", str(seed), "--record", str(path)]):
            raise SystemExit("the match was not played")
        mine = [cut(draw_match(each[0]), bounds) for each in replay(load_record(path), endings=True)]
        frames += [*mine, *mine[-1:] * 6]  # the outcome stays for half a second
    return frames


def cut(frame: np.ndarray, bounds: Bounds) -> np.ndarray:
    """Return a part of a frame, WIDTH pixels wide, with margins in the background color."""
    scale = SCALE // SHARPER
    middle = frame.shape[1] / 2, (frame.shape[0] - BAR // SHARPER) / 2 + BAR // SHARPER
    x_low, x_high, y_low, y_high = (scale * value for value in bounds)
    box = (middle[0] + x_low, middle[1] - y_high, middle[0] + x_high, middle[1] - y_low)
    part = Image.fromarray(frame).crop(tuple(map(round, box)))
    part = part.resize((WIDTH, round(part.height * WIDTH / part.width)), Image.Resampling.LANCZOS)
    paper = Image.new("RGB", (WIDTH, part.height + MARGIN + SCALES), "white")
    paper.paste(part, (0, MARGIN))
    return np.asarray(paper)


def densities(run: RunFolder, painter: Any, height: int) -> list[np.ndarray]:
    """Return a picture for each stage of training: the density of starting positions."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    spans = list(pairwise(np.linspace(0, 1, STAGES + 1)))
    pictures = []
    for span, theta in zip(spans, read_periods(run.path, spans), strict=True):
        with plots.style():
            figure = Figure(figsize=(WIDTH / 100, height / 100), dpi=100)
            axes = figure.add_axes((0, SCALES / height, 1, 1 - (MARGIN + SCALES) / height))
            draw_levels(axes, painter, [theta])
            figure.text(
                0.02, 1 - 0.25 * MARGIN / height, f"PAIRED's levels, {span[1] * STEPS / 1e6:.1f}M steps", va="top"
            )
            shades = [shade for _, _, shade in kinds_of(painter)]
            keys.density_scales(figure, list(zip(SHOWN, shades, strict=True)))
            canvas = FigureCanvasAgg(figure)
            canvas.draw()
            pictures.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    return pictures


def painter_of(run: RunFolder) -> Any:
    """Return the painter of a run's game."""
    game = build.find_game(run.config.minigame)
    task = game.task(run.config)
    assert task.painter is not None
    return task.painter(build.make_upomdp(task.make_scene(task.scenes(False)[TRAINING_SCENE]), 1, 0))


def write(frames: Sequence[np.ndarray], levels: Sequence[np.ndarray], path: Path) -> None:
    """Write the animation; the stages of training pass once while it plays."""
    pictures = [
        Image.fromarray(np.hstack([frame, levels[k * len(levels) // len(frames)]])) for k, frame in enumerate(frames)
    ]
    palette = shared_palette(pictures)
    joined = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    joined[0].save(path, save_all=True, append_images=joined[1:], duration=MILLISECONDS, loop=0, optimize=True)


def shared_palette(pictures: Sequence[Image.Image]) -> Image.Image:
    """Return an image with one palette for all pictures; with separate palettes, static parts would flicker."""
    some = pictures[:: max(1, len(pictures) // SAMPLED)]
    strip = Image.new("RGB", (some[0].width, some[0].height * len(some)))
    for k, picture in enumerate(some):
        strip.paste(picture, (0, k * some[0].height))
    return strip.quantize(COLORS)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("runs/hero"), help="folder of the run")
    parser.add_argument("--scene", default=TRAINING_SCENE)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="of the episodes")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    typed = parser.parse_args()
    run = train(typed.out)
    painter = painter_of(run)
    frames = matches(run, typed.scene, typed.seeds, painter.bounds)
    write(frames, densities(run, painter, frames[0].shape[0]), typed.picture)
    print(f"{typed.picture}: {len(frames)} frames, {typed.picture.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
