"""`regista replay`: play a recorded match again, bit for bit, and make a film of it if wanted.

    regista replay match.npz
    regista replay match.npz --video match.gif
    regista replay demos/records/0000.npz --match 3

Read next: `regista.envs.football.replay`, what a record is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from regista.experiments.commands.play import check_film_of, film
from regista.experiments.run import arguments
from regista.experiments.run.arguments import positional
from regista.experiments.run.errors import CommandError, UsageError
from ued.config import Checked, setting

DESCRIPTION = "Play a recorded match again, and check that it comes out as it did."


@dataclass(frozen=True)
class ReplayConfig(Checked):
    """What is typed after `regista replay`."""

    record: str = positional("a record: a .npz file of regista play, or of regista.envs.football.replay", default="")
    match: int = setting(0, "which of the matches of the record is shown", ">=0", most=10**9)
    video: Path | None = setting(None, "write a film: .gif, .webp, or .mp4 with imageio-ffmpeg")
    speed: float = setting(1.0, "of the film, times life", ">0", most=1_000)


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(ReplayConfig(), argv, "replay", DESCRIPTION)
    if not config.record:
        raise UsageError("replay needs a record: a .npz file")
    check_film_of(config.video)
    from regista.envs.football.replay import RecordError, load_record, replay

    try:
        record = load_record(config.record)
        if config.match >= len(record.last):
            raise UsageError(f"--match must be below {len(record.last)}, the matches of {config.record}")
        moments = [matches[config.match] for matches in replay(record, endings=True)]
    except RecordError as error:
        raise CommandError(str(error)) from error
    if record.lengths is not None:
        moments = moments[: record.lengths[config.match] + 1]
    left, right = moments[-1]["score"]
    matches = f", match {config.match} of {len(record.last)}" if len(record.last) > 1 else ""
    print(f"{len(moments) - 1} steps came out as they were recorded{matches}; {left} : {right} in the end")
    if config.video:
        film(config.video, moments, config.speed)
    return 0
