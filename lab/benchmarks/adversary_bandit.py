"""How well an adversary finds what is rare: θ pays 1 in a band of about 3 % of its mass, 0 elsewhere, under noise.

The band lies at the end of a range, at a quarter, in its middle, or there are two of them, which pay 1 and 0.7; or it
is the option of weight 1 among others of weight 25, listed first, in the middle or last. Five columns that pay nothing
stand beside. An adversary learns as in a football run of 1.5M steps: 90 times from 80 levels. By
`python -m lab.benchmarks.adversary_bandit`, which writes `adversary_bandit.csv` beside this file: of
each adversary, entropy coefficient and band the share of seeds whose last 1,000 proposals lie in it for at least a
quarter, and the mean of these shares. Read next: `ued.levels.theta_distribution`.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from ued.config import AdversaryConfig
from ued.core.parameters import Choice, Column, Parameter, Range, numbered, quantize
from ued.core.seeding import torch_generator
from ued.levels.adversary import Adversary

RESULTS = Path(__file__).with_suffix(".csv")
UPDATES, LEVELS = 90, 80
NOISE = 0.3  # standard deviation of what a level pays around its mean
BESIDE = 5  # columns that pay nothing
ENTROPIES, SEEDS = (0.03, 0.1), 20
FOUND = 0.25  # share of the proposals in the band
UNIMODAL = {"learning_rate": 1e-2, "update_epochs": 20}  # with which the Gaussian does best
ADVERSARIES = {"program": {}, "tanh_gaussian": UNIMODAL}
Pays = Callable[[np.ndarray], np.ndarray]  # θ [n, D] -> [n]


class Bandit(NamedTuple):
    """The columns of θ, and what θ pays."""

    draws: Sequence[Parameter]
    pays: Pays


def band(low: float, high: float, column: int = 0) -> Pays:
    """Pay 1 where the column lies between two numbers."""
    return lambda theta: ((theta[:, column] > low) & (theta[:, column] < high)).astype(float)


def options(*weights: float) -> Bandit:
    """Pay 1 for the option of the least weight."""
    choice = Choice(*range(len(weights)), weights=weights)
    place = choice.to_unit(int(np.argmin(weights)))
    return Bandit((Column("option", choice), *numbered("beside", BESIDE)), band(place - 1e-6, place + 1e-6))


def bandits() -> dict[str, Bandit]:
    """Return all bandits by name."""
    ranges = (Column("paid", Range(-1.0, 1.0)), *numbered("beside", BESIDE))
    bands = {"end": band(-1.01, -0.94), "quarter": band(-0.53, -0.47), "middle": band(-0.03, 0.03)}
    other = band(0.47, 0.53)
    rows = {name: Bandit(ranges, pays) for name, pays in bands.items()}
    rows["two bands"] = Bandit(ranges, lambda theta: bands["quarter"](theta) + 0.7 * other(theta))
    rows |= {"option first": options(1, 25, 25), "option middle": options(25, 1, 25), "option last": options(25, 25, 1)}
    return rows


def learned(bandit: Bandit, config: AdversaryConfig, seed: int, updates: int = UPDATES) -> tuple[np.ndarray, Adversary]:
    """Return the share of each update's proposals that pay, `[updates]`, and the adversary as it ended."""
    adversary, rng = Adversary(bandit.draws, config, torch_generator(seed)), np.random.default_rng(seed)
    shares = np.empty(updates)
    for update in range(updates):
        proposals = adversary.propose(LEVELS)
        paid = bandit.pays(quantize(adversary.theta(proposals), bandit.draws))
        shares[update] = (paid > 0).mean()
        adversary.learn(proposals, paid + NOISE * rng.normal(size=LEVELS))
    return shares, adversary


def main() -> int:
    """Measure all of it; write the table, and print it row by row."""
    torch.set_num_threads(1)
    with RESULTS.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["adversary", "ent_coef", "band", "seeds", "found", "share", "share_min", "share_max"])
        for name, settings in ADVERSARIES.items():
            for ent_coef in ENTROPIES:
                config = AdversaryConfig(distribution=name, ent_coef=ent_coef, **settings)  # type: ignore[arg-type]
                for place, bandit in bandits().items():
                    ends = [learned(bandit, config, seed)[0][-12:].mean() for seed in range(SEEDS)]
                    found = np.mean(np.array(ends) >= FOUND)
                    row = [f"{value:.3f}" for value in (found, np.mean(ends), min(ends), max(ends))]
                    table.writerow([name, ent_coef, place, SEEDS, *row])
                    file.flush()
                    print(name, ent_coef, place, *row, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
