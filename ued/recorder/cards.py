"""Texts of a recording, in Markdown: cards of levels, of chosen levels, and of recorded episodes.

Read next: `recorder.recorder`, which writes them; `levels.scores`, the formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ued.levels.batch import LevelBatch
from ued.levels.record import NONE

Values = Callable[[np.ndarray], np.ndarray]  # columns of θ in the units of the parameters, see `ThetaLog.values`

# By rule: its name, its formula, and the columns of `LevelBatch.outcomes` whose numbers the formula contains.
FORMULAS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "max_mc": ("MaxMC", "best return ever − mean value of the critic", ("best_ever", "value")),
    "positive_value_loss": ("positive value loss", "mean of max(A, 0) over steps", ("positive_advantage",)),
    "l1_value_loss": ("L1 value loss", "mean of |A| over steps", ("absolute_advantage",)),
    "learnability": ("learnability", "p (1 − p), p the success rate, unbiased", ()),
    "generalized_learnability": ("learnability of returns", "std of returns × density of their mean", ()),
    "mna": ("MNA", "sum of −A over steps, 0 if never solved", ()),
}

# By the definition of regret: its minuend and subtrahend.
REGRETS = {
    "population max_mean": "best episode − mean of all episodes",
    "population mean_mean": "mean of the best student − mean of all episodes",
    "flexible max_mean": "best episode − mean of the other student",
    "flexible mean_mean": "mean of the better student − mean of the other",
    "dennis2020 max_mean": "best episode of the antagonist − mean of the protagonist",
    "dennis2020 mean_mean": "mean of the antagonist − mean of the protagonist",
}
BEST = "best of this visit"  # not the best return ever, which MaxMC uses


def formula(batch: LevelBatch, level: int, rule: str) -> str:
    """Return a line that explains the score of a level; empty without a score or a rule.

    `rule` is a rule of `levels.scores`, a definition of regret in `REGRETS`, or the name of a function.
    """
    score = batch.score[level]
    if not rule or not np.isfinite(score):
        return ""
    if rule in REGRETS:
        name, text, terms = "regret", REGRETS[rule], regret_terms(batch.records["returns"][level], rule)
        if not np.isclose(terms[0] - terms[1], score, atol=0.005):  # the score was clipped at 0
            terms = []
    else:
        name, text, columns = FORMULAS.get(rule, (rule, "your function", ()))
        outcomes = batch.outcomes()
        terms = [outcomes[column][level] for column in columns if column in outcomes]
    found = [f"{term:.2f}" for term in terms]
    numbers = [f"({number})" if number.startswith("-") else number for number in found]
    told = f"**{name}** = {text} = "
    return told + (f"{' − '.join(numbers)} = " if len(numbers) > 1 else "") + f"**{score:.2f}**"


def regret_terms(returns: np.ndarray, rule: str) -> list[float]:
    """Return minuend and subtrahend of the regret of a level, from the returns `[S, n]` of its students."""
    roles, kind = rule.split()
    means = np.nanmean(returns, 1)  # [S]
    best = np.nanmax(returns, 1) if kind == "max_mean" else means
    if roles == "population":
        return [float(best.max()), float(np.nanmean(returns))]
    better = 1 if roles == "dennis2020" or best[1] >= best[0] else 0
    return [float(best[better]), float(means[1 - better])]


def by_score(batch: LevelBatch, most: int) -> np.ndarray:
    """Return the indices of the levels with the highest scores, best first, at most `most`.

    If a level was visited several times, only the visit with the highest score counts.
    """
    order = np.argsort(-np.nan_to_num(batch.score, nan=-np.inf), kind="stable")
    _, first = np.unique(batch.records["id"][order], return_index=True)
    return order[np.sort(first)][:most]


def level_card(update: int, batch: LevelBatch, names: Sequence[str], values: Values, rule: str = "") -> str:
    """Describe the level with the highest score: its score by `rule`, returns, and θ by the `names` of its columns."""
    score, level = batch.score, by_score(batch, 1)[0]
    quantiles = (np.quantile(batch.theta, share, 0) for share in (0.1, 0.9))
    low, value, high = map(values, (next(quantiles), batch.theta[level], next(quantiles)))  # [D] each
    best = batch.best
    returns = "\n".join(
        f"| {name} | {means[level]:+.2f} | {best[name][level]:+.2f} | {batch.episodes[name][level]} |"
        for name, means in batch.returns.items()
    )
    rows = "\n".join(f"| {name} | {value[d]:.2f} | {low[d]:.2f} to {high[d]:.2f} |" for d, name in enumerate(names))
    title = f"score {score[level]:.3f}, the highest of {len(score)}" if np.isfinite(score[level]) else "one level"
    parts = [
        f"**Update {update}: {title}**",
        origin(batch, level).capitalize(),
        formula(batch, level, rule),
        f"| student | return | {BEST} | episodes |\n|---|---|---|---|\n{returns}",
        f"| θ | value | batch, 10% to 90% |\n|---|---|---|\n{rows}",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def slot_card(batch: LevelBatch, level: int, rule: str = "") -> str:
    """Describe a level in a few short lines: number, source, score, visits, and returns of the students."""
    best = batch.best
    lines = [f"**{origin(batch, level)}**"]
    if np.isfinite(batch.score[level]):
        lines.append(formula(batch, level, rule) or f"score {batch.score[level]:.2f}")
    visits = int((batch.records["id"] == batch.records["id"][level]).sum())
    if visits > 1:
        lines.append(f"the highest score of {visits} visits in this update")
    for name, means in batch.returns.items():
        lines.append(f"{name}: return {means[level]:+.2f}, {BEST} {best[name][level]:+.2f}")
    return "\n\n".join(lines) + "\n"


def origin(batch: LevelBatch, level: int) -> str:
    """Return the number of a level and its origin."""
    record = batch.records[level]
    parent = f" from {record['parent']}" if record["parent"] != NONE else ""
    return f"level {record['id']}, {batch.source[level]}{parent}"


def aim_card(batch: LevelBatch, names: Sequence[str], values: Values) -> str:
    """Describe the levels chosen by the teacher, all except random ones."""
    chosen = np.isin(batch.source, ("proposed", "replayed", "edited"))
    sources = ", ".join(f"{int((batch.source == name).sum())} {name}" for name in dict.fromkeys(batch.source))
    if not chosen.any():
        return f"{sources}: no level was chosen"
    low, middle, high = values(np.quantile(batch.theta[chosen], [0.1, 0.5, 0.9], axis=0))
    spread = batch.theta[chosen].std(0) / np.sqrt(1 / 3)  # relative to the deviation of the uniform distribution
    rows = "\n".join(
        f"| {name} | {low[d]:.2f} | {middle[d]:.2f} | {high[d]:.2f} | {spread[d]:.0%} |" for d, name in enumerate(names)
    )
    head = "| θ of the chosen levels | 10% | median | 90% | spread / random levels |\n|---|---|---|---|---|"
    return f"### {sources}\n\n{head}\n{rows}\n"


def episodes_card(outcome: str, ends: Sequence[str], lengths: Sequence[int]) -> str:
    """Describe recorded episodes: a text, and a row for each with its outcome and its length in steps."""
    rows = "\n".join(f"| {k + 1} | {end} | {steps} |" for k, (end, steps) in enumerate(zip(ends, lengths, strict=True)))
    text = "\n\n".join(outcome.split("\n"))
    return f"{text}\n\n| episode | outcome | steps |\n|---|---|---|\n{rows}\n"
