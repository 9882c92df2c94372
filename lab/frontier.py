"""Which methods learn where nearly all random levels are too hard? The table and the picture of the frontier.

Reads a comparison on `ued.probes:frontier` (40 core-minutes), prints its table, or writes it into RESULTS.md with the
picture `experiments/gallery/frontier.png`, and the rows of all runs into lab/results/frontier.csv. Beside it, the table
has the same comparison on another kind of processor (`--repeated`, rows in lab/results/frontier_repeated.csv):

    regista compare ued.probes:frontier --methods dr minimax paired_literal paired self_regret repaired plr robust_plr \
        accel --seeds 20 --levels 0 --no-record --out runs/frontier
    python -m lab.frontier runs/frontier --publish
    python -m lab.frontier runs/again --repeated --publish
    python -m lab.frontier                                    # the table of the stored rows
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from lab.studies.cells import percent
from regista.experiments.pictures import keys, plots
from regista.experiments.run import significance
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.report import as_markdown, write_text
from regista.experiments.run.table import read_columns, read_rows
from ued.probes import LONGEST
from ued.statistics import Bootstrap, Difference, Interval, bootstrap, detectable, iqm, probability_of_improvement

SCENE = "every length"  # one level of each length: its success rate is the share of turns that a student has learned
PAGE, PICTURE = Path("RESULTS.md"), Path("experiments/gallery/frontier.png")
ROWS, REPEATED = Path("lab/results/frontier.csv"), Path("lab/results/frontier_repeated.csv")
APART = 0.017  # gap between the final intervals of two methods, relative to the curves
NOTE = (
    "Differences in percentage points; IQM: mean of the middle half of the runs; P(better): probability that a run of "
    "the method knows more turns than one of dr. 95% CI: bootstrap over runs; of P(better), Newcombe's. Repeated: "
    "the same seeds on another kind of processor, where the last bits of numbers, and so single runs, differ."
)


def table(rates: Mapping[str, np.ndarray], repeated: Mapping[str, np.ndarray]) -> list[list[str]]:
    """Return a row for each method from the success rates `[R]` of its runs; the first method is the reference."""
    first, found, gains = next(iter(rates)), *estimates(rates)
    again, gains_again = estimates(repeated)
    marks = iter(significance.marks([*gains.values(), *gains_again.values()]))
    cells, cells_again = (
        {name: significance.points(gain, next(marks)) for name, gain in column.items()}
        for column in (gains, gains_again)
    )
    head = ["method", "turns known", "success", "IQM", f"minus {first}", f"P(better than {first})"]
    rows = [[*head, "success, repeated", f"minus {first}, repeated"]]
    for name, mine in rates.items():
        known = f"{LONGEST * found[name].estimate:.1f} of {LONGEST}"
        row = [name, known, percent(within(found[name].interval())), f"{iqm(mine):.0%}", cells.get(name, ""), ""]
        if name in gains:
            chance = probability_of_improvement(mine, rates[first])
            row[-1] = f"{chance.estimate:.2f} [{chance.low:.2f}, {chance.high:.2f}]"
        rows.append([*row, percent(within(again[name].interval())), cells_again.get(name, "")])
    return rows


def estimates(rates: Mapping[str, np.ndarray]) -> tuple[dict[str, Bootstrap], dict[str, Difference]]:
    """Return the mean of each method, and the difference of each but the first to the first."""
    first, *others = rates
    rng = np.random.default_rng(0)
    base = bootstrap(rates[first], rng)
    found = {name: bootstrap(mine, rng) for name, mine in rates.items()}
    return found, {name: (found[name] - base).difference() for name in others}


def note(rates: Mapping[str, np.ndarray], repeated: Mapping[str, np.ndarray]) -> str:
    """Return the note below the table."""
    counts = [len(mine) for mine in rates.values()]
    legend = significance.legend([gain.p for runs in (rates, repeated) for gain in estimates(runs)[1].values()])
    size = 100 * detectable(list(rates.values()))
    said = significance.sentences(legend, significance.visible([size], counts, "{:.0f} points"))
    return f"{NOTE} {counts[0]} runs of each method. {said}"


def within(interval: Interval) -> Interval:
    """Return the interval of a share, cut at 0 and 1."""
    return Interval(*np.clip(interval, 0.0, 1.0).tolist())


def draw(runs: Mapping[str, Sequence[Path]], path: Path) -> None:
    """Draw the success rate of each method over simulated steps: mean over runs, and the interval at the end."""
    with plots.style():
        import matplotlib.pyplot as plt

        figure, axes = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
        known = {name: evaluations(paths) for name, paths in runs.items()}
        last = max(steps[-1] for steps, _ in known.values())
        for place, (name, (steps, rates)) in enumerate(known.items()):
            axes.plot(steps, rates.mean(0), **plots.curve_look(name, len(runs)))
            end = bootstrap(rates[:, -1], np.random.default_rng(0)).interval()
            plots.whisker(axes, last * (1.025 + APART * place), end, name)
        plots.label_steps(axes)
        axes.set_ylabel("share of the turns known")
        plots.leave_room(axes, last, last * (1.035 + APART * len(runs)))
        plots.rate_axis(axes)
        handles = keys.method_handles(runs, (keys.MEAN, keys.WHISKER))
        figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8, handlelength=3)
        plots.save(figure, path)


def evaluations(paths: Sequence[Path]) -> tuple[np.ndarray, np.ndarray]:
    """Return the steps `[X]` of the evaluations of all runs, means over runs, and the success rates `[R, X]`."""
    tables = [read_columns(path / "metrics.csv") for path in paths]
    tested = [np.isfinite(columns[f"eval/{SCENE}"]) for columns in tables]
    count = min(int(mask.sum()) for mask in tested)
    steps, rates = (
        np.stack([columns[key][mask][:count] for columns, mask in zip(tables, tested, strict=True)])
        for key in ("env_steps", f"eval/{SCENE}")
    )
    return steps.mean(0), rates


def rates_of(path: Path) -> dict[str, np.ndarray]:
    """Return the success rates `[R]` of each method's runs, by method, from a table of results."""
    rates: dict[str, list[float]] = {}
    for row in read_rows(path):
        if row["scene"] == SCENE and row["updates"] != "0":
            rates.setdefault(row["method"], []).append(int(row["goals"]) / int(row["episodes"]))
    return {name: np.array(mine) for name, mine in rates.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", help="of a comparison; without: the stored rows")
    parser.add_argument("--repeated", action="store_true", help="it was made on another kind of processor")
    parser.add_argument("--publish", action="store_true", help="write the table into RESULTS.md, picture and rows")
    typed = parser.parse_args()
    files = {ROWS: ROWS, REPEATED: REPEATED}  # stored: read
    if typed.folder is not None:
        files[REPEATED if typed.repeated else ROWS] = typed.folder / "results.csv"
    rates, repeated = map(rates_of, files.values())
    text = f"{as_markdown(table(rates, repeated))}\n\n{note(rates, repeated)}"
    if not typed.publish:
        print(text)
        return
    page = re.sub("(<!-- frontier -->\n).*?(<!-- end -->)", rf"\g<1>{text}\n\g<2>", PAGE.read_text(), flags=re.DOTALL)
    write_text(PAGE, page)
    for stored, read in files.items():
        if read != stored:
            write_text(stored, read.read_text())
    if typed.folder is not None and not typed.repeated:
        folders = [RunFolder.open(path.parent) for path in sorted(typed.folder.glob("*/config.json"))]
        draw({name: [run.path for run in folders if run.config.method == name] for name in rates}, PICTURE)


if __name__ == "__main__":
    main()
