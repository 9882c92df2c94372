"""Studies of many games over seeds: the benchmark of the thesis, and the gains from curricula.

    python -m lab.studies single --seeds 5 --hours 3        # thesis, Figure 2.7: one agent on 13 games
    python -m lab.studies generalization --games grf/empty_goal --seeds 1 --total-env-steps 500_000
    python -m lab.studies teams                             # independent policies, parameter sharing, MAPPO
    python -m lab.studies curricula --hours 3               # five methods on seven games

A study trains and plays runs, and tabulates the results. Every run is a folder beneath `--out`, and the rows are there
too. A second call skips finished runs, continues unfinished ones, and plays those not yet played. `--publish` keeps the
rows in `lab/studies/results` and writes their tables into BENCHMARK.md, or into docs/benchmarks/football.md with a
summary in RESULTS.md. Read next: `lab/studies/benchmark_study.py` and `lab/studies/curricula_study.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from lab.studies.benchmark_study import BenchmarkStudyConfig, presets_of_benchmark, run_benchmark
from lab.studies.curricula_study import CurriculaStudyConfig, games_of_study, run_curricula
from regista.experiments.run import arguments
from regista.experiments.run.errors import UsageError, nearest, run_command


class Study(NamedTuple):
    """A study by name: its arguments, and the function that runs it. `run` gets the arguments of `train` separately."""

    help: str
    config: type[Any]
    run: Callable[[str, Any, dict[str, Any]], int]
    others: Callable[[str], dict[str, list[Any]]]  # by case, other starting settings; see `arguments.Others`


def main(argv: Sequence[str]) -> int:
    """Run a study and return the exit code; a user error is reported in one sentence."""
    return run_command(run_study, argv)


def run_study(argv: Sequence[str]) -> int:
    """Run a study and return the exit code."""
    word, *rest = argv or ("",)
    if word in ("--help", "-h"):
        if rest and rest[0] in STUDIES:
            return run_study([rest[0], word, *rest[1:]])
        arguments.typed_settings(BenchmarkStudyConfig(), argv, "python -m lab.studies STUDY", about_studies())
    if word not in STUDIES:
        raise UsageError(f"no study {word!r}{nearest(word, STUDIES)}; there are {', '.join(STUDIES)}")
    study = STUDIES[word]
    description = f"{study.help[0].upper()}{study.help[1:]}. Can be stopped at any time; called again, it continues."
    typed = arguments.typed_settings(
        study.config(), rest, f"python -m lab.studies {word}", description, study.others(word)
    )
    config = arguments.replace_paths(study.config(), typed)
    train = {path.removeprefix("train."): value for path, value in typed.items() if path.startswith("train.")}
    return study.run(word, config, train)


def about_studies() -> str:
    """Return a list of the studies."""
    named = "; ".join(f"{name}: {study.help}" for name, study in STUDIES.items())
    return f"Train many games over seeds, play them and write tables. {named}. Each takes --help; of single and others:"


STUDIES = {
    "single": Study(
        "one agent on the 13 games of the thesis's Figure 2.7",
        BenchmarkStudyConfig,
        run_benchmark,
        presets_of_benchmark,
    ),
    "generalization": Study(
        "one agent on training and test scenes of all 22 games (Figure 2.8)",
        BenchmarkStudyConfig,
        run_benchmark,
        presets_of_benchmark,
    ),
    "multi": Study(
        "teams of agents on the 15 rows of Table 3.1", BenchmarkStudyConfig, run_benchmark, presets_of_benchmark
    ),
    "teams": Study(
        "independent policies, parameter sharing and MAPPO on three of the rows of Table 3.1",
        BenchmarkStudyConfig,
        run_benchmark,
        presets_of_benchmark,
    ),
    "demonstrations": Study(
        "semi-expert programs, their clones, and training on from these (Figure 2.10, Table 3.2)",
        BenchmarkStudyConfig,
        run_benchmark,
        presets_of_benchmark,
    ),
    "curricula": Study(
        "five tuned methods on seven games, played on held-out scenes",
        CurriculaStudyConfig,
        run_curricula,
        games_of_study,
    ),
    "tuning": Study("six settings of each method of curricula", CurriculaStudyConfig, run_curricula, games_of_study),
}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
