"""`regista demonstrate`: save episodes of a semi-expert program or of a trained student as demonstrations.

    regista demonstrate academy/run_to_score_with_keeper --episodes 1000 --out demos
    regista demonstrate mine.scenic --control active --keep all --out demos
    regista demonstrate --run runs/1v1Free-dr-0 --episodes 1000 --out demos

The same command continues after a stop, and adds episodes if more are requested. Read next:
`imitation.demonstrations`, the folder.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from regista.experiments.imitation.demonstrations import Demonstrations, DemonstrationsConfig, Summary, check_installed
from regista.experiments.run import arguments, build
from regista.experiments.run.arguments import positional
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.games import Game, single_game
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.notes import warn
from regista.experiments.run.programs import load_program
from regista.experiments.run.progress import Progress, count, counted
from ued.config import LARGEST_SEED, Checked, most_threads, setting

if TYPE_CHECKING:
    from regista.envs.football.vector_env import FootballVectorEnv
    from regista.experiments.imitation.demonstrator import Choose

DESCRIPTION = "Save episodes of a program or of a trained student as records and as a Minari dataset."
SET_BY_RUN = {"representation", "control", "right_control"}
SIDE_BY_SIDE = {"smm": 64, "smm_stacked": 64}  # parallel episodes, by representation; 256 for small observations


@dataclass(frozen=True)
class DemonstrateConfig(Checked):
    """Arguments of `regista demonstrate`."""

    minigame: str = positional("minigame or path of a .scenic program", default="")
    episodes: int = setting(1000, "number of episodes to save", ">=1", most=10_000_000)
    out: Path | None = setting(None, "output folder (default demos/MINIGAME)")
    run: Path | None = setting(None, "let the student of this run act instead of the program")
    keep: Literal["successful", "all"] = setting("successful", "episodes to save: successful or all")
    success_above: float | None = setting(
        None, "success threshold on the return (default: the success criterion of the game)", most=1e9, least=-1e9
    )
    max_played: int = setting(
        0, "give up after playing this many episodes; 0: 100 per requested episode", ">=0", most=10**9
    )
    greedy: bool = setting(False, "the student takes its most likely action")
    seed: int = setting(0, "seed of levels and episodes", ">=0", most=LARGEST_SEED)
    representation: Literal["features", "simple115", "smm", "smm_stacked"] = setting("features", "observation")
    control: str | None = setting(None, "left players controlled by agents (default: that of the minigame)")
    right_control: str = setting("none", "right players controlled by agents, as for --control")
    threads: int = setting(1, "threads for the simulator and for the networks", ">=1", most=most_threads)


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code."""
    given = arguments.typed_settings(DemonstrateConfig(), argv, "demonstrate", DESCRIPTION)
    typed = arguments.replace_paths(DemonstrateConfig(), given)
    if not typed.minigame and typed.run is None:
        raise UsageError("demonstrate needs a minigame's name, a .scenic file, or --run RUN")
    for name in sorted(SET_BY_RUN & given.keys()) if typed.run else ():
        raise UsageError(f"{arguments.flag_name(name)} and --run exclude each other: a run has its training settings")
    check_installed()
    config, program, student, env_steps = _policy_of(typed)
    # before the folder, so an error leaves no folder
    env = build.make_matches(program, config.part, config.env, config.seed, typed.threads)
    stem = Path(config.minigame).stem if config.minigame.endswith(".scenic") else config.minigame
    out = typed.out or Path("demos") / stem
    demos = Demonstrations.create_or_continue(out, config, program.source, env_steps)
    if student is None:
        if not env.behaviors.is_live:
            warn(f"note: {program.file} has no behaviors; the built-in AI acts for its agents")
        env = env.with_scripted_policy()
    with StopRequest() as stop:
        _fill(demos, env, student, typed, stop)
    return stop.exit_code


def _policy_of(
    typed: DemonstrateConfig,
) -> tuple[DemonstrationsConfig, Any, Callable[[int], Choose] | None, int | None]:
    """Return the settings of the folder, the program, and two values for a student (otherwise None).

    These are a function that makes the student's policy from a seed, and the env_steps of its training.
    """
    from regista.envs.football.config import FootballConfig

    chosen = {name: getattr(typed, name) for name in ("keep", "success_above", "greedy", "seed")}
    part = SIDE_BY_SIDE.get(typed.representation, 256)
    if typed.run is None:
        found = single_game(typed.minigame)
        game = found.minigame
        try:
            env = FootballConfig(
                representation=typed.representation,
                control=typed.control or game.control,
                right_control=typed.right_control,
            )
        except ValueError as error:
            raise UsageError(str(error)) from error
        alone = env.control in ("active", "closest1", "1")
        program = load_program((game.expert if alone else game.team_expert) or game.program, None)
        return DemonstrationsConfig(minigame=found.name, part=part, env=env, **chosen), program, None, None
    if typed.minigame:
        raise UsageError(f"{typed.minigame} and --run exclude each other: a run plays its own minigame")
    run = RunFolder.open(typed.run)
    played = single_game(run.config.minigame)
    env = replace(run.config.scored().env, pixels="dense")  # students also accept images
    part = SIDE_BY_SIDE.get(env.representation, 256)
    program = played.program(run.config)
    chosen |= {"minigame": run.config.minigame, "source": str(typed.run.resolve()), "program": run.config.program}
    config = DemonstrationsConfig(part=part, env=env, **chosen)
    return config, program, *_student(run, played, typed.greedy)


def _student(run: RunFolder, game: Game, greedy: bool) -> tuple[Callable[[int], Choose], int]:
    from regista.experiments.run.evaluator import load_student
    from ued.core.seeding import torch_generator
    from ued.learning.student import Player

    student, (env_steps, _) = load_student(run, game)
    return lambda seed: Player(student, torch_generator(seed), greedy), env_steps


def _fill(
    demos: Demonstrations,
    env: FootballVectorEnv,
    student: Callable[[int], Choose] | None,
    typed: DemonstrateConfig,
    stop: StopRequest,
) -> None:
    """Play parts until the requested episodes are saved, and print a summary."""
    from regista.experiments.imitation.demonstrator import parts

    config, most = demos.config, typed.max_played or 100 * typed.episodes
    tally, began, number = Tally(), time.perf_counter(), demos.num_parts()
    for summary in demos.summaries():
        tally.add(summary)
    progress, before = Progress(typed.episodes, tally.kept, unit="episodes"), tally.steps
    playing = parts(env, student, config.seed, number)
    while tally.kept < typed.episodes and tally.played < most and not stop:
        tally.add(demos.add(number, next(playing), tally.kept))
        number += 1
        progress.show(min(tally.kept, typed.episodes), {"success": tally.successes / tally.played})
    spaces = env.single_observation_space, env.single_action_space
    names = [parameter.name for parameter in env.parameters]
    demos.finish(names, spaces, _gym_settings(env), typed.episodes)
    seconds = time.perf_counter() - began
    pace = f"; {count((tally.steps - before) / seconds)} steps/s" if tally.steps > before else ""
    progress.finish(f"{demos.path}: {counted(min(tally.kept, typed.episodes), 'episode')}, {tally}{pace}")
    if tally.kept < typed.episodes and not stop:
        raise CommandError(
            f"only {tally.kept} of {counted(tally.played, 'episode')} were successful, {typed.episodes} were "
            f"requested; they are saved in {demos.path}: continue with a larger --max-played, or use --keep all"
        )
    if stop:
        print("stopped; run the same command to continue")


class Tally:
    """Counts over the episodes played so far."""

    def __init__(self) -> None:
        self.played = self.kept = self.successes = self.steps = 0

    def add(self, part: Summary) -> None:
        """Add the counts of a part."""
        self.played += len(part.kept)
        self.kept += int(part.kept.sum())
        self.successes += int(part.success.sum())
        self.steps += int(part.lengths.sum())

    def __str__(self) -> str:
        from regista.experiments.run.report import two_digits
        from ued.statistics import wilson

        rate = two_digits(wilson(self.successes, self.played)) if self.played else "unknown"
        return f"{self.played} played, success {rate}, {count(self.steps)} steps"


def _gym_settings(env: FootballVectorEnv) -> dict[str, Any]:
    """Return the arguments with which `FootballEnv` recreates this environment."""
    folder, config = env.program.mode.state.root, env.config
    place = None if folder is None else folder / env.program.file
    return {
        "program": env.program.source if place is None else str(place.resolve()),
        "representation": config.representation,
        "rewards": config.rewards,
        "control": config.control,
        "right_control": config.right_control,
        "dialect": config.dialect,
    }
