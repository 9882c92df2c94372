"""`regista COMMAND ...`, also as `python -m experiments COMMAND ...`.

Each command is a module with a frozen configuration and a `main(argv) -> int`; it is imported when it is called, so
that `--help` does not wait for torch. Read next: `commands.train`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from experiments.run.errors import CommandError, UsageError, nearest

COMMANDS = {
    "train": "train students on a minigame, with a curriculum or without",
    "evaluate": "play trained runs on test scenes, with intervals",
    "compare": "train several methods on a minigame over seeds, evaluate, tabulate and draw",
    "inspect": "show a program: its free parameters, its text as tokens or nodes, scenes drawn from it",
    "probe": "compare methods on levels whose answer is known, in minutes",
    "play": "play one match, and write a film or a record of it",
    "replay": "play a recorded match again, bit for bit",
    "benchmark": "measure the speed of the simulator, of training and of the language",
}

USAGE = """\
usage: regista COMMAND [flags]

Curriculum learning for reinforcement learning, in football.

commands:
{commands}

Every command takes --help; --debug shows the whole traceback of an error.
Begin with: regista compare 1v1Restricted --out demo
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and give its exit code: 0, 1 for an error, 2 for wrong usage, 128 + n for signal n."""
    os.environ.setdefault(
        "OMP_WAIT_POLICY", "passive"
    )  # before torch starts its threads; see `scenic_lite.kernels.jit`
    return run_command(_dispatch, sys.argv[1:] if argv is None else argv)


def run_command(command: Callable[[list[str]], int], argv: Sequence[str]) -> int:
    """Give the exit code of `command(argv)`; an error that is the user's business is one sentence."""
    words = list(argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    try:
        return command(words)
    except BrokenPipeError:  # `regista inspect ... | head`
        sys.stderr.close()
        return 1
    except Exception as error:
        code = _exit_code(error)
        if debug or code is None:
            raise
        # An error in a program begins with its place, file:line:column, where editors look for it.
        print(error if getattr(error, "place", None) else f"regista: {error}", file=sys.stderr)
        return code


def _dispatch(words: list[str]) -> int:
    if not words or words[0] in ("--help", "-h", "help"):
        lines = [f"  {name:<11}{text}" for name, text in COMMANDS.items()]
        print(USAGE.format(commands="\n".join(lines)), end="")
        return 0 if words else 2
    name = words[0]
    if name not in COMMANDS:
        kind = "flag" if name.startswith("-") else "command"
        raise UsageError(f"unknown {kind} {name}{nearest(name, COMMANDS)}; see regista --help")
    return import_module(f"experiments.commands.{name}").main(words[1:])


def _exit_code(error: Exception) -> int | None:
    """Give the exit code of an error that is the user's business, None for one that is ours."""
    if isinstance(error, CommandError):
        return error.exit_code
    if isinstance(error, OSError) and error.filename is not None:
        return 1
    # Named, not imported: neither the language nor the learning core is loaded for the sake of an error.
    ours = {"ScenicError", "ThetaError", "CastingError", "CheckpointError", "FloatingPointError"}
    return 1 if ours & {kind.__name__ for kind in type(error).__mro__} else None


if __name__ == "__main__":
    sys.exit(main())
