"""Tables of transfer to GRF, made from the CSV files of `lab/transfer.py` and `lab/academy_baselines.py`.

A page has a place for each table, `<!-- table: NAME -->` to `<!-- end -->`; the text between these marks is replaced.
Columns of the files of trained runs: `ended/WORD` are shares of the episodes; `distance/A to B` are shares of the goals
by the distance of the last kick from the goal, in m. `keeper/A to B` are shares of the goals by the keeper's distance
from its line, in m.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab.grf.experts import experts
from lab.studies.cells import percent
from regista.envs.football.version import SIMULATOR_VERSION
from regista.experiments.run import significance
from regista.experiments.run.progress import count, counted
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.results import Counted, goal_rate
from regista.experiments.transfer.episodes import ENDINGS, ENGINES
from regista.experiments.transfer.goals import FAR, OUT, shares
from regista.experiments.transfer.replaying import Result
from regista.experiments.transfer.report import LEAST, WANTED, counts, rate_ratio
from regista.minigames.published import find_published
from ued.statistics import Difference, Interval, bootstrap, rank_correlation, wilson

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "lab" / "results"
PLACE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.S)
REPRESENTATIONS = ("simple115", "features")
SAMPLES = 4000
EXPLOIT, HARDLY, FEW = 0.5, 0.1, 20  # shares of our goals and of GRF's; minimum number of goals for a verdict
OVER_RUNS = "95% CI: bootstrap over runs and their episodes; none below 5 runs"

Rows = list[dict[str, str]]


def simulator_version() -> str:
    """Return the version of our simulator, the single source for the lab's scripts."""
    return str(SIMULATOR_VERSION)


# ---------------------------------------------------------------- cells


def number(interval: Interval | Difference, sign: str = "") -> str:
    """Return a number with its interval, if it has one."""
    if interval.estimate != interval.estimate:
        return "no goal, ours"
    ends = f" [{interval.low:{sign}.2f}, {interval.high:{sign}.2f}]" if interval.known else ""
    return f"{interval.estimate:{sign}.2f}{ends}"


def chosen(rows: Rows, **values: str) -> Rows:
    """Return the rows with these values."""
    return [row for row in rows if all(row[name] == value for name, value in values.items())]


def unique(rows: Rows, name: str) -> list[str]:
    """Return the distinct values of a column in their order."""
    return list(dict.fromkeys(row[name] for row in rows))


def per_run(rows: Rows) -> str:
    """Return the episodes of a run in both engines, in words."""
    ours, grf = (" or ".join(unique(chosen(rows, engine=engine), "episodes")) for engine in ENGINES)
    return f"{ours} episodes of each run in our simulator, {grf} in GRF"


def seeds(rows: Rows) -> str:
    """Return the seeds in words."""
    named = sorted(map(int, unique(rows, "seed")))
    return f"seed {named[0]}" if len(named) == 1 else f"seeds {named[0]} to {named[-1]}"


def steps(rows: Rows) -> str:
    """Return the budgets of some runs."""
    return " to ".join(dict.fromkeys(count(number) for number in sorted(int(row["env_steps"]) for row in rows)))


def results(rows: Rows) -> list[Result]:
    """Return the goals and episodes of runs, one result for each pair of rows."""
    names = ("game", "representation", "seed")
    runs: dict[tuple[str, ...], dict[str, Any]] = {}
    for row in rows:
        run = runs.setdefault(tuple(row[name] for name in names), {})
        run[row["engine"]] = {name: int(row[name]) for name in ("goals", "episodes")}
    return [
        Result("", key[0], key[1], "dr", "sampled", **run, leaves_ours={}, leaves_training={})
        for key, run in runs.items()
    ]


# ---------------------------------------------------------------- policies


def ratios(rows: Rows) -> dict[str, dict[str, Interval]]:
    """Return GRF's goal rate as a multiple of ours, by game; with each representation and with both."""
    of: dict[str, dict[str, Interval]] = {}
    for game in unique(rows, "game"):
        mine = chosen(rows, game=game)
        kinds = {name: chosen(mine, representation=name) for name in REPRESENTATIONS} | {"both": mine}
        of[game] = {name: rate_ratio(results(kind)) for name, kind in kinds.items() if kind}
    return of


def verdicts(rows: Rows) -> list[list[str]]:
    """Return the number of games on which policies transfer: a line for each representation and one for both."""
    found = ratios(rows)
    table = []
    for kind in (*REPRESENTATIONS, "both"):
        values = [intervals[kind].estimate for intervals in found.values() if kind in intervals]
        if not values:
            continue
        good, bad = sum(value >= WANTED for value in values), sum(value < LEAST for value in values)
        lowest = f"; lowest ratio {np.nanmin(values):.2f}" if np.isfinite(values).any() else ""
        about = "both together" if kind == "both" else f"`{kind}`"
        question = f"Games on which policies keep {WANTED:.0%} of their goals in GRF, {about}"
        table.append([question, f"{good} of {len(values)}; {bad} below {LEAST:.0%}{lowest}"])
    return table


def policies(rows: Rows) -> str:
    """Return the table of nine games."""
    head = ["game", "env steps"]
    for name in REPRESENTATIONS:
        head += [f"`{name}`: goals, ours", "GRF", "ratio"]
    table = [[*head, "both: ratio"]]
    for game, found in ratios(rows).items():
        mine = chosen(rows, game=game)
        line = [game, steps(mine)]
        for name in REPRESENTATIONS:
            runs = results(chosen(mine, representation=name))
            rates = [percent(goal_rate(counts(runs, engine))) if runs else "" for engine in ENGINES]
            line += [*rates, number(found[name]) if runs else ""]
        table.append([*line, number(found["both"])])
    about = (
        "Policies trained with DR in our simulator, `scoring,checkpoints`, academy levels with `-p jitter=1`, all with "
        f"`--engine-spread 0.15`; {seeds(rows)}, {per_run(rows)}, actions sampled. No setting was tuned on these "
        f"seeds. Ratio: mean goals in GRF divided by mean goals in our simulator. {OVER_RUNS}."
    )
    return f"{as_markdown(table)}\n\n{about}"


# ---------------------------------------------------------------- exploits


def pooled(rows: Rows, name: str, limits: Sequence[float]) -> dict[str, float]:
    """Return the shares of the goals of all runs, by the labels of `goals.shares`."""
    words = shares(np.zeros(1), limits)
    goals = np.array([int(row["goals"]) for row in rows])
    total = max(goals.sum(), 1)
    return {w: float((goals * [float(row.get(f"{name}/{w}") or 0) for row in rows]).sum() / total) for w in words}


def exploited(rows: Rows) -> list[str]:
    """Return the ways of scoring that make more than half of our goals and less than a tenth of GRF's."""
    sides = [chosen(rows, engine=engine) for engine in ENGINES]
    if min(sum(int(row["goals"]) for row in side) for side in sides) < FEW:
        return [f"fewer than {FEW} goals"]
    found = []
    for name, limits, word in (("distance", FAR, "from {} m"), ("keeper", OUT, "keeper {} m off its line")):
        ours, grf = (pooled(side, name, limits) for side in sides)
        found += [f"**{word.format(w)}**" for w in ours if ours[w] > EXPLOIT and grf[w] < HARDLY]
    return found


def exploits(rows: Rows) -> str:
    """Return the table of where goals come from in both engines."""
    kinds = (("distance", FAR), ("keeper", OUT))
    far, out = (" / ".join(shares(np.zeros(1), limits)) for _, limits in kinds)
    head = ["game", "goals, ours", "GRF", f"last kick from, m, ours: {far}", "GRF"]
    table = [[*head, f"keeper off its line, m, ours: {out}", "GRF", "exploit"]]
    for game in unique(rows, "game"):
        sides = [chosen(rows, game=game, engine=engine) for engine in ENGINES]
        cells = [str(sum(int(row["goals"]) for row in side)) for side in sides]
        for name, limits in kinds:
            for side in sides:
                of = pooled(side, name, limits).values()
                cells.append(" / ".join(f"{100 * share:.0f}" for share in of) if sum(of) else "–")
        table.append([game, *cells, ", ".join(exploited(chosen(rows, game=game))) or "none"])
    about = (
        "Goals of the policies above, both representations, in percent of the goals by the distance of the last kick "
        "from the middle of the goal and by the keeper's distance from its line. An exploit makes more than "
        f"{EXPLOIT:.0%} of our goals and less than {HARDLY:.0%} of GRF's."
    )
    return f"{as_markdown(table)}\n\n{about}"


# ---------------------------------------------------------------- the other parts


def gaps(rows: Rows) -> Difference:
    """Return the mean over runs of GRF's goal difference minus ours."""
    ours, grf = (np.array([float(row["mean_return"]) for row in chosen(rows, engine=engine)]) for engine in ENGINES)
    return bootstrap(grf - ours, np.random.default_rng(0)).difference()


def defense(rows: Rows) -> str:
    """Return the table of defenses."""
    words = ENDINGS[:-1]
    table = [
        [
            "game",
            "goal difference, ours, by seed",
            "GRF, by seed",
            "GRF minus ours",
            "ours: " + " / ".join(words),
            "GRF",
        ]
    ]
    found = {game: gaps(chosen(rows, game=game)) for game in unique(rows, "game")}
    marks = significance.marks(list(found.values()))
    for (game, gap), mark in zip(found.items(), marks, strict=True):
        mine = chosen(rows, game=game)
        sides = [chosen(mine, engine=engine) for engine in ENGINES]
        scores = [", ".join(f"{float(row['mean_return']):+z.2f}" for row in side) for side in sides]
        ends = [
            " / ".join(f"{100 * np.mean([float(row[f'ended/{w}']) for row in side]):.0f}" for w in words)
            for side in sides
        ]
        table.append([game, *scores, f"{number(gap, '+')} {mark}".rstrip(), *ends])
    about = (
        f"Policies trained with DR in our simulator for {steps(rows)} env steps, `features`, rewarded for goals; "
        f"{seeds(rows)}, {per_run(rows)}, actions sampled. How episodes end is in percent. A goal difference is -1 if "
        "the defense concedes and +1 if it scores. No setting was tuned on these seeds. Over "
        f"all {len(rows) // 2} runs, GRF minus ours is {number(gaps(rows), '+')} (95% CI: bootstrap over runs)."
    )
    legend = significance.sentences(significance.legend([gap.p for gap in found.values()]))
    return f"{as_markdown(table)}\n\n{about} {legend}".rstrip()


def over_scenes(rows: Rows, name: str, statistic: Callable[[np.ndarray], float]) -> Interval:
    """Return a statistic of a column with its percentile bootstrap interval over the scenes with a value."""
    values = np.array([float(row[name]) for row in rows if row.get(name)])
    if not len(values):
        return Interval(np.nan, np.nan, np.nan)
    drawn = np.random.default_rng(0).integers(0, len(values), (SAMPLES, len(values)))
    low, high = np.quantile([statistic(values[one]) for one in drawn], [0.025, 0.975])
    return Interval(float(statistic(values)), float(low), float(high))


def scenes(rows: Rows) -> str:
    """Return the table of drawn scenes."""
    table = [[f"{len(rows)} drawn scenes", "ours and GRF", "GRF and itself"]]
    ends = [percent(over_scenes(rows, f"endings_agree{limit}", np.mean)) for limit in ("", "_limit")]
    table.append(["endings that agree", *ends])
    for what in ("ball", "players"):
        cells = [
            "; ".join(number(over_scenes(rows, f"{what}_{step}{limit}", np.median)) for step in (10, 20, 40))
            for limit in ("", "_limit")
        ]
        table.append([f"{what} apart after 10, 20 and 40 steps, median m", *cells])
    about = (
        f"Scenes of 2 to 11 players a side, drawn with seed {rows[0]['seed']}; the same actions in both engines, 4 "
        "episodes of each scene in each engine. GRF and itself, with different seeds, is the limit. No law was derived "
        "from these scenes. 95% CI: bootstrap over scenes."
    )
    return f"{as_markdown(table)}\n\n{about}"


def ranks(rows: Rows) -> Interval:
    """Return the rank correlation of the programs' goals, with its percentile bootstrap interval over programs."""
    rates = [[int(row["goals"]) / int(row["episodes"]) for row in chosen(rows, engine=engine)] for engine in ENGINES]
    return rank_correlation(*rates)


def programs(rows: Rows) -> str:
    """Return the table of semi-expert programs."""
    known = {expert.name: expert for expert in experts()}
    table = [["program", "agents", "goals, ours", "GRF", "published, GRF"]]
    for name in unique(rows, "program"):
        mine = [chosen(rows, program=name, engine=engine)[0] for engine in ENGINES]
        rates = [percent(wilson(int(row["goals"]), int(row["episodes"]))) for row in mine]
        table.append([name, "a team" if known[name].is_team else "one", *rates, f"{100 * known[name].published:.0f}%"])
    about = (
        f"Scripted Scenic programs, without training. {rows[0]['episodes']} episodes of each program in each engine on "
        f"the same levels, {seeds(rows)}; Wilson's 95% CI. Rank correlation of ours with GRF over {len(table) - 1} "
        f"programs: {number(ranks(rows))} (95% CI: bootstrap over programs)."
    )
    return f"{as_markdown(table)}\n\n{about}"


def converse(rows: Rows) -> str:
    """Return the table of policies trained in GRF."""
    table = [["game", "seed", "goals, GRF", "ours"]]
    for game in unique(rows, "game"):
        for seed in sorted(unique(chosen(rows, game=game), "seed")):
            mine = [chosen(rows, game=game, seed=seed, engine=engine)[0] for engine in ("grf", "ours")]
            rates = [percent(wilson(int(row["goals"]), int(row["episodes"]))) for row in mine]
            table.append([game, seed, *rates])
    about = (
        f"PPO trained in GRF for {steps(rows)} env steps, `simple115`, `scoring,checkpoints`, the academy's fixed "
        f"start; {per_run(rows)}, actions sampled. No setting was tuned. Wilson's 95% CI, over a run's episodes."
    )
    return f"{as_markdown(table)}\n\n{about}"


def academy(rows: Rows) -> str:
    """Return the table of academy games beside the thesis's published scores."""
    table = [["game", "env steps", "runs", "goals, ours", "GRF", "published goal difference, trained in GRF"]]
    kinds = sorted({(unique(rows, "game").index(row["game"]), int(row["budget"])) for row in rows})
    for game, budget in ((unique(rows, "game")[number], str(budget)) for number, budget in kinds):
        runs = results(mine := chosen(rows, game=game, budget=budget))
        rates = [percent(goal_rate(counts(runs, engine))) for engine in ENGINES]
        theirs = find_published(game.replace("academy/", "grf/"), "ppo")
        half = "" if theirs is None or theirs.interval is None else f" ± {theirs.interval:.2f}"
        published = f"{theirs.goal_difference:+.2f}{half}" if theirs else ""
        table.append([game, steps(mine), str(len(runs)), *rates, published])
    about = (
        "PPO trained in our simulator on the academy's levels without jitter, `simple115`, `scoring,checkpoints`, 128 "
        f"environments; {seeds(rows)}, {per_run(rows)}, actions sampled. No setting was tuned. {OVER_RUNS}; of one run "
        "over its episodes. Published: mean of the thesis's runs of 5M env steps, with 95% CI."
    )
    return f"{as_markdown(table)}\n\n{about}"


# ---------------------------------------------------------------- the summary


def of_policies(rows: Rows) -> list[list[str]]:
    """Return the summary lines of the policies: how many games transfer, and how many have exploits."""
    games = [game for game in unique(rows, "game") if any("**" in x for x in exploited(chosen(rows, game=game)))]
    named = f"{len(games)}: {', '.join(games)}" if games else "0"
    return [*verdicts(rows), ["Games with exploits, by the criterion below", named]]


def summary(files: dict[str, Rows]) -> str:
    """Return a line for each part with rows."""
    table = [["question", "result"]]
    if rows := files["policies"]:
        table += of_policies(rows)
    if rows := files["defense"]:
        table.append(["Defenses: goal difference in GRF minus ours", number(gaps(rows), "+")])
    if rows := files["converse"]:
        ours, grf = (
            goal_rate([Counted(int(r["goals"]), int(r["episodes"])) for r in chosen(rows, engine=e)]) for e in ENGINES
        )
        games, runs = len(unique(rows, "game")), len({(row["game"], row["seed"]) for row in rows})
        trained = f"Goals of PPO trained in GRF, {counted(games, 'game')}, {counted(runs, 'run')}"
        table.append([trained, f"{percent(grf)} in GRF, {percent(ours)} in our simulator"])
    if rows := files["scenes"]:
        same, own = (100 * over_scenes(rows, f"endings_agree{limit}", np.mean).estimate for limit in ("", "_limit"))
        table.append(["Drawn scenes: endings that agree", f"{same:.0f}%; GRF with itself {own:.0f}%"])
    if rows := files["experts"]:
        table.append(["Semi-expert programs: rank correlation of goals", number(ranks(rows))])
    return as_markdown(table) if len(table) > 1 else ""


# ---------------------------------------------------------------- pages

TABLES: dict[str, tuple[str, str, Callable[[Rows], str]]] = {  # name: CSV file, command, table
    "policies": ("transfer_policies.csv", "lab.transfer policies", policies),
    "exploits": ("transfer_policies.csv", "lab.transfer policies", exploits),
    "defense": ("transfer_defense.csv", "lab.transfer defense", defense),
    "converse": ("transfer_converse.csv", "lab.transfer converse", converse),
    "scenes": ("transfer_scenes.csv", "lab.transfer scenes", scenes),
    "experts": ("transfer_experts.csv", "lab.transfer experts", programs),
    "academy": ("academy_baselines.csv", "lab.academy_baselines", academy),
}
PAGES = ("TRANSFER.md", "BENCHMARK.md")
NOTHING = "No results for this simulator yet."


def load(path: Path) -> Rows:
    """Return the rows of a CSV file, none if the file is missing."""
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def filled(text: str, folder: Path = RESULTS) -> str:
    """Return a page with its tables made from the CSV files of a folder."""
    files = {name: load(folder / file) for name, (file, _, _) in TABLES.items()}

    def place(match: re.Match[str]) -> str:
        name = match[2]
        if name == "summary":
            return f"{match[1]}{summary(files) or NOTHING}\n{match[3]}"
        _, command, table = TABLES[name]
        if not (rows := files[name]):
            return f"{match[1]}{NOTHING} `python -m {command}` makes this table.\n{match[3]}"
        made = f"Simulator {', '.join(unique(rows, 'simulator'))}; `python -m {command}`."
        return f"{match[1]}{table(rows)} {made}\n{match[3]}"

    return PLACE.sub(place, text)


def write_tables(root: Path = ROOT, folder: Path = RESULTS) -> None:
    """Rewrite the tables of all pages."""
    for page in PAGES:
        write_text(root / page, filled((root / page).read_text(), folder))
