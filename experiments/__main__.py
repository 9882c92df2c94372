"""`regista COMMAND ...`, also as `python -m regista COMMAND ...`.

Each command is a module with a frozen configuration and a `main(argv) -> int`. It is imported on use, so that `--help`
does not wait for torch. Read next: `commands.train`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module

from regista.experiments.run import trust
from regista.experiments.run.command_names import COMMANDS
from regista.experiments.run.errors import UsageError, nearest, run_command
from regista.experiments.run.launch.signals import PARENT, end_with

MOVED = {  # removed commands and their replacements
    "characterise": "regista list --solved GAME",
    "gallery": "regista evaluate RUN --gallery",
    "replay": "regista play --replay RECORD",
    "probe": "regista compare ued.probes:frontier",
    "study": "python -m lab.studies, in a checkout",
}

USAGE = """\
usage: regista COMMAND [flags]

A curriculum-learning toolkit for reinforcement learning: train agents on levels
that a method of unsupervised environment design (UED) chooses, and compare
methods, in your own Gymnasium environments, in mazes and in football.

commands:
{commands}

flags of every command:
  --help        the arguments of the command; --help all: every flag
  --debug       the traceback of an error
  --trust       run the Python file that a run folder names
  --version     the version, without a command

begin with:
  regista play --player shipped:maze --video maze.gif
  regista train maze --method plr --total-env-steps 500_000
  regista evaluate runs/maze-plr-0
  regista play --player runs/maze-plr-0 --scene Labyrinth --video policy.gif
  regista compare 1v1Restricted --methods dr paired
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code: 0, 1 for an error, 2 for wrong usage, 128 + n for signal n."""
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
