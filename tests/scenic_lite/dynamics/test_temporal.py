"""Temporal formulas: what is known after each step, the end, and what the first step must satisfy."""

import ast

import numpy as np
import pytest

from scenic_lite import ScenicError, load
from scenic_lite.language.requirements import Check, Settled, formula_of
from scenic_lite.syntax.parser import parse

FORMULAS = {
    # formula over p, q: what is known after each step of (p, q) = 10, 10, 01, 00
    "always p": "ttFF",
    "eventually q": "ffTT",
    "p until q": "ffTT",
    "q until p": "TTTT",
    "next p": "fTTT",
    "next q": "fFFF",
    "next (next q)": "ffTT",
    "not (next p)": "tFFF",
    "p implies (eventually q)": "ffTT",
    "q implies (always p)": "TTTT",
    "always (p or q)": "tttF",
    "always (p implies (next (p or q)))": "fftt",
    "(eventually q) and (always (p or q))": "fftF",
    "(always p) or (eventually q)": "ttTT",
    "not (always p)": "ffTT",
    "not (eventually q)": "ttFF",
    "always (eventually p)": "ttff",
    "eventually (always (not p))": "fftt",
}
STEPS = ((True, False), (True, False), (False, True), (False, False))


def letter(watch):
    """Return what is known of a requirement: T or F once that is settled, t or f what it is if the episode ends now."""
    known = "t" if watch.holds else "f"
    return known.upper() if isinstance(watch.rest, Settled) else known


def condition(text):
    return parse(f"require {text}", "<test>", 3).body[0].condition


def holds(expression, p, q):
    """Return the truth of an operand without temporal operators."""
    if isinstance(expression, ast.Name):
        return {"p": p, "q": q}[expression.id]
    if isinstance(expression, ast.UnaryOp):
        return not holds(expression.operand, p, q)
    assert isinstance(expression.op, ast.Or)
    return any(holds(each, p, q) for each in expression.values)


@pytest.mark.parametrize(("text", "known"), FORMULAS.items())
def test_what_is_known_after_each_step(text, known):
    watch = Check(formula_of(condition(text)))
    found = ""
    for p, q in STEPS:
        watch.step(lambda part, p=p, q=q: holds(part, p, q))
        found += letter(watch)
    assert found == known
    assert watch.holds == (known[-1] in "tT")


def test_every_operand_is_evaluated_at_most_once_in_a_step():
    seen = []
    watch = Check(formula_of(condition("always (p until q)")))
    for _ in range(3):
        watch.step(lambda part: seen.append(part.id) or True)
    assert sorted(seen) == ["p"] * 3 + ["q"] * 3


@pytest.mark.parametrize(
    ("text", "share"),
    [
        ("always ego.position.y < 4", 0.4),
        ("eventually ego.position.y > 4", 1.0),
        ("(ego.position.y > 4) until (ego.position.y > 9)", 1.0),
        ("not (eventually ego.position.y > 4)", 0.4),
        ("(always ego.position.y > 2) and (next ego.position.y > 100)", 0.8),
        ("(ego.position.y > 5) implies (always ego.position.y > 7)", 0.8),
    ],
)
def test_scenes_that_a_formula_rules_out_at_once(text, share):
    program = load(f"ego = new Object at 0 @ Range(0, 10)\nrequire {text}", dialect=3)
    ok = program.instantiate(np.linspace(-1, 1, 1001)[:, None]).ok
    assert ok.mean() == pytest.approx(share, abs=0.01)


def test_a_temporal_requirement_has_no_probability():
    with pytest.raises(ScenicError, match="a temporal requirement cannot have a probability"):
        load("ego = new Object\nrequire[0.5] always ego.position.y < 4", dialect=3)
