"""`regista study`: train many games over seeds, play them, and write the page.

    regista study single --seeds 5 --hours 3        # thesis, Figure 2.7: one agent on 13 games
    regista study generalisation --games offense/easy_crossing grf/empty_goal --seeds 1 --total-env-steps 500_000
    regista study multi --team shared --critic central --out runs/mappo
    regista study transfer                          # what `make transfer` does: both engines

Every run is a folder beneath `--out`, and so are the tables, the page and its pictures; a second call skips what is
finished, continues what is not, and plays what has not been played. `--publish` writes the repository's own page.
Read next: `run.workers`, which trains; `studies.measuring` and `commands.transfer`, which play; `studies.page`.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

from envs.football.config import FootballConfig
from experiments.commands import clone, demonstrate, transfer
from experiments.run import arguments, build, origin
from experiments.run.arguments import group
from experiments.run.config import TrainConfig, presets
from experiments.run.errors import UsageError, nearest
from experiments.run.folder import RunFolder
from experiments.run.signals import StopRequest
from experiments.run.workers import train_all
from ued.config import Checked, FineTuningConfig, setting

HERE = Path(__file__).parent.parent
BUDGETS = {  # of `transfer`: steps after which returns hardly rise any more
    "academy/run_to_score": 500_000,
    "academy/run_to_score_with_keeper": 1_000_000,
    "academy/pass_and_shoot_with_keeper": 500_000,
    "academy/run_pass_and_shoot_with_keeper": 500_000,
    "academy/3_vs_1_with_keeper": 500_000,
    "academy/counterattack_easy": 1_000_000,
    "1v1Restricted": 1_000_000,
    "1v1Free": 1_000_000,
    "3v2FourBehaviors": 1_000_000,
}
OTHERS = 1_000_000  # steps of a game that is not among these
OWN = ("minigame", "seed")  # settings of a run that the study chooses
BOOKKEEPING = {"total_env_steps", "threads", "checkpoint_seconds", "record", "record_rollouts", "record_limit"}
LONGEST = 24 * 365.0  # hours, where nobody says how many


def training(rewards: str = "scoring") -> TrainConfig:
    """Return what runs of a study begin with: nothing but training."""
    env = FootballConfig(rewards=rewards)
    return TrainConfig(method="dr", total_env_steps=OTHERS, eval_every=0, record=False, env=env)


@dataclass(frozen=True)
class StudyConfig(Checked):
    """What is typed after the name of any study."""

    games: tuple[str, ...] = setting((), "minigames instead of the study's own")
    seeds: int = setting(3, "runs of each game, with seeds 0, 1, ...", ">=1")
    processes: int = setting(0, "runs at a time; 0: one per core", ">=0")
    hours: float = setting(LONGEST, "stop after so long; called again, it goes on", ">0")

    def count_processes(self, threads: int) -> int:
        """Return how many runs are trained at a time."""
        return self.processes or max(1, (os.cpu_count() or 1) // threads)


@dataclass(frozen=True)
class TransferStudyConfig(StudyConfig):
    """What is typed after `regista study transfer`."""

    games: tuple[str, ...] = setting(
        tuple(BUDGETS), "minigames, each with a budget of its own unless --total-env-steps says otherwise"
    )
    representations: tuple[str, ...] = setting(("simple115", "features"), "what agents see, one after the other")
    out: Path = setting(Path("runs/transfer"), "folder of the study")
    episodes: int = setting(200, "whole episodes of each run in our simulator", ">=1")
    grf_episodes: int = setting(50, "whole episodes of each run in the other engine", ">=1")
    policies: tuple[str, ...] = setting(("sampled",), "how actions are chosen: sampled, greedy")
    train: TrainConfig = group(lambda: training("scoring,checkpoints"), "each run", without=OWN)

    def __post_init__(self) -> None:
        super().__post_init__()
        transfer.check_policies(self.policies)


@dataclass(frozen=True)
class BenchmarkStudyConfig(StudyConfig):
    """What is typed after `regista study single`, `generalisation`, `multi` or `demonstrations`."""

    preset: Literal["fast", "thesis"] = setting(
        "fast", "fast: features and a small network, 1M steps; thesis: stacked SMM and its network, 5M steps"
    )
    out: Path = setting(Path("runs/benchmark"), "folder of the runs, the tables, the page and its pictures")
    publish: bool = setting(False, "keep tables, page and pictures in the repository: BENCHMARK.md")
    episodes: int = setting(400, "whole episodes of each policy on each scene", ">=1")
    demonstrations: int = setting(1000, "successful episodes of a semi-expert program that are cloned", ">=1")
    train: TrainConfig = group(training, "each run", without=OWN)
    fine_tuning: FineTuningConfig = group(FineTuningConfig, "of demonstrations: training on from a clone", prefix="")


class Places(NamedTuple):
    """Where a study leaves what it has measured: a folder of CSV files, what is drawn from them, and its pictures."""

    results: Path
    page: Path
    pictures: Path


class Study(NamedTuple):
    """A study by name: what can be typed after it, and what does it. `main` gets what was typed of `train` apart."""

    help: str
    config: type[Any]
    main: Callable[[str, Any, dict[str, Any]], int]


def main(argv: Sequence[str]) -> int:
    """Run the command and give its exit code."""
    word, *rest = argv or ("",)
    if word in ("--help", "-h"):
        arguments.typed_settings(BenchmarkStudyConfig(), argv, "study STUDY", about_studies())
    if word not in STUDIES:
        raise UsageError(f"no study {word!r}{nearest(word, STUDIES)}; there are {', '.join(STUDIES)}")
    study = STUDIES[word]
    description = f"{study.help[0].upper()}{study.help[1:]}. Can be stopped at any time; called again, it continues."
    typed = arguments.typed_settings(study.config(), rest, f"study {word}", description)
    config = arguments.replace_paths(study.config(), typed)
    settings = {path.removeprefix("train."): value for path, value in typed.items() if path.startswith("train.")}
    return study.main(word, config, settings)


def about_studies() -> str:
    """Return what studies there are."""
    named = "; ".join(f"{name}: {study.help}" for name, study in STUDIES.items())
    return f"Train many games over seeds, play them and write tables. {named}. Each takes --help; of single and others:"


# ---------------------------------------------------------------- transfer: both engines


def study_transfer(name: str, config: TransferStudyConfig, settings: dict[str, Any]) -> int:
    """Train the runs that are not there yet, and play all in both engines."""
    if "env.representation" in settings:
        raise UsageError("a study takes --representations, several of them")
    runs = prepare(config, settings)
    with Deadline(config.hours) as stop:
        train_unfinished(runs, config, stop)
    if stop:
        print("continue with the same command: finished runs are kept")
        return stop.exit_code
    return transfer.main(words_of_transfer(config, runs))


def prepare(config: TransferStudyConfig, settings: dict[str, Any]) -> list[RunFolder]:
    """Create the run folders that are not there yet, and open the others; one seed of everything after the other."""
    runs = []
    for seed in range(config.seeds):
        for representation in config.representations:
            for game in config.games:
                budget = BUDGETS.get(game, OTHERS)
                base = replace(config.train, total_env_steps=budget)
                runs.append(open_run(config.out, game, seed, base, settings | {"env.representation": representation}))
    return runs


def open_run(out: Path, game: str, seed: int, base: TrainConfig, settings: dict[str, Any], kind: str = "") -> RunFolder:
    """Create the folder of a run or open it, if it was made with the same settings."""
    return RunFolder.create_or_extend(*plan_run(out, game, seed, base, settings, kind))


def plan_run(
    out: Path, game: str, seed: int, base: TrainConfig, settings: dict[str, Any], kind: str = ""
) -> tuple[Path, TrainConfig]:
    """Return a run's folder and settings: `base` with what the minigame says, then with what was typed."""
    minigame = build.find_minigame(game)
    base = replace(base, env=replace(base.env, control=minigame.control))
    config = replace(arguments.replace_paths(base, settings), minigame=build.canonical_name(game), seed=seed)
    team = "" if config.env.control == minigame.control else f"{config.env.control}-"
    return out / f"{minigame.name.replace('/', '_')}-{team}{kind}{config.env.representation}-{seed}", config


def train_unfinished(runs: Sequence[RunFolder], config: StudyConfig, stop: StopRequest) -> None:
    """Train the runs that are not finished, several at a time."""
    unfinished = [run for run in runs if not run.finished()]
    if unfinished:
        processes = min(config.count_processes(unfinished[0].config.threads), len(unfinished))
        print(f"{len(runs)} runs, {len(runs) - len(unfinished)} finished; {processes} at a time", flush=True)
        train_all(unfinished, processes, stop)


def words_of_transfer(config: TransferStudyConfig, runs: Sequence[RunFolder]) -> list[str]:
    """Return what would be typed after `regista transfer`."""
    episodes = ["--episodes", str(config.episodes), "--grf-episodes", str(config.grf_episodes)]
    files = ["--csv", str(config.out / "transfer.csv"), "--markdown", str(config.out / "transfer.md")]
    paths = [str(run.path) for run in runs]
    return [*paths, "--kept", "--no-details", "--policies", *config.policies, *episodes, *files]


# ---------------------------------------------------------------- the thesis's benchmark


class Wanted(NamedTuple):
    """A run that is to be measured; `agent` is as in the tables."""

    game: str
    agent: str
    control: str
    seed: int

    @property
    def kind(self) -> str:
        """What its folder is called behind its game: nothing of a run that begins anew."""
        return "pretrained-" if self.agent.endswith("pretrained") else ""


def study_benchmark(name: str, config: BenchmarkStudyConfig, settings: dict[str, Any]) -> int:
    """Train, play and write, a few runs after the others, so that what is done is in the files when it stops."""
    from experiments.studies import page
    from experiments.studies.rows import add, load, trained

    places, base = places_of(config), starting_point(config)
    check_published(config, settings)
    steps = arguments.replace_paths(base, settings).total_env_steps
    table = places.results / page.FILES.format(preset=config.preset)
    table.parent.mkdir(parents=True, exist_ok=True)
    rows = load(table)
    wanted = wanted_runs(name, config, settings)
    missing = [each for each in wanted if trained(rows, *each) < steps]
    check_same(config, base, settings, wanted)
    print(f"{len(wanted)} runs, {len(wanted) - len(missing)} measured", flush=True)
    processes = config.count_processes(base.threads)
    with Deadline(config.hours) as stop:
        for first in range(0, len(missing), processes):
            clones, runs = open_wanted(config, base, settings, missing[first:][:processes], stop)
            if not stop:
                train_unfinished(runs, config, stop)
            if stop:
                break
            rows = add(table, measure([*clones, *runs], rows, config.episodes))
            page.write_page(*places)
    page.write_page(*places)
    print(f"{places.page}: {len(rows)} rows of {table}" + (", continue with the same command" if stop else ""))
    return stop.exit_code


def wanted_runs(name: str, config: BenchmarkStudyConfig, settings: dict[str, Any]) -> list[Wanted]:
    """Return the runs of a study, one seed of everything after the other."""
    from experiments.studies.measuring import TEAM

    kinds = ("ppo", "pretrained") if name == "demonstrations" else ("ppo",)
    wanted = []
    for seed in range(config.seeds):
        for game, control in games_of(name, config, settings):
            team = "" if control == build.find_minigame(game).control else TEAM
            wanted += [Wanted(game, team + kind, control, seed) for kind in kinds]
    return wanted


def games_of(name: str, config: BenchmarkStudyConfig, settings: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the games of a study, each with whom its agents move: a team of each kind, or one agent."""
    from experiments.studies.page import PAIRS

    known = PAIRS[name]
    games = [build.find_minigame(game) for game in config.games or dict.fromkeys(game for game, _ in known)]
    pairs = []
    for game in games:
        controls = [control for other, control in known if other == game.name]
        if "env.control" in settings:
            controls = [settings["env.control"]]
        elif name == "multi":
            controls = controls or [*game.team_control]
        elif name != "demonstrations":
            controls = [game.control]
        if not controls:
            what = "team" if name == "multi" else "semi-expert program"
            raise UsageError(f"no {what} is known for {game.name}; say whom its agents move with --control")
        pairs += [(game.name, control) for control in controls]
    return pairs


def open_wanted(
    config: BenchmarkStudyConfig,
    base: TrainConfig,
    settings: dict[str, Any],
    wanted: Sequence[Wanted],
    stop: StopRequest,
) -> tuple[list[RunFolder], list[RunFolder]]:
    """Create the folders of runs or open them; clones, with which some of them begin, are made first."""
    out = config.out / config.preset
    clones: list[RunFolder] = []
    runs: list[RunFolder] = []
    for each in wanted:
        own = settings | {"env.control": each.control}
        if not each.kind:
            runs.append(open_run(out, each.game, each.seed, base, own))
            continue
        made = make_clone(config, each, base, own, stop)
        if made is None:
            break
        clones.append(RunFolder.open(made))
        runs.append(open_run(out, each.game, each.seed, base, own, each.kind))
        if not runs[-1].begun():
            origin.keep(runs[-1], origin.load(made), config.fine_tuning)
    return clones, runs


def make_clone(
    config: BenchmarkStudyConfig, wanted: Wanted, base: TrainConfig, settings: dict[str, Any], stop: StopRequest
) -> Path | None:
    """Let the semi-expert program play, and clone it; return the clone's folder, None if somebody asked to stop."""
    seen = arguments.replace_paths(base, settings).env.representation
    name = f"{wanted.game.replace('/', '_')}-{wanted.control}-{seen}"
    demos, out = config.out / "demonstrations" / name, config.out / config.preset / f"{name}-clone-{wanted.seed}"
    if (out / "checkpoint.pt").exists():
        return out
    game = [wanted.game, "--representation", seen, "--control", wanted.control]
    played = [*game, "--episodes", str(config.demonstrations), "--out", str(demos)]
    cloned = [str(demos), "--preset", config.preset, "--seed", str(wanted.seed), "--out", str(out)]
    student = {path: value for path, value in settings.items() if path.startswith("ppo.")}
    cloned += [word for path, value in student.items() for word in (arguments.flag_name(path), str(value))]
    for command, words in ((demonstrate, played), (clone, cloned)):
        code = command.main(words)
        if code:
            stop.signal = code - 128  # which the command has caught
            return None
    return out


def places_of(config: BenchmarkStudyConfig) -> Places:
    """Return where a study writes: beneath its folder, or in the repository if it is told to."""
    if config.publish:
        return Places(HERE / "studies" / "results", HERE.parent / "BENCHMARK.md", HERE / "gallery")
    return Places(config.out / "results", config.out / "BENCHMARK.md", config.out / "pictures")


def check_published(config: BenchmarkStudyConfig, settings: dict[str, Any]) -> None:
    """Refuse to mix runs of other settings than a preset's with those that the repository holds of it."""
    own = sorted(settings.keys() - BOOKKEEPING)
    own += [] if config.fine_tuning == FineTuningConfig() else ["kl_to_clone"]
    if own and config.publish:
        flags = ", ".join(arguments.flag_name(path.rpartition(".")[2]) for path in own)
        raise UsageError(f"with {flags} it is no run of preset {config.preset}; leave out --publish")


def check_same(
    config: BenchmarkStudyConfig, base: TrainConfig, settings: dict[str, Any], wanted: Sequence[Wanted]
) -> None:
    """Refuse to go on with runs of other settings: those that are measured are not opened any more.

    Raises `ConfigError` that names the run, the setting and both values.
    """
    for each in wanted:
        own = settings | {"env.control": each.control}
        path, planned = plan_run(config.out / config.preset, each.game, each.seed, base, own, each.kind)
        if (path / "config.json").exists():
            RunFolder.open(path).extend(planned)


def starting_point(config: BenchmarkStudyConfig) -> TrainConfig:
    """Return what runs of a preset begin with: of `fast` the budget is a study's, of `thesis` its own."""
    if config.preset == "fast":
        return config.train
    chosen = presets()[config.preset]
    env = replace(config.train.env, representation="smm_stacked")
    return replace(config.train, env=env, ppo=chosen.ppo, num_envs=chosen.num_envs, total_env_steps=5_000_000)


def measure(runs: Sequence[RunFolder], known: Sequence[Any], episodes: int) -> list[Any]:
    """Play runs on all scenes of their games, and what needs no training where that is not known yet."""
    from experiments.studies import measuring

    rows = []
    for run in runs:
        game = run.config.minigame
        print(f"playing {game}, seed {run.config.seed}", flush=True)
        rows += measuring.measure_run(run, episodes)
        about = (game, "random", run.config.env.control)
        if not any(row[:3] == about for row in [*known, *rows]):
            rows += measuring.measure_random(run.config, episodes)
            rows += measuring.measure_experts(build.find_minigame(game), episodes)
    return rows


class Deadline(StopRequest):
    """A request to stop that comes by itself after so many hours: nobody has asked then, and the exit code is 0."""

    def __init__(self, hours: float) -> None:
        super().__init__()
        self._end = time.monotonic() + 3600 * hours

    def __bool__(self) -> bool:
        return super().__bool__() or time.monotonic() >= self._end


STUDIES = {
    "single": Study("one agent on the 13 games of the thesis's Figure 2.7", BenchmarkStudyConfig, study_benchmark),
    "generalisation": Study(
        "one agent on training and test scenes of all 22 games (Figure 2.8)", BenchmarkStudyConfig, study_benchmark
    ),
    "multi": Study("teams of agents on the 15 rows of Table 3.1", BenchmarkStudyConfig, study_benchmark),
    "demonstrations": Study(
        "semi-expert programs, their clones, and training on from these (Figure 2.10, Table 3.2)",
        BenchmarkStudyConfig,
        study_benchmark,
    ),
    "transfer": Study("games in both engines: the table of what carries over", TransferStudyConfig, study_transfer),
}
