"""What the simulator plays is what its version says: recorded scenes are played again and come out as they did.

Any change of play, observations or rewards fails here until `SIMULATOR_VERSION` is raised and the scenes are recorded
anew (`lab/record_football.py`). Refactoring, formatting and speed work pass: nothing of the source is looked at.

What is compared. 84 programs in 503 rows, with 2 to 22 players, all control modes, agents, built-in players and
library behaviors. In each step, exactly: mode, carrier, last touch, owner, score, cards, whom agents move, how the
episode ended and whether it succeeded. Every ten steps, to 0.01 mm: weighted means of the places of the ball and of the
players, and of the observations, and the sum of the rewards.

What processors do to it. Kernels are compiled without fast-math, so that LLVM neither fuses nor reorders operations:
plus, times, division and square roots are the same everywhere. Compiled for a processor without AVX and FMA
(`NUMBA_CPU_NAME=generic`), and not compiled at all, all rows come out the same, bit for bit. What differs is the
mathematical library: glibc 2.36 without FMA (`GLIBC_TUNABLES`) gives another last bit for less than 0.1% of sines,
cosines, exponentials, logarithms, arc functions and powers. That changes 3 of the rows, by at most 1e-13 m, until one
of them meets a decision that is nearly a tie: from there on it is another match.

So a row is compared only as far as nothing in it is near a threshold, by what `lab/record_football.py` has found: eight
copies with places up to 1e-7 m off at the start, or with noise of 1e-12 in each step, agree with it so far, and so do
three plays in which every result of the mathematical library is off by one unit in the last place. 449 rows are steady
to the end of their scenes, after 80 or 160 steps; two for less than 30.
"""

from __future__ import annotations

import numpy as np
import pytest

from regista.envs.football.config import CONTROL_MODES
from regista.envs.football.version import SIMULATOR_VERSION
from tests.envs import played
from tests.envs.played import EVERY, FILE, TOLERANCE, Change, Kept, Play

VERSION, SCENES = played.load()
COST = """\
{changed} of {rows} rows are played otherwise than simulator version {version} plays them:
{first}
If nothing was to change, this is a bug. If it was, raise SIMULATOR_VERSION in envs/football/version.py and record what
is played now: python -m lab.record_football --write
What a new version costs: Gymnasium ids end in the new number, and the old ones stop working; runs, demonstrations and
records of this version cannot be resumed, cloned or replayed; all published tables must be measured again."""
RECORD = "record what this version plays: python -m lab.record_football --write"


@pytest.fixture(scope="module")
def plays() -> list[Play]:
    """Return all scenes as they are played now."""
    return [played.play(kept.scene) for kept in SCENES]


def test_the_reference_is_of_this_version() -> None:
    assert VERSION == SIMULATOR_VERSION, f"{FILE} is of simulator version {VERSION}; {RECORD}"


@pytest.mark.slow
def test_what_is_played_is_what_this_version_plays(plays: list[Play]) -> None:
    pairs = list(zip(SCENES, plays, strict=True))
    found = [f"{kept.scene.name}, {change}" for kept, play in pairs for change in kept.changes(play)]
    rows = sum(len(kept.steady) for kept in SCENES)
    assert not found, COST.format(changed=len(found), rows=rows, version=VERSION, first="\n".join(found[:10]))


def test_the_reference_has_all_that_a_match_can_bring() -> None:
    """All control modes, team sizes and restarts; goals, cards and endings, in steps that are compared."""
    settings = [kept.scene.settings for kept in SCENES]
    controls = {str(each[name]) for each in settings for name in ("control", "right_control")}
    assert controls >= set(CONTROL_MODES) and controls & {"1", "2", "3"}
    sizes = {kept.scene.program.count(" = Left") + kept.scene.program.count(" = Right") for kept in SCENES}
    assert min(sizes) == 2 and max(sizes) == 22 and len(sizes) > 10
    facts = np.concatenate([kept.facts[:until, row] for kept in SCENES for row, until in enumerate(kept.steady)])
    modes, scores, cards, ends = set(facts[:, 0].tolist()), facts[:, 4:6], facts[:, 6], set(facts[:, 8].tolist())
    assert modes == {0, 2, 3, 4, 5, 6} and scores.max(0).min() > 0 and cards.max() > 0
    assert ends >= {0, 1, 2, 3, 4}
    steady = np.concatenate([kept.steady for kept in SCENES])
    assert np.mean(steady >= 30) > 0.95 and steady.min() >= EVERY
    assert FILE.stat().st_size < 100_000


# ---------------------------------------------------------------- the comparison


def one_row(steady: int) -> Kept:
    """Return a scene of one row of 20 steps in which nothing happens."""
    facts, digests = np.zeros((20, 1, len(played.FACTS)), int), np.zeros((2, 1, len(played.DIGESTS)))
    return Kept(SCENES[0].scene, facts, digests, np.array([steady]))


def test_a_row_is_compared_as_far_as_it_is_steady() -> None:
    kept = one_row(10)
    facts, digests = kept.facts.copy(), kept.digests.copy()
    assert kept.changes(Play(facts, digests)) == []
    facts[10, 0, 1], digests[1, 0, 0] = 3, 5.0
    assert kept.changes(Play(facts, digests)) == []
    digests[0, 0, 2] = 2 * TOLERANCE
    assert kept.changes(Play(facts, digests)) == [Change(0, 10, "observations", 0.0, 2 * TOLERANCE)]
    facts[8, 0, 1] = 3
    assert [str(change) for change in kept.changes(Play(facts, digests))] == ["row 0, step 9: carrier was 0, is 3"]
    digests[0, 0, 2] = np.nan
    assert len(kept.changes(Play(kept.facts, digests))) == 1


def test_a_file_gives_back_what_was_saved(tmp_path) -> None:
    path = tmp_path / "played.npz"
    played.save(7, SCENES[:3], path)
    version, again = played.load(path)
    assert version == 7 and [kept.scene for kept in again] == [kept.scene for kept in SCENES[:3]]
    for kept, other in zip(SCENES, again, strict=False):
        assert (kept.facts == other.facts).all() and (kept.steady == other.steady).all()
        assert np.abs(kept.digests - other.digests).max() < played.RESOLUTION


@pytest.mark.slow
def test_a_law_that_changes_is_noticed(plays: list[Play]) -> None:
    """A ball that has rolled 0.1 mm further than before, and a card that nobody had."""
    kept, play = SCENES[0], plays[0]
    digests, facts = play.digests.copy(), play.facts.copy()
    digests[0, 1, 0] += 1e-4
    facts[3, 2, 6] += 1
    assert [(change.row, change.step) for change in kept.changes(Play(facts, digests))] == [(1, 10), (2, 4)]
