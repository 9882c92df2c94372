"""Whatever the text, `load` gives a Program or a ScenicError inside the text, soon; and a Program gives scenes."""

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.scenic_lite.fuzzing import Writer, attempt, corpus, mutated, soup, written

TEXTS = corpus()


def no_fault(text, dialect):
    result = attempt(text, dialect)
    assert not result.startswith("FAULT"), f"{result}\n{text}"


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(seed=st.integers(0, 10**9), dialect=st.sampled_from((2, 3)))
@pytest.mark.parametrize("make", [mutated, lambda rng, _: soup(rng), lambda rng, _: Writer(rng).program()])
def test_programs_nobody_would_write(make, seed, dialect):
    no_fault(make(random.Random(seed), TEXTS), dialect)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(text=st.text(max_size=60), dialect=st.sampled_from((2, 3)))
def test_any_text(text, dialect):
    no_fault(text, dialect)


@pytest.mark.long
def test_many_programs_nobody_would_write():
    for i in range(3000):
        rng = random.Random(f"slow {i}")
        no_fault(written(rng, TEXTS), rng.choice((2, 3)))
