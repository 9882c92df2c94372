"""Mistyped command lines of commands that launch runs: refused in one sentence, or their runs are listed.

`--launcher commands` comes last, so nothing is trained. Read next:
`tests/attacks/files.py`, which gives folders to commands.
"""

from __future__ import annotations

import io
import random
import re
import shutil
import sys
import time
from contextlib import redirect_stderr, redirect_stdout, suppress
from functools import cache
from pathlib import Path

from regista.experiments.__main__ import main
from tests.attacks.files import TASK, quietly

LISTED, REFUSED = "ran", "refused in a sentence"
SECONDS = 5.0  # of processor time, at most
LAST = ["--launcher", "commands"]
COMMANDS = {
    "compare": ["compare", TASK, "--methods", "dr", "plr", "--seeds", "2"],
    "compare from": ["compare", TASK, "--from", "nowhere", "--seeds", "1"],
}
MANY = {"--seeds"}  # excluded: all of these runs are listed, each with its folder
SMALL = ("-1", "0", "1", "2", "3.5", "nan", "-inf", "1e999", "٣")
NUMBERS = ("-1", "0", "1", "2", "3.5", "nan", "inf", "-inf", "1e999", "1_000", "9" * 30, "1e6", "0x10", "٣")
WORDS = (
    "",
    " ",
    "x",
    "é",
    "\ud800",
    "[]",
    "--",
    "-",
    "none",
    "local,ray",
    "dr",
    "plr dr",
    "true",
    "/dev/null",
    "..",
    "a\0b",
)


@cache
def flags(name: str) -> list[str]:
    """Return the flags of a command from its help."""
    said = [help_of([COMMANDS[name][0], "--help", *topic]) for topic in ([], ["ppo"], ["all"])]
    return sorted(set(re.findall(r"--[a-z][\w.-]+", "\n".join(said))) - MANY)


def help_of(words: list[str]) -> str:
    """Return a page of help."""
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(io.StringIO()), suppress(SystemExit):
        main(words)
    return out.getvalue()


def typed_line(rng: random.Random, out: Path) -> list[str]:
    """Return a command line with a few invalid flags or values."""
    name = rng.choice(list(COMMANDS))
    words = [*COMMANDS[name]]
    for _ in range(rng.choice((1, 1, 2, 3))):
        kind = rng.random()
        if kind < 0.7:
            words += [rng.choice(flags(name)), rng.choice((*NUMBERS, *NUMBERS, *WORDS))]
        elif kind < 0.85:
            words[rng.randrange(1, len(words))] = rng.choice((*SMALL, *WORDS))
        else:
            del words[rng.randrange(1, len(words))]
    return [*words, "--out", str(out), *LAST]


def attack(count: int, seed: int, folder: Path) -> dict[str, int]:
    """Try `count` command lines; return the count of each outcome. Raises AssertionError for any harm."""
    counts = dict.fromkeys((LISTED, REFUSED), 0)
    for index in range(count):
        words = typed_line(random.Random(f"{seed} {index}"), folder / "out")
        shutil.rmtree(folder / "out", ignore_errors=True)
        began = time.process_time()
        what = f"line {index} of round {seed}: {words}"
        try:
            code, said = quietly(words)
        except SystemExit as end:  # --help
            code, said = int(end.code or 0), ""
        except BaseException as fault:
            raise AssertionError(f"{what}: {type(fault).__name__}: {fault}") from fault
        spent = time.process_time() - began
        assert spent < SECONDS, f"{what}: took {spent:.1f} s"
        told = any(line.startswith("regista: ") for line in said.splitlines())
        assert code in (0, 1, 2) and (code == 0 or told), f"{what}: exit code {code}: {said[-1_000:]}"
        assert "Traceback" not in said, f"{what}: {said[-1_000:]}"
        counts[LISTED if code == 0 else REFUSED] += 1
    return counts


if __name__ == "__main__":
    print(attack(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])))
