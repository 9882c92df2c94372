"""`regista COMMAND ...`, also as `python -m regista COMMAND ...`.

Each command is a module with a frozen configuration and a `main(argv) -> int`; it is imported when it is called, so
that `--help` does not wait for torch. Read next: `commands.train`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from regista.experiments.run import trust
from regista.experiments.run.errors import UsageError, nearest, run_command
from regista.experiments.run.signals import PARENT, end_with

COMMANDS = {
    "train": "train students on a minigame, with a curriculum or without",
    "evaluate": "play trained runs on test scenes, with intervals",
    "transfer": "play trained runs in Google Research Football, too, and tell what carries over",
    "compare": "train several methods on a minigame over seeds, evaluate, tabulate and draw",
    "characterise": "tell how many random levels of a game are solved, as a student learns",
    "gallery": "make a page of the levels of a run: a map, and a card, a scene and a replay of each",
    "list": "show the minigames, what is measured on them elsewhere, and their test scenes",
    "inspect": "show a program: its free parameters, its text as tokens or nodes, scenes drawn from it",
    "probe": "compare methods on levels whose answer is known, in minutes",
    "play": "play one match, and write a film or a record of it",
    "demonstrate": "keep episodes of a program or of a student, for others to learn from",
    "clone": "let a student learn to do what was done in demonstrations",
    "replay": "play a recorded match again, bit for bit",
    "benchmark": "measure the speed of the simulator and of training on this machine",
}
MOVED = {  # former commands, and what does the same
    "study": "python -m lab.studies, in a checkout",
}

USAGE = """\
usage: regista COMMAND [flags]

Curriculum learning for reinforcement learning, in football.

commands:
{commands}

Every command takes --help; --version tells the version; --debug shows the whole traceback of an error; --trust runs the
Python file of a task that only a run folder names.
Begin with: regista compare 1v1Restricted --out demo
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and give its exit code: 0, 1 for an error, 2 for wrong usage, 128 + n for signal n."""
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # before torch starts threads; see `regista.kernels.jit`
    parent = os.environ.pop(PARENT, None)
    if parent is not None:
        end_with(int(parent))
    return run_command(_dispatch, sys.argv[1:] if argv is None else argv, for_good=argv is None)


def _dispatch(words: list[str]) -> int:
    if words[:1] == ["--version"]:
        from importlib.metadata import version

        print(f"regista {version('regista')}")
        return 0
    if not words or words[0] in ("--help", "-h", "help"):
        lines = [f"  {name:<14}{text}" for name, text in COMMANDS.items()]
        print(USAGE.format(commands="\n".join(lines)), end="")
        return 0 if words else 2
    name = words[0]
    if name in MOVED:
        raise UsageError(f"the command {name} has moved: {MOVED[name]}")
    if name not in COMMANDS:
        kind = "flag" if name.startswith("-") else "command"
        raise UsageError(f"unknown {kind} {name}{nearest(name, COMMANDS)}; see regista --help")
    with trust.of_command(words) as trusted:
        return import_module(f"regista.experiments.commands.{name}").main(trusted[1:])


if __name__ == "__main__":
    sys.exit(main())
