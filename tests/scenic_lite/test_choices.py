"""What a choice tells of itself as a column of θ: its options and their shares, in the order of the program."""

import numpy as np
import pytest
from scene import things

from ued.core.parameters import cells_in, quantize

PROGRAM = """
aside = Discrete({Range(-25, -6): 25, Range(-2, 2): 1, Range(6, 25): 25})
again = resample(aside)
ego = Object at aside @ Uniform(1, 2, 3)
other = Object at again @ DiscreteRange(4, 8)
"""


def columns(program):
    return {draw.name: (index, draw, cells_in(draw)) for index, draw in enumerate(program.draws)}


def test_choices_tell_options_and_shares():
    known = columns(things(PROGRAM))
    for name in ("aside", "again"):
        _, draw, cells = known[name]
        assert draw.options == cells.names == ("-25 to -6", "-2 to 2", "6 to 25")
        assert cells.shares == pytest.approx(np.array([25, 1, 25]) / 51) and not cells.ordered
    plain = [
        cells for _, draw, cells in known.values() if draw.kind in ("choice", "integers") and cells.count in (3, 5)
    ]
    assert {(cells.count, cells.ordered) for cells in plain} == {(3, False), (5, True)}
    assert all(cells is None for _, draw, cells in known.values() if draw.kind == "range")


def test_the_middle_of_an_option_is_the_same_scene():
    program, rng = things(PROGRAM), np.random.default_rng(0)
    theta = rng.uniform(-1, 1, (500, program.dim))
    snapped = quantize(theta, program.draws)
    assert (program.instantiate(theta).positions == program.instantiate(snapped).positions).all()
    assert (snapped != theta).any(0).sum() == 4 and (quantize(snapped, program.draws) == snapped).all()


def test_elements_of_random_lists_have_no_fixed_options():
    """How many there are differs from scene to scene: θ has no cells."""
    program = things("items = Uniform([1, 2], [3, 4, 5])\nego = Object at Uniform(*items, 9) @ 0")
    kept = [draw for draw in program.draws if not draw.weights]
    assert [draw.kind for draw in program.draws] == ["choice", "choice"] and len(kept) == 1
    assert kept[0].options == () and cells_in(kept[0]) is None
