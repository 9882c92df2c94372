"""`regista completion`: print a script that completes commands, flags, games and methods in a shell.

    eval "$(regista completion bash)"             # in ~/.bashrc
    eval "$(regista completion zsh)"              # in ~/.zshrc, after compinit
    regista completion fish | source              # in ~/.config/fish/config.fish

The script contains all words, so completion does not start Python. Read next: `run.arguments`, the flags.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import NamedTuple

from regista.experiments.run import arguments, shipped
from regista.experiments.run.arguments import positional
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.command_names import COMMANDS
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.players import SCRIPTED
from ued.config import Checked
from ued.methods import METHODS

DESCRIPTION = 'Print a script that completes commands, flags, games and methods: eval "$(regista completion bash)".'
SHELLS = ("bash", "zsh", "fish")
OF_GAMES = ("train", "compare", "play", "inspect", "list", "demonstrate")  # commands whose first word is a game
OF_METHODS = ("--method", "--methods")

BASH = """\
_regista() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}"
  local command="${{COMP_WORDS[1]}}" words="" flag="" taken="" k
  for (( k = COMP_CWORD - 1; k > 1; k-- )); do
    case "${{COMP_WORDS[k]}}" in -*) flag="${{COMP_WORDS[k]}}"; break ;; esac
  done
  case "$command $flag $current" in
    *" -"*" -"*) ;;
{several}
  esac
  if [ "$COMP_CWORD" -eq 1 ]; then
    words="{commands} --help --version"
  else
    case "$command $before" in
{values}
    esac
    if [ -z "$words$taken" ]; then
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
    """Completions of a command.

    Attributes:
        flags: all flags of the command.
        values: known values by flag.
        several: flags that take several values.
        open: flags that also take other values, such as a file, which the shell completes.
    """

    flags: list[str]
    values: dict[str, list[str]]
    several: list[str]
    open: list[str]


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


def scenes() -> list[str]:
    """Return the names of test scenes of minigames and mazes."""
    from regista.envs.maze.named_mazes import LARGE_MAZES, TEST_MAZES
    from regista.minigames.suites import ALL, slug

    football = [slug(label) for game in ALL.values() for label, _ in (*game.tests, *game.held_out)]
    return list(dict.fromkeys([*football, *TEST_MAZES, *LARGE_MAZES]))


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
        topics = getattr(parser, "topics", {})
        values |= {"--help": [*topics, "all"]} if topics else {}
        several = [flag for action in parser._actions if action.nargs == "+" for flag in action.option_strings]
        taking = [flag for action in parser._actions if action.nargs != 0 for flag in action.option_strings]
        opened = [flag for flag in taking if flag not in values]
        values |= {flag: list(words) for flag, words in getattr(parser, "offered", {}).items() if words}
        found[name] = Words(flags, values, several, opened)
    found["play"].values.update({"--player": [*SCRIPTED, *shipped.names()], "--scene": scenes()})
    found["clone"].values["--minigame"] = games()
    found["completion"].values["completion"] = list(SHELLS)  # after the command itself
    return found


def bash(known: dict[str, Words], games: Sequence[str]) -> str:
    """Return the script for bash, which zsh also reads."""
    values = [
        f'      "{name} {flag}") words="{" ".join(words)}" ;;'
        for name, entry in known.items()
        for flag, words in entry.values.items()
    ]
    several = [f'    "{name} {flag} "*) before="{flag}" ;;' for name, entry in known.items() for flag in entry.several]
    for name, entry in known.items():
        without = "|".join(f'"{name} {flag}"' for flag in entry.open if flag not in entry.values)
        values += [f"      {without}) taken=1 ;;"] * bool(without)
    flags = [f'        "{name} -"*) words="{" ".join(entry.flags)}" ;;' for name, entry in known.items()]
    places = "|".join(f'"{name} "*' for name in OF_GAMES)
    named = f'        {places}) words="{" ".join(games)}" ;;\n'
    named += f'        "evaluate "*) words="{" ".join(shipped.names())}" ;;'
    lists = {key: "\n".join(lines) for key, lines in (("values", values), ("flags", flags), ("several", several))}
    return BASH.format(commands=" ".join(known), games=named, **lists)


def fish(known: dict[str, Words], games: Sequence[str]) -> str:
    """Return the script for fish."""
    lines = [f"complete -c regista -n __fish_use_subcommand -a {name} -d {_quoted(COMMANDS[name])}" for name in known]
    for name, entry in known.items():
        of_command = f"complete -c regista -n '__fish_seen_subcommand_from {name}'"
        for flag in entry.flags:
            kind = "r" if flag in entry.open else "x"
            words = f" -{kind}a {_quoted(' '.join(entry.values[flag]))}" if flag in entry.values else ""
            words = words or " -r" * (flag in entry.open)
            lines.append(f"{of_command} -l {flag.removeprefix('--')}{words}")
        if name in OF_GAMES:
            lines.append(f"{of_command} -a {_quoted(' '.join(games))}")
        if name == "evaluate":
            lines.append(f"{of_command} -a {_quoted(' '.join(shipped.names()))}")
    lines.append(f"complete -c regista -n '__fish_seen_subcommand_from completion' -xa {_quoted(' '.join(SHELLS))}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("$", "\\$") + '"'
