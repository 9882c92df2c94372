"""`regista list`: show the minigames, built-in tasks and shipped policies as tables, or the details of one.

    regista list
    regista list maze
    regista list defense
    regista list offense/easy_crossing
    regista list --solved 1v1Free Gauntlet --total-env-steps 2_000_000

Read next: `regista.minigames.suites`, the table itself; `run.built_in`, the tasks; `commands.inspect`, programs.
"""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.run import arguments, build, shipped
from regista.experiments.run.arguments import group, positional
from regista.experiments.run.built_in import BUILT_IN
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import all_starts
from regista.experiments.run.programs import load_program
from regista.experiments.run.progress import counted
from regista.experiments.run.results import align
from regista.experiments.run.solved import SolvedConfig, report
from ued.config import Checked, setting

if TYPE_CHECKING:
    from regista.minigames.published import Published
    from regista.minigames.suites import Minigame

DESCRIPTION = (
    "Show the minigames: players (left v right), number D of free parameters θ (training, test scenes), the players "
    "that one agent and a team control, and the published goal differences of PPO. Then show the named mixtures of "
    "minigames, the built-in tasks, and the shipped policies."
)
AGENTS = {
    "ppo": "PPO, 5M steps",
    "random": "random policy",
    "expert": "semi-expert program",
    "cloned": "behavior cloning of the semi-expert",
    "pretrained": "cloning, then PPO",
    "ppo_before": "PPO without cloning, for comparison",
    "team_ppo": "team, PPO, 5M steps",
    "team_expert": "team, semi-expert program",
    "team_cloned": "team, behavior cloning",
    "team_pretrained": "team, cloning, then PPO",
    "light_cnn": "light CNN, domain randomization",
    "impala_cnn": "original Impala CNN",
}


@dataclass(frozen=True)
class ListConfig(Checked):
    """Arguments of `regista list`."""

    words: tuple[str, ...] = positional("minigames, mixtures or tasks to show: names, or parts", default=())
    solved: bool = setting(False, "train a student on these games and report the share of random levels it solves")
    solving: SolvedConfig = group(
        SolvedConfig, "with --solved", prefix="", topics={"solved": "with --solved: levels, evaluations, training"}
    )


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    base = ListConfig()
    trains = [replace(base.solving.train, env=start.env) for start in all_starts()]
    others = {"for other games": [replace(base, solving=replace(base.solving, train=train)) for train in trains]}
    typed = arguments.typed_settings(base, argv, "list", DESCRIPTION, others)
    config = arguments.replace_paths(base, typed)
    if config.solved:
        prefix = "solving.train."
        training = {path.removeprefix(prefix): value for path, value in typed.items() if path.startswith(prefix)}
        report(config.words, config.solving, training)
        return 0
    if given := [path for path in typed if path.startswith("solving.")]:
        flag = arguments.flag_name(given[0].rpartition("solving.train.")[2].removeprefix("solving."))
        raise UsageError(f"{flag} needs --solved")
    from regista.minigames.suites import ALL, MIXTURES

    names = [*ALL, *MIXTURES, *BUILT_IN]
    by_word = {word: [word] if word in names else _containing(word, names) for word in config.words}
    chosen = [name for name in names if not by_word or any(name in some for some in by_word.values())]
    for word, some in by_word.items():
        if not some:
            raise UsageError(f"no minigame, mixture or task has {word!r} in its name{nearest(word, names, 3)}")
    if len(chosen) == 1:
        print(one(chosen[0]))
        return 0
    games, mixtures, tasks = ([name for name in chosen if name in known] for known in (ALL, MIXTURES, BUILT_IN))
    parts = []
    if games:
        parts.append(table([HEAD, *(line(ALL[name]) for name in games)], shutil.get_terminal_size().columns))
    if mixtures:
        counted = [[name, f"{len(MIXTURES[name])} minigames, easy to hard"] for name in mixtures]
        parts.append(align([["mixture", "what"], *counted]))
    if tasks:
        parts.append(align([["task", "what"], *([name, BUILT_IN[name].about] for name in tasks)]))
    if policies := [policy for name in chosen if (policy := shipped.of_game(name))]:
        parts.append(policy_table(policies))
    print("\n\n".join(parts))
    return 0


def one(name: str) -> str:
    """Return the details of a minigame, a mixture of minigames, or a built-in task."""
    from regista.minigames.suites import ALL, MIXTURES

    if name in ALL:
        return card(ALL[name])
    if name in MIXTURES:
        about = f"{name}: a mixture of minigames, which `train` and `compare` accept; each level has one of them"
        return "\n    ".join([about, *MIXTURES[name]])
    return task_card(name)


def _containing(word: str, names: Sequence[str]) -> list[str]:
    return [name for name in names if word.lower() in name.lower()]


# ---------------------------------------------------------------- all games


HEAD = ["minigame", "players", "D", "D test", "one agent", "team", "PPO", "on test", "team PPO", "what"]
NARROW = ["minigame", "players", "D", "what"]  # columns in a narrow terminal
SHORTEST = 20  # characters, minimum width of a text or of the last column


def line(game: Minigame) -> list[str]:
    """Return the table row of a minigame."""
    from regista.minigames.published import find_published

    players, dim = look(game)
    tests = dict.fromkeys(str(look(test)[1]) for test in game.test_games())
    teams = [find_published(game.name, "team_ppo", control=control) for control in game.team_control]
    alone = [find_published(game.name, "ppo", split) for split in ("train", "test")]
    numbers = [*map(number, alone), " ".join(filter(None, map(number, teams)))]
    return [
        game.name, players, str(dim), " ".join(tests), game.control, " ".join(game.team_control), *numbers,
        game.description,
    ]  # fmt: skip


def table(rows: list[list[str]], width: int) -> str:
    """Return the table of minigames; if it is wider than `width`, only the most important columns."""
    whole = align(rows)
    if _width(whole) <= width:
        return whole
    *chosen, what = (rows[0].index(name) for name in NARROW)
    taken = sum(max(len(row[column]) for row in rows) + 2 for column in chosen)
    room = max(width - taken, SHORTEST)
    lines = align([[*(row[column] for column in chosen), shortened(row[what], room)] for row in rows])
    use = f"regista list NAME shows one in full; a terminal of {_width(whole)} columns shows all columns"
    return f"{lines}\n\n{fill(use)}"


def fill(text: str) -> str:
    """Wrap a text at the width of the terminal."""
    width = max(shutil.get_terminal_size().columns, SHORTEST)
    return textwrap.fill(text, width, break_long_words=False, break_on_hyphens=False)


def _width(text: str) -> int:
    return max(map(len, text.splitlines()))


def shortened(text: str, width: int) -> str:
    """Shorten a text to `width` characters at a word boundary."""
    return textwrap.shorten(text, width, placeholder=" …")


def look(game: Minigame) -> tuple[str, int]:
    """Return the number of players on the left and on the right, and D, the dimension of θ."""
    from regista.envs.football.scenic.lineup import Lineup

    program = load_program(game.program, None)
    right = np.asarray(Lineup(program, game.control).roster.teams)
    return f"{(right == 0).sum()} v {right.sum()}", program.dim


def number(row: Published | None) -> str:
    """Return a published goal difference, or an empty cell."""
    return "" if row is None else f"{row.goal_difference:+.2f}"


def policy_table(names: Sequence[str]) -> str:
    """Return the table of shipped policies, with the commands that use one."""
    configs = [RunFolder.open(shipped.located(name)).config for name in names]
    trained = [f"{config.method}, {config.total_env_steps:_} env_steps" for config in configs]
    rows = align([["shipped policy", "trained by"], *map(list, zip(names, trained, strict=True))])
    use = f"regista play --player {names[0]} and regista evaluate {names[0]} need no training"
    return f"{rows}\n\n{fill(use)}"


# ---------------------------------------------------------------- one game


def card(game: Minigame) -> str:
    """Return the details of a minigame."""
    rows: dict[str, Any] = {
        "what": game.description,
        "difficulty": game.difficulty,
        "program": game.program,
        "one agent moves": f"{game.control}, recommended reward: {game.rewards}",
        "a team moves": " or ".join(game.team_control),
        "semi-expert": ", ".join(f"experts/{path.name}" for path in (game.expert, game.team_expert) if path),
        "trained policy": shipped.of_game(game.name),
    }
    players, dim = look(game)
    parts = [
        f"{game.name}: {players} players, D = {dim}",
        listed(rows, 17),
    ]
    if game.tests:
        labels = [label for label, _ in game.tests]
        tests = [[test.name, str(look(test)[1]), labels[k]] for k, test in enumerate(game.test_games())]
        if all(name.endswith(f"/{label}") for name, _, label in tests):  # labels that only repeat the names
            parts.append(align([["test scene", "D"], *(row[:2] for row in tests)]))
        else:
            parts.append(wrapped([["test scene", "D", "what"], *tests]))
    known = measured(game)
    if len(known) > 1:
        parts.append(align(known))
    return "\n\n".join(parts)


def wrapped(rows: list[list[str]]) -> str:
    """Return a table whose last column wraps at the width of the terminal."""
    taken = sum(max(len(row[column]) for row in rows) + 2 for column in range(len(rows[0]) - 1))
    room = max(shutil.get_terminal_size().columns - taken, SHORTEST)
    lines = []
    for *cells, last in rows:
        first, *more = textwrap.wrap(last, room) or [""]
        lines += [[*cells, first], *([*("" for _ in cells), rest] for rest in more)]
    return align(lines)


def listed(rows: Mapping[str, Any], indent: int) -> str:
    """Return names and their values, one per line, with wrapped values indented. Empty values are omitted."""
    width = max(shutil.get_terminal_size().columns, indent + SHORTEST)
    margins: Any = {"subsequent_indent": " " * indent, "break_long_words": False, "break_on_hyphens": False}
    return "\n".join(
        textwrap.fill(f"{name:<{indent}}{value}", width, drop_whitespace=True, **margins)
        for name, value in rows.items()
        if value
    )


def task_card(name: str) -> str:
    """Return the details of a built-in task: a description, its levels, its tests."""
    game = build.find_game(name)
    config = game.start("fast")
    task = game.task(config)
    upomdp = task.make(1)
    rows = {
        "what": BUILT_IN[name].about,
        "task": game.name,
        "observations": upomdp.single_observation_space,
        "actions": upomdp.single_action_space,
        "baselines": ", ".join(task.make_baselines(upomdp)),
        "trained by default": f"{config.total_env_steps:_} env_steps in {counted(config.num_envs, 'environment')}",
        "trained policy": shipped.of_game(name),
    }
    parts = [f"{name}: D = {upomdp.theta_dim}", listed(rows, 20)]
    for title, scenes in (("test", task.tests), ("held out", task.held_out)):
        if scenes:
            parts.append(wrapped([[title, "what"], *([scene, task.about.get(scene, "")] for scene in scenes)]))
    return "\n\n".join(parts)


def measured(game: Minigame) -> list[list[str]]:
    """Return the table of published results of a minigame; only the header if there are none."""
    from regista.minigames.published import published

    rows = [["published", "moves", "on", "goal difference", "runs", "episodes", "source"]]
    for row in published():
        if row.game == game.name:
            interval = "" if row.interval is None else f" ± {row.interval:.3f}"
            counts = ["" if count is None else str(count) for count in (row.runs, row.episodes)]
            value = f"{row.goal_difference:+.3f}{interval}"
            rows.append([AGENTS[row.agent], row.control, row.split, value, *counts, row.source])
    return rows
