"""Shots past a lone back, compared with GRF's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lab.grf import blocks


@pytest.mark.parametrize(
    ("speeds", "outcome"),
    [
        ([0.0, 3.0, 3.0, 20.0, 24.0, 23.0, 22.0], (0.0, 1.0)),
        ([0.0, 3.0, 3.0, 12.0, -14.0, -13.0, -12.0], (1.0, 0.0)),
        ([0.0, 3.0, 3.0, 4.0, 4.0, 4.0, 4.0], (0.0, 0.0)),
    ],
    ids=["past", "stopped", "no shot"],
)
def test_what_becomes_of_a_shot_is_seen_two_steps_after_it(speeds: list[float], outcome: tuple[float, float]) -> None:
    ball = np.zeros((3, blocks.LASTS + 1, 3))
    ball[:, 1 : len(speeds) + 1, 0] = np.cumsum(speeds) / 10.0
    episodes = replace(next(blocks.shootings()).play(), ball=ball, lengths=np.full(3, len(speeds)))
    assert blocks.what_becomes(episodes, 2) == outcome


@pytest.mark.slow
@pytest.mark.long
def test_every_row_holds() -> None:
    rows = blocks.measure()
    assert [row.name for row in rows] == ["a shot stopped", "a shot gets past"]
    assert all(row.ok for row in rows)
