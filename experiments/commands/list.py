"""`regista list`: the minigames as a table, or all that is known of one.

    regista list
    regista list defense
    regista list offense/easy_crossing
    regista list --solved 1v1Free Gauntlet --total-env-steps 2_000_000

Read next: `regista.minigames.suites`, the table itself; `commands.inspect`, which looks into a program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from regista.experiments.run import arguments, solved
from regista.experiments.run.arguments import positional
from regista.experiments.run.errors import UsageError, nearest
from regista.experiments.run.programs import load_program
from regista.experiments.run.results import align
from ued.config import Checked, setting

if TYPE_CHECKING:
    from regista.minigames.published import Published
    from regista.minigames.suites import Minigame

DESCRIPTION = (
    "Show the minigames: players (left v right), free parameters D of θ (of training, of the test scenes), whom one "
    "agent and a team move, and the published goal differences of PPO."
)
AGENTS = {
    "ppo": "PPO, 5M steps",
    "random": "random policy",
    "expert": "semi-expert program",
    "cloned": "behavior cloning of it",
    "pretrained": "cloning, then PPO",
    "ppo_before": "PPO without, as compared with these",
    "team_ppo": "team, PPO, 5M steps",
    "team_expert": "team, semi-expert program",
    "team_cloned": "team, behavior cloning",
    "team_pretrained": "team, cloning, then PPO",
    "light_cnn": "light CNN, domain randomization",
    "impala_cnn": "Impala CNN of the original",
}


@dataclass(frozen=True)
class ListConfig(Checked):
    """What is typed after `regista list`."""

    words: tuple[str, ...] = positional("minigames to show: a name, or a part of names", default=())
    solved: bool = setting(False, "train a student and report how many random levels it solves; see list --solved -h")


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    if "--solved" in argv:
        return solved.main([word for word in argv if word != "--solved"])
    config = arguments.parse(ListConfig(), argv, "list", DESCRIPTION)
    from regista.minigames.suites import ALL

    chosen = [game for game in ALL.values() if _chosen(game.name, config.words)]
    for word in config.words:
        if not any(_chosen(game.name, (word,)) for game in chosen):
            raise UsageError(f"no minigame has {word!r} in its name{nearest(word, ALL, 3)}")
    if len(chosen) == 1:
        print(card(chosen[0]))
    else:
        print(align([HEAD, *map(line, chosen)]))
    return 0


def _chosen(name: str, words: Sequence[str]) -> bool:
    return not words or any(word.lower() in name.lower() for word in words)


# ---------------------------------------------------------------- all of them


HEAD = ["minigame", "players", "D", "D test", "one agent", "team", "PPO", "on test", "team PPO", "what"]


def line(game: Minigame) -> list[str]:
    """Return the row of a minigame."""
    from regista.minigames.published import find_published

    players, dim = look(game)
    tests = dict.fromkeys(str(look(test)[1]) for test in game.test_games())
    teams = [find_published(game.name, "team_ppo", control=control) for control in game.team_control]
    told = [find_published(game.name, "ppo", split) for split in ("train", "test")]
    numbers = [*map(number, told), " ".join(filter(None, map(number, teams)))]
    return [
        game.name, players, str(dim), " ".join(tests), game.control, " ".join(game.team_control), *numbers,
        game.description,
    ]  # fmt: skip


def look(game: Minigame) -> tuple[str, int]:
    """Return how many play on the left and on the right, and the D of θ."""
    from regista.envs.football.scenic.lineup import Lineup

    program = load_program(game.program, None)
    right = np.asarray(Lineup(program, game.control).roster.teams)
    return f"{(right == 0).sum()} v {right.sum()}", program.dim


def number(row: Published | None) -> str:
    """Return a published goal difference, or nothing."""
    return "" if row is None else f"{row.goal_difference:+.2f}"


# ---------------------------------------------------------------- one of them


def card(game: Minigame) -> str:
    """Return all that is known of a minigame."""
    rows: dict[str, Any] = {
        "what": game.description,
        "difficulty": game.difficulty,
        "program": game.program,
        "one agent moves": f"{game.control}, best paid for {game.rewards}",
        "a team moves": " or ".join(game.team_control),
        "semi-expert": ", ".join(f"experts/{path.name}" for path in (game.expert, game.team_expert) if path),
    }
    players, dim = look(game)
    parts = [
        f"{game.name}: {players} players, D = {dim}",
        "\n".join(f"{name:<17}{value}" for name, value in rows.items() if value),
    ]
    if game.tests:
        labels = [label for label, _ in game.tests]
        tests = [[test.name, str(look(test)[1]), labels[k]] for k, test in enumerate(game.test_games())]
        parts.append(align([["test scene", "D", "what"], *tests]))
    known = measured(game)
    if len(known) > 1:
        parts.append(align(known))
    return "\n\n".join(parts)


def measured(game: Minigame) -> list[list[str]]:
    """Return the table of what is published of a minigame; its head alone if nothing is."""
    from regista.minigames.published import published

    rows = [["published", "moves", "on", "goal difference", "runs", "episodes", "source"]]
    for row in published():
        if row.game == game.name:
            interval = "" if row.interval is None else f" ± {row.interval:.3f}"
            counts = ["" if count is None else str(count) for count in (row.runs, row.episodes)]
            value = f"{row.goal_difference:+.3f}{interval}"
            rows.append([AGENTS[row.agent], row.control, row.split, value, *counts, row.source])
    return rows
