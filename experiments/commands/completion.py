"""`regista completion`: print a script that completes commands, flags, games and methods in a shell.

    eval "$(regista completion bash)"             # in ~/.bashrc
    eval "$(regista completion zsh)"              # in ~/.zshrc, after compinit
    regista completion fish | source              # in ~/.config/fish/config.fish

The script contains all words, so that a shell never waits for Python. Read next: `run.arguments`, the flags.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import NamedTuple

from regista.experiments.run import arguments
from regista.experiments.run.arguments import positional
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.command_names import COMMANDS
from regista.experiments.run.errors import UsageError, nearest
from ued.config import Checked
from ued.methods import METHODS

DESCRIPTION = 'Print a script that completes commands, flags, games and methods: eval "$(regista completion bash)".'
SHELLS = ("bash", "zsh", "fish")
OF_GAMES = ("train", "compare", "play", "inspect", "list", "demonstrate")  # commands whose first word is a game
OF_METHODS = ("--method", "--methods")

BASH = """\
_regista() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
  local command="${{COMP_WORDS[1]}}" words=""
  if [ "$COMP_CWORD" -eq 1 ]; then
    words="{commands} --help --version"
  else
    case "$command $before" in
{values}
    esac
    if [ -z "$words" ]; then
      case "$command $current" in
{flags}
{games}
      esac
    fi
  fi
  COMPREPLY=( $(compgen -W "$words" -- "$current") )
}}
complete -o default -o bashdefault -F _regista regista
"""
ZSH = "autoload -U +X bashcompinit && bashcompinit\n"


@dataclass(frozen=True)
class CompletionConfig(Checked):
    """Arguments of `regista completion`."""

    shell: str = positional(f"shell: {', '.join(SHELLS)}", default="")


class Words(NamedTuple):
    """Completions of a command: its flags, and the values of flags with a fixed list."""

    flags: list[str]
    values: dict[str, list[str]]


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    shell = arguments.parse(CompletionConfig(), argv, "completion", DESCRIPTION).shell
    if shell not in SHELLS:
        meant = nearest(shell, SHELLS) if shell else ""
        raise UsageError(
            f"completion needs the name of a shell, {', '.join(SHELLS)}{f', got {shell!r}' * bool(shell)}{meant}"
        )
    known = words_of_commands()
    print(fish(known, games()) if shell == "fish" else ZSH * (shell == "zsh") + bash(known, games()), end="")
    return 0


def games() -> list[str]:
    """Return the names of minigames and built-in tasks."""
    from regista.minigames.suites import ALL

    return [*ALL, *BUILT_IN]


def words_of_commands() -> dict[str, Words]:
    """Return the flags of every command, and their values."""
    found = {}
    for name in COMMANDS:
        parser = arguments.parser_of(import_module(f"regista.experiments.commands.{name}").main)
        values = {
            flag: list(map(str, action.choices))
            for action in parser._actions
            if action.choices
            for flag in action.option_strings
        }
        flags = [flag for action in parser._actions for flag in action.option_strings if flag.startswith("--")]
        values |= {flag: list(METHODS) for flag in OF_METHODS if flag in flags}
        found[name] = Words(flags, values)
    found["completion"].values["completion"] = list(SHELLS)  # after the command itself
    return found


def bash(known: dict[str, Words], games: Sequence[str]) -> str:
    """Return the script for bash, which zsh also reads."""
    values = [
        f'      "{name} {flag}") words="{" ".join(words)}" ;;'
        for name, entry in known.items()
        for flag, words in entry.values.items()
    ]
    flags = [f'        "{name} -"*) words="{" ".join(entry.flags)}" ;;' for name, entry in known.items()]
    places = "|".join(f'"{name} "*' for name in OF_GAMES)
    named = f'        {places}) words="{" ".join(games)}" ;;'
    return BASH.format(commands=" ".join(known), values="\n".join(values), flags="\n".join(flags), games=named)


def fish(known: dict[str, Words], games: Sequence[str]) -> str:
    """Return the script for fish."""
    lines = [f"complete -c regista -n __fish_use_subcommand -a {name} -d {_quoted(COMMANDS[name])}" for name in known]
    for name, entry in known.items():
        of_command = f"complete -c regista -n '__fish_seen_subcommand_from {name}'"
        for flag in entry.flags:
            words = f" -xa {_quoted(' '.join(entry.values[flag]))}" if flag in entry.values else ""
            lines.append(f"{of_command} -l {flag.removeprefix('--')}{words}")
        if name in OF_GAMES:
            lines.append(f"{of_command} -a {_quoted(' '.join(games))}")
    lines.append(f"complete -c regista -n '__fish_seen_subcommand_from completion' -xa {_quoted(' '.join(SHELLS))}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("$", "\\$") + '"'
