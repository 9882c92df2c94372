"""The command line, derived from frozen dataclasses: one flag per field, the help text on the field.

A field `num_envs: int` becomes `--num-envs N`. A nested configuration becomes a group of flags: with `prefix=""` its
fields are plain flags (`--learning-rate`), otherwise its name precedes them (`--paired.dr-fraction`). Only given
flags change the base configuration, so a preset or a resumed run can serve as base. `--help` is one page; groups
with topics have their own pages, `--help TOPIC`. Read next: `run.config`.
"""

from __future__ import annotations

import argparse
import dataclasses
import shutil
import textwrap
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, NoReturn, TypeVar

from regista.experiments.run.errors import UsageError, nearest
from ued.config import complaint, hints_of

Config = TypeVar("Config")


def positional(help: str, default: Any = dataclasses.MISSING) -> Any:
    """Return a dataclass field for a positional argument: `regista train 1v1Free`."""
    return field(default=default, metadata={"help": help, "positional": True})


def group(
    factory: Callable[[], Any],
    help: str,
    prefix: str = "",
    without: tuple[str, ...] = (),
    topics: Mapping[str, str] | None = None,
) -> Any:
    """Return a dataclass field that holds a nested configuration: a titled group of flags, named `prefix` + field.

    Fields in `without` get no flag. A group with `topics`, each with its title, is shown by `--help TOPIC` instead of
    `--help`.
    """
    about = {"help": help, "prefix": prefix, "without": without, "topics": topics or {}}
    return field(default_factory=factory, metadata=about)


def option(default: Any, help: str, short: str = "", repeated: bool = False, metavar: str = "") -> Any:
    """Return a dataclass field with an additional short flag, or a tuple field whose flag may be repeated."""
    about = {"help": help, "short": short, "repeated": repeated, "metavar": metavar}
    return field(default=default, metadata=about)


def parse(base: Config, argv: Sequence[str], command: str, description: str) -> Config:
    """Return `base` with the changes in `argv`. Raises `UsageError` for unknown flags and values of the wrong type."""
    typed = typed_settings(base, argv, command, description)
    return replace_paths(base, typed)


# Alternative base configurations by case, a phrase such as "with --preset thesis"; see `_stated`.
Others = Mapping[str, Sequence[Any]]


LISTING = "--list-flags"  # the only argument that `parser_of` passes


class Listed(Exception):
    """Carries the parser of a command to `parser_of`."""


def parser_of(main: Callable[[Sequence[str]], Any]) -> argparse.ArgumentParser:
    """Return the parser of a command's `main`, which must start with `typed_settings`; nothing else of it runs."""
    try:
        main([LISTING])
    except Listed as found:
        return found.args[0]
    raise TypeError(f"{main.__module__} must read its command line by typed_settings")


def typed_settings(
    base: Any, argv: Sequence[str], command: str, description: str, others: Others | None = None
) -> dict[str, Any]:
    """Return the given values by path of the field (`ppo.learning_rate`).

    The help states the defaults of `base`, and those of `others` if they differ. `command` is one of `regista`, or
    `python -m MODULE`.
    """
    parser = _Parser(
        prog=command if command.startswith("python ") else f"regista {command}",
        description=description,
        formatter_class=_Help,
        allow_abbrev=False,
        add_help=False,
    )
    showing = parser.add_argument("--help", "-h", action=_ShowHelp)
    flags = ["--help"]
    _add(parser, parser, base, _Place("", "", others or {}), flags)
    if parser.topics:
        showing.nargs, showing.help = "?", "show this page or the page of a topic, and exit"
    if list(argv) == [LISTING]:
        raise Listed(parser)
    typed, unknown = parser.parse_known_args(list(argv))
    if unknown:
        raise UsageError(_unknown(unknown[0], flags))
    return vars(typed)


def replace_paths(config: Config, values: dict[str, Any]) -> Config:
    """Return `config` with the values at these dotted paths replaced."""
    changes: dict[str, Any] = {}
    nested: dict[str, dict[str, Any]] = {}  # replaced together, since checks of a part may involve several
    for path, value in values.items():
        head, _, rest = path.partition(".")
        if rest:
            nested.setdefault(head, {})[rest] = value
        else:
            changes[head] = value
    for head, inner in nested.items():
        changes[head] = replace_paths(changes.get(head, getattr(config, head)), inner)
    try:
        return dataclasses.replace(config, **changes)  # type: ignore[type-var]
    except ValueError as error:  # the configuration's own checks
        raise UsageError(str(error)) from error


def flag_name(name: str, prefix: str = "") -> str:
    """Return the flag of a field: `num_envs` is `--num-envs`, and `from_` (a Python keyword) is `--from`."""
    return f"--{prefix}{name.rstrip('_')}".replace("_", "-")


# ---------------------------------------------------------------- one flag per field


class _Place(NamedTuple):
    """Position in nested configurations.

    `path` is that of the fields, `prefix` that of the flags. `others` is the same part of alternative configurations,
    `without` lists fields without a flag, and `topics` are help topics.
    """

    path: str
    prefix: str
    others: Others
    without: tuple[str, ...] = ()
    topics: Mapping[str, str] = {}


def _add(parser: _Parser, container: Any, config: Any, place: _Place, flags: list[str]) -> None:
    """Add a flag for every field of `config` to `container` and `flags`, a group for every nested configuration."""
    kind: Any = type(config)
    hints = hints_of(kind)
    for item in fields(config):
        value, about = getattr(config, item.name), item.metadata
        path, help_text = place.path + item.name, about.get("help", "")
        if item.name in place.without:
            continue
        if is_dataclass(value):
            nested = parser.add_argument_group(help_text or item.name)
            prefix = place.prefix + about.get("prefix", f"{item.name}.")
            topics = about.get("topics") or place.topics
            for topic, title in topics.items():
                parser.topics.setdefault(topic, []).append(nested)
                parser.titles.setdefault(topic, title)
            others = {case: _part(bases, item.name) for case, bases in place.others.items()}
            _add(parser, nested, value, _Place(f"{path}.", prefix, others, about.get("without", ()), topics), flags)
        elif about.get("positional"):
            _add_positional(parser, item, hints[item.name], path)
            parser.words += (item.name.upper(),)
        else:
            help_text += _stated(value, item.name, place.others)
            names = [flag_name(item.name, place.prefix), *filter(None, [about.get("short")])]
            options = _options(hints[item.name], about)
            options |= {"metavar": about["metavar"]} if about.get("metavar") else {}
            added = container.add_argument(
                *names, dest=path, default=argparse.SUPPRESS, help=help_text.strip(), **options
            )
            flags += added.option_strings
            parser.offered |= dict.fromkeys(added.option_strings, about.get("names") or about.get("words") or ())


def _part(bases: Sequence[Any], name: str) -> list[Any]:
    """Return the values of a field in the configurations that have this field."""
    return [getattr(base, name) for base in bases if hasattr(base, name)]


def _stated(value: Any, name: str, others: Others) -> str:
    """Return the default of a field in parentheses, with the cases in which it differs."""
    cases: dict[str, list[str]] = {}  # cases by differing default
    for case, bases in others.items():
        differing = [_spell(other) for other in _part(bases, name) if other is not None and other != value]
        if differing:
            cases.setdefault(" or ".join(dict.fromkeys(differing)), []).append(case)
    stated = [] if value is None else [f"default {_spell(value)}"]
    stated += [f"{values} {' or '.join(words)}" for values, words in cases.items()]
    return f" ({'; '.join(stated)})" if stated else ""


def _add_positional(container: Any, item: dataclasses.Field, hint: Any, path: str) -> None:
    many = typing.get_origin(hint) is tuple
    convert, _ = _converter(typing.get_args(hint)[0] if many else hint)
    container.add_argument(
        path,
        metavar=item.name.upper(),
        type=convert,
        nargs="*" if many else "?",
        action=_Collect if many else "store",
        default=argparse.SUPPRESS,
        help=item.metadata["help"],
    )


def _options(hint: Any, about: Mapping[str, Any]) -> dict[str, Any]:
    """Return the argparse options of a field with this type and metadata."""
    hint = _without_none(hint)
    if hint is bool:
        return {"action": argparse.BooleanOptionalAction}
    if typing.get_origin(hint) is Literal:
        return {"choices": typing.get_args(hint)}
    if typing.get_origin(hint) is tuple:
        part = typing.get_args(hint)[0]
        convert, name = _converter(part)
        several = {"action": _Append} if about.get("repeated") else {"nargs": "+", "action": _Collect}
        if typing.get_origin(part) is Literal:
            return {"choices": typing.get_args(part), **several}
        return {"type": _bounded(convert, about), "metavar": name, **several}
    convert, name = _converter(hint)
    return {"type": _bounded(convert, about), "metavar": name}


def _bounded(convert: Callable[[str], Any], about: Mapping[str, Any]) -> Callable[[str], Any]:
    """Return a function that parses a value and rejects invalid ones; argparse adds the flag's name."""

    def read(text: str) -> Any:
        value = convert(text)
        wrong = complaint(about, value)
        if wrong:
            raise argparse.ArgumentTypeError(wrong)
        return value

    return read


class _Collect(argparse.Action):
    """Store several values as a tuple, as in frozen configurations."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        if values or option_string:
            setattr(namespace, self.dest, tuple(values))


class _Append(argparse.Action):
    """Append one value to the tuple of earlier values."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        setattr(namespace, self.dest, (*getattr(namespace, self.dest, ()), values))


def _converter(hint: Any) -> tuple[Callable[[str], Any], str]:
    """Return the parser of a value of this type, and its placeholder in the help."""
    known: dict[Any, tuple[Callable[[str], Any], str]]
    known = {int: (_whole, "N"), float: (_number, "X"), str: (str, "NAME")}
    return known.get(_without_none(hint), (_without_none(hint), "PATH"))


def _without_none(hint: Any) -> Any:
    if typing.get_origin(hint) in (typing.Union, UnionType):
        return next(part for part in typing.get_args(hint) if part is not NoneType)
    return hint


def _whole(text: str) -> int:
    """Parse 5000000, 5_000_000 or 5e6."""
    number = _number(text)
    if number != int(number):
        raise argparse.ArgumentTypeError(f"'{text}' is not an integer")
    return int(text.replace("_", "")) if text.replace("_", "").lstrip("+-").isdigit() else int(number)


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number") from None
    if number != number or number in (float("inf"), float("-inf")):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return number


def _spell(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, tuple):
        return " ".join(f'"{item}"' if " " in str(item) else str(item) for item in value) or "none"
    return f"{value:_}" if isinstance(value, int) and value >= 100_000 else str(value)


# ---------------------------------------------------------------- argparse with one-sentence errors


def _unknown(word: str, flags: list[str]) -> str:
    if not word.startswith("-"):
        return f"unexpected argument '{word}'"
    return f"unknown flag {word.partition('=')[0]}{nearest(word.partition('=')[0], flags)}"


class _Parser(argparse.ArgumentParser):
    """A parser with one-sentence errors and a one-line usage; `words` are the positional arguments."""

    words: tuple[str, ...] = ()

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.topics: dict[str, list[Any]] = {}  # groups that `--help TOPIC` shows
        self.titles: dict[str, str] = {}  # titles of these pages
        self.offered: dict[str, tuple[str, ...]] = {}  # known values of each flag, for completion; others may be valid
        self._positionals.title = "arguments"

    def error(self, message: str) -> NoReturn:
        raise UsageError(message.removeprefix("argument ") + f"; see {self.prog} --help")

    def format_usage(self) -> str:
        return f"usage: {' '.join([self.prog, *self.words])} [flags]\n"

    def format_page(self, topic: str | None) -> str:
        """Return a help page: the main one, that of a topic, or "all". Raises `UsageError` for any other word."""
        if topic is None:
            apart = [group for groups in self.topics.values() for group in groups]
            shown = [group for group in self._action_groups if group not in apart]
        elif topic == "all":
            shown = self._action_groups
        elif topic in self.topics:
            shown = self.topics[topic]
        else:
            raise UsageError(f"--help has no page '{topic}'{nearest(topic, self.topics)}; see {self.prog} --help")
        formatter = self._get_formatter()
        if topic is None:
            formatter.add_text(self.description)
        for number, group in enumerate(shown):
            formatter.start_section(self.titles[topic] if topic in self.titles and not number else group.title)
            formatter.add_text(group.description)
            formatter.add_arguments(group._group_actions)
            formatter.end_section()
        pages = [self.format_usage(), formatter.format_help().strip("\n") + "\n"]
        return "\n".join(pages + [self._contents()] * (topic is None and bool(self.topics)))

    def _contents(self) -> str:
        """Return the table of topics, one per line."""
        known = {**self.titles, "all": "every flag"}
        margins: Any = {"initial_indent": "  ", "subsequent_indent": " " * 18}
        wrapped = [textwrap.wrap(f"{topic:<16}{title}", _width() - 2, **margins) for topic, title in known.items()]
        lines = [line for paragraph in wrapped for line in paragraph]
        return "\n".join([f"more settings: {self.prog} --help TOPIC", *lines, ""])


class _ShowHelp(argparse.Action):
    """Print a help page and exit."""

    def __init__(self, option_strings: Sequence[str], dest: str) -> None:
        super().__init__(option_strings, dest, 0, default=argparse.SUPPRESS, metavar="TOPIC", help="show this and exit")

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        print(parser.format_page(values or None), end="")
        parser.exit()


def _width() -> int:
    return min(shutil.get_terminal_size().columns, 110)


class _Help(argparse.HelpFormatter):
    """A narrow column of flags; each flag is shown once."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=34, width=_width())
