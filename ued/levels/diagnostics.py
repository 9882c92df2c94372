"""Metrics of the levels of an update for every method: distribution, origins, success rates.

They show whether a curriculum collapses. If a teacher proposes few different levels, entropy and coverage are low; if
its levels are too hard, the success rate is low. `regret_split` shows the share of luck in the regret.
Read next: `methods.method`, which logs them in every update.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ued.core.cells import index_in
from ued.core.parameters import Parameter, choice_in
from ued.levels.record import Origin, mean_returns, solved

BINS = 10  # bins of each column of θ that is a real number
MOST_CHOICES, MOST_OPTIONS = 4, 8  # maximum numbers of choices and options with separate metrics


def level_metrics(levels: np.ndarray, draws: Sequence[Parameter] | None = None) -> dict[str, float]:
    """Return counts by origin, the spread of θ and the success rate of finished level records `[L]`.

    `draws` are the columns of θ; None: real numbers; empty: θ are codes, whose spread is meaningless.
    """
    counts = np.bincount(levels["origin"], minlength=len(Origin))
    metrics = {"levels": float(len(levels))}
    metrics |= {f"levels/{origin.name.lower()}": float(counts[origin]) for origin in Origin}
    if not len(levels):
        return metrics
    success = solved(levels)[:, 0]
    metrics["success"] = float(success[~np.isnan(success)].mean())
    score = levels["score"][~np.isnan(levels["score"])]
    if len(score):
        metrics["score"] = float(score.mean())
    theta = levels["level"]["theta"]
    if draws is not None and not len(draws):
        return metrics
    return metrics | theta_metrics(theta, draws)


def program_metrics(levels: np.ndarray, names: Sequence[str]) -> dict[str, float]:
    """Return the share of each program of a mixture among finished level records `[L]`, and its success rate."""
    metrics = {}
    for k, name in enumerate(names):
        mine = levels["level"]["program"] == k
        success = solved(levels[mine])[:, 0]
        played = success[~np.isnan(success)]
        metrics[f"program/{name}"] = float(mine.mean()) if len(levels) else np.nan
        metrics[f"program_success/{name}"] = float(played.mean()) if len(played) else np.nan
    return metrics


def theta_metrics(theta: np.ndarray, draws: Sequence[Parameter] | None = None) -> dict[str, float]:
    """Return metrics of the spread of θ `[L, D]`; empty for fewer than two levels.

    `draws` are the columns; None: real numbers. Each value of a choice is a bin, weighted by its probability; a real
    number has 10 bins. Only theta_std depends on the order of a choice's options.

    theta_std: mean of the columns' standard deviations; uniform levels have 0.58.
    theta_entropy: sum of the columns' entropies in nats, from histograms with Miller and Madow's correction (1955);
        random levels have D log 2, the largest value. The adversary's entropy bonus has the same unit.
    theta_coverage: share of bins with a level, divided by the expected share for the same number of random levels.
    """
    count, dim = theta.shape
    if not dim or count < 2:
        return {}
    index, shares = _binned(theta, draws)  # [L, D], [D, most bins]
    most = shares.shape[1]
    tally = np.bincount((index + most * np.arange(dim)).ravel(), minlength=dim * most).reshape(dim, -1)  # [D, most]
    share = tally / count
    relative = np.where(tally > 0, share, 1.0) / np.where(tally > 0, 2 * shares, 1.0)
    entropy = -np.sum(share * np.log(relative), 1) + ((tally > 0).sum(1) - 1) / (2 * count)
    reached = (tally > 0).sum() / (1 - (1 - shares) ** count).sum()
    return {
        "theta_std": float(theta.std(0).mean()),
        "theta_entropy": float(np.minimum(entropy, np.log(2)).sum()),
        "theta_coverage": float(min(reached, 1.0)),
    }


def _binned(theta: np.ndarray, draws: Sequence[Parameter] | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the bin `[L, D]` of each entry of θ, and for each column the share of random levels by bin `[D, most]`."""
    cells = [choice_in(draw) for draw in draws] if draws is not None else [None] * theta.shape[1]
    bins = np.array([BINS if known is None else known.count for known in cells])
    index = index_in(theta, bins)
    shares = np.where(np.arange(bins.max()) < bins[:, None], 1 / bins[:, None], 0.0)
    for column, known in enumerate(cells):
        if known is not None and known.edges is not None:
            index[:, column] = known.index(theta[:, column])
            shares[column, : known.count] = known.shares
    return index, shares


def choice_metrics(levels: np.ndarray, draws: Sequence[Parameter]) -> dict[str, float]:
    """Return metrics of scored level records `[L]` for each option of the first choices among `draws`.

    choice_ratio/COLUMN/OPTION: share of the option in the adversary's levels, divided by its weight in the program;
    below 1: rarer than in random levels. choice_score/COLUMN/OPTION: mean score of all levels with the option; nan
    without such a level.
    """
    theta, proposed = levels["level"]["theta"], levels["origin"] == Origin.PROPOSED
    metrics, known = (
        {},
        [(column, cells) for column, draw in enumerate(draws) if (cells := choice_in(draw)) is not None],
    )
    shown = [pair for pair in known if not pair[1].ordered and 1 < pair[1].count <= MOST_OPTIONS]
    for column, cells in shown[:MOST_CHOICES]:
        index = cells.index(theta[:, column])
        for k, weight in enumerate(cells.shares):
            where = f"{draws[column].name}/{cells.names[k] if cells.names else k}"
            mine = index == k
            share = mine[proposed].mean() if proposed.any() else np.nan
            metrics[f"choice_ratio/{where}"] = float(share / weight)
            metrics[f"choice_score/{where}"] = float(levels["score"][mine].mean()) if mine.any() else np.nan
    return metrics


def regret_split(levels: np.ndarray, has_antagonist: bool) -> dict[str, float]:
    """Return the mean regret of the adversary's levels among scored levels `[L]`, and its parts: skill and luck.

    With random outcomes, the best of several episodes exceeds their mean even between equal students. That part of the
    regret does not depend on the level. Skill is the mean return of student 1, the antagonist, minus that of student 0;
    without an antagonist, the best student's minus the mean of all. Means are over all levels, since the best student
    on a single level may be the best by luck. Luck is the rest.
    """
    levels = levels[levels["origin"] == Origin.PROPOSED]
    if not len(levels):
        return {}
    means, score = mean_returns(levels).mean(0), float(levels["score"].mean())
    skill = float(means[1] - means[0] if has_antagonist else means.max() - means.mean())
    return {"regret": score, "regret/skill": skill, "regret/luck": score - skill}
