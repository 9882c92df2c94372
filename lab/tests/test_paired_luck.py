"""The table of common random numbers: shares of variance by game, and their range over runs."""

from lab.paired_luck import removed


def row(seed, same, other):
    return {"game": "1v1Rare", "seed": seed, "same": same, "other": other, "regret_2_same": 3.0, "regret_2_other": 2.0}


def test_shares_are_of_mean_variances_and_their_range_is_over_runs():
    rows = [row("1000", 0.5, 1.0), row("1000", 1.0, 1.0), row("1001", 1.5, 2.0)]
    *_, cells = removed(rows)
    assert cells == "| 1v1Rare | 25% (25 to 25%) | -50% (-50 to -50%) |"
    rows += [row("1002", 1.0, 1.0)]
    *_, cells = removed(rows)
    assert cells.startswith("| 1v1Rare | 19% (0 to 25%) |")  # variances of runs: 0.75 of 1, 1.5 of 2, 1 of 1
