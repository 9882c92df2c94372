"""Our PPO on the academy's games beside published scores of PPO trained in Google Research Football (GRF).

The settings are closest to those of the GRF paper: one agent that is the active player, `simple115`, rewards
`scoring,checkpoints`, levels without jitter, 128 environments. Published scores that the repository has are the
thesis's, PPO trained in GRF for 5M env steps. Writes lab/results/academy_baselines.csv; a stopped call continues:

    python -m lab.academy_baselines              # 25 core-minutes: eight games, 5M env steps, one seed
    python -m lab.academy_baselines --seeds 3    # 75 core-minutes
    python -m lab.academy_baselines --games academy/empty_goal_close academy/run_to_score --env-steps 50_000_000

50M env steps are about 25 core-minutes a game, so one core-hour is enough for two games; all eight take 3.5 core-hours.

Read next: `lab/transfer.py`, which does the work.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

from lab.transfer import Unit, do_all, options_of
from lab.transfer_tables import RESULTS, write_tables

GAMES = (  # the cheapest first
    "academy/empty_goal_close",
    "academy/empty_goal",
    "academy/run_to_score",
    "academy/pass_and_shoot_with_keeper",
    "academy/run_pass_and_shoot_with_keeper",
    "academy/3_vs_1_with_keeper",
    "academy/run_to_score_with_keeper",
    "academy/counterattack_easy",
)
STEPS = 5_000_000
SEEDS = range(410, 415)  # used for nothing else


def units(games: Sequence[str], seeds: int, budget: int) -> Iterator[Unit]:
    """Yield `seeds` runs of each game, each with `budget` env steps."""
    for seed in SEEDS[:seeds]:
        for game in games:
            key = {"game": game, "representation": "simple115", "budget": budget, "seed": seed}
            settings = {"total_env_steps": budget, "env.representation": "simple115"}
            yield Unit("academy", key, settings, "scoring,checkpoints", (200, 50))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--games", nargs="+", choices=GAMES, default=GAMES, help="games to train on")
    parser.add_argument("--seeds", type=int, choices=range(1, len(SEEDS) + 1), default=1, help="runs of each game")
    options, typed = options_of(parser)
    runs = list(units(typed["games"], typed["seeds"], options.env_steps or STEPS))
    done = do_all(runs, options, options.results / "academy_baselines.csv")
    if options.results == RESULTS:
        write_tables()
    raise SystemExit(not done)


if __name__ == "__main__":
    main()
