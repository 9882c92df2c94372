"""What a comparison leaves for a page of results: `page.md` in its folder, and the page that is made of such folders.

    regista compare 1v1Free --methods dr paired --seeds 5 --out runs/results
    python -m regista.experiments.pictures.results_page runs/results runs/probe

The second command puts each folder's page.md between two marks of RESULTS.md that name the folder, in the place of what
was there, or at the end if nothing was; its pictures are copied to experiments/gallery. The rest of the page stays.
Read next: `run.report`, the tables.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from regista.envs.football.version import UNNUMBERED
from regista.experiments.run import arguments, versions
from regista.experiments.run.arguments import positional
from regista.experiments.run.errors import CommandError, UsageError, run_command
from regista.experiments.run.report import write_text
from regista.experiments.run.table import cannot_write
from ued.config import setting

DESCRIPTION = "Put the tables and pictures of comparisons into a page of results."
PAGE = "page.md"
WIDEST, COLOURS = 1240, 256  # of pictures on the page
PICTURE = re.compile(r"!\[([^]]*)\]\(([^)/]+)\)")  # one in the folder itself
VERSION = "<!-- simulator {} -->\n"  # the first line of a page: on which version its numbers were measured


@dataclass(frozen=True)
class PageConfig:
    """What is typed after `python -m regista.experiments.pictures.results_page`."""

    folders: tuple[Path, ...] = positional("folders of comparisons", default=())
    into: Path = setting(Path("RESULTS.md"), "the page; it is made if there is none")
    pictures: Path = setting(Path("experiments/gallery"), "folder for the pictures, named after the comparisons'")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    config = arguments.parse(PageConfig(), argv, "results_page", DESCRIPTION)
    if not config.folders:
        raise UsageError(
            "results_page needs at least one folder that regista compare has written, such as runs/results"
        )
    page = config.into.read_text() if config.into.exists() else "# Results\n"
    for folder in config.folders:
        page = put(page, folder.resolve().name, section(folder, config.pictures, config.into.parent))
    write_text(config.into, page)
    print(f"{config.into}: {', '.join(map(str, config.folders))}")
    return 0


def write_page(
    folder: Path,
    heading: str,
    command: Sequence[str],
    tables: str,
    pictures: dict[str, str],
    simulator: int | None = None,
) -> None:
    """Write page.md: what was compared, the command that did it, the tables, and pictures by caption.

    `simulator` is the version of the simulator on which the numbers were measured; None: on none of ours.
    """
    shown = "\n\n".join(f"![{caption}]({name})" for caption, name in pictures.items())
    call = f"```sh\nregista {shlex.join(command)}\n```"
    version = VERSION.format(versions.spelled(simulator))
    write_text(folder / PAGE, f"{version}## {heading}\n\n{call}\n\n{tables}\n\n{shown}\n")


def section(folder: Path, pictures: Path, base: Path) -> str:
    """Return a folder's page.md with its pictures copied to `pictures`, and linked there from `base`.

    Raises `CommandError` where its numbers are of another version of the simulator than this.
    """
    if not (folder / PAGE).exists():
        raise CommandError(f"{folder} has no {PAGE}: regista compare writes it when all runs are finished")
    name, text = folder.resolve().name, (folder / PAGE).read_text()
    stated = re.match(VERSION.format(r"(\d{1,9}|none)"), text)
    version = stated[1] if stated else UNNUMBERED
    if version != versions.NO_SIMULATOR:
        versions.check_present(int(version), f"{folder / PAGE} was measured on", "it cannot be published")

    def copied(link: re.Match) -> str:
        target = pictures / f"{name}_{link[2]}"
        try:
            pictures.mkdir(parents=True, exist_ok=True)
            _shrink(folder / link[2], target)
        except OSError as error:
            raise cannot_write(target, error) from error
        return f"![{link[1]}]({Path(os.path.relpath(target, base)).as_posix()})"

    return PICTURE.sub(copied, text)


def _shrink(picture: Path, target: Path) -> None:
    """Save a picture as small as a page needs it: at most WIDEST pixels wide, in COLOURS colours."""
    from PIL import Image

    with Image.open(picture) as image:
        height = round(image.height * min(WIDEST / image.width, 1.0))
        small = image.convert("RGB").resize((min(image.width, WIDEST), height), Image.Resampling.LANCZOS)
        few = small.quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)  # keeps rare colours
        few.save(target, optimize=True)


def put(page: str, name: str, text: str) -> str:
    """Return a page with `text` between the marks of `name`, in the place of what was there or at the end."""
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    block = f"{begin}\n{text.strip()}\n{end}\n"
    if begin not in page:
        return f"{page.rstrip()}\n\n{block}"
    before, _, rest = page.partition(begin)
    _, closed, after = rest.partition(end)
    if not closed:
        raise CommandError(f"the page has the mark '{begin}' without '{end}'")
    return before + block + after.removeprefix("\n")


if __name__ == "__main__":
    sys.exit(run_command(main, sys.argv[1:]))
