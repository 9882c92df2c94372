"""Ranks that are mended are those that sorting gives."""

import numpy as np

from ued.levels.ranking import Ranking


def test_ranks_are_those_of_sorting():
    rng, ranking, scores = np.random.default_rng(0), Ranking(), np.zeros(0)
    for step in range(400):
        new = int(rng.integers(0, 4)) if len(scores) < 400 else 0
        changed = set(rng.integers(0, len(scores), rng.integers(0, 7)).tolist()) if len(scores) else set()
        changed |= set(range(len(scores), len(scores) + new))
        scores = np.append(scores, np.zeros(new))
        scores[list(changed)] = rng.integers(0, 5, len(changed)) / 4  # many are equal
        order = ranking.update(scores, changed)
        assert order.tolist() == np.argsort(-scores, kind="stable").tolist(), step
