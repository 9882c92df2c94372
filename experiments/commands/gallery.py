"""`regista gallery`: the levels of a run as a page for a browser: a point of the map leads to its card and its replay.

    regista gallery runs/paired
    regista gallery runs/paired --out levels.html --replays 50

Read next: `pictures.gallery`, what the page is made of; `run.replays`, what is played again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import positional
from regista.experiments.run.errors import CommandError, UsageError, read_from
from regista.experiments.run.folder import RunFolder
from ued.config import Checked, setting

DESCRIPTION = (
    "Make a page of a run's levels for a browser: where they lie, what came of them, and how they were played."
)


@dataclass(frozen=True)
class GalleryConfig(Checked):
    """What is typed after `regista gallery`."""

    run: str = positional("a run folder", default="")
    out: Path | None = setting(None, "the page (default gallery.html in the run folder)")
    levels: int = setting(
        3_000, "levels on the map, spread over the updates; those with replays come on top", ">=1", most=100_000
    )
    replays: int = setting(150, "levels with replays, spread over the updates", ">=0", most=10_000)


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(GalleryConfig(), argv, "gallery", DESCRIPTION)
    if not config.run:
        raise UsageError("gallery needs a run folder")
    run = RunFolder.open(Path(config.run))
    if not run.levels.path.exists():
        raise CommandError(f"{run.path} has no levels.csv: nothing has been played yet")
    from regista.experiments.pictures.gallery import make_page

    path = config.out or run.path / "gallery.html"
    program = build.load_scenes(run.config)[build.TRAINING_SCENE]
    with read_from(f"the tables of {run.path} are of other environments than it has now, or"):
        made = make_page(run, program, path, config.levels, config.replays)
    print(f"{path}: {made.levels} of {made.played} levels, {made.replays} with replays")
    if made.otherwise:
        print(f"{made.otherwise} came out otherwise than they were recorded: the environment has changed since")
    return 0
