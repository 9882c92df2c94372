"""How well does an adversary find rare levels? θ is rewarded with 1 in a band of about 3% of its mass, 0 elsewhere.

Rewards are noisy. The band lies at the end of a range, at a quarter or in its middle; or there are two bands, with
rewards 1 and 0.7. In the option bandits, it is the option of weight 1 among others of weight 25, listed first, in the
middle or last. Five further columns have no effect on the reward. An adversary learns as in a football run of 1.5M
steps: 90 updates from 80 levels each.

`python -m lab.benchmarks.adversary_bandit` writes `adversary_bandit.csv` beside this file. It has a row for each
adversary, entropy coefficient and band. A row has the share of seeds with at least a quarter of the last 1,000
proposals in the band, and the mean of these shares. Read next: `ued.levels.theta_distribution`.
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
NOISE = 0.3  # standard deviation of a level's reward around its mean
BESIDE = 5  # columns without effect on the reward
ENTROPIES, SEEDS = (0.03, 0.1), 20
FOUND = 0.25  # share of proposals in the band from which a seed counts as a success
UNIMODAL = {"learning_rate": 1e-2, "update_epochs": 20}  # the best settings for the Gaussian
ADVERSARIES = {"program": {}, "tanh_gaussian": UNIMODAL}
Pays = Callable[[np.ndarray], np.ndarray]  # θ [n, D] -> rewards [n]


class Bandit(NamedTuple):
    """The columns of θ, and the reward function of θ."""

    draws: Sequence[Parameter]
    pays: Pays


def band(low: float, high: float, column: int = 0) -> Pays:
    """Reward 1 if the column lies between two numbers."""
    return lambda theta: ((theta[:, column] > low) & (theta[:, column] < high)).astype(float)


def options(*weights: float) -> Bandit:
    """Reward 1 for the option with the smallest weight."""
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
    """Return the share of rewarded proposals in each update, `[updates]`, and the final adversary."""
    adversary, rng = Adversary(bandit.draws, config, torch_generator(seed)), np.random.default_rng(seed)
    shares = np.empty(updates)
    for update in range(updates):
        proposals = adversary.propose(LEVELS)
        paid = bandit.pays(quantize(adversary.theta(proposals), bandit.draws))
        shares[update] = (paid > 0).mean()
        adversary.learn(proposals, paid + NOISE * rng.normal(size=LEVELS))
    return shares, adversary


def main() -> int:
    """Run all measurements, write the table, and print it row by row."""
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
