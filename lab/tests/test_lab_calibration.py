"""Fits of `lab/calibration` recover the numbers of synthetic data, and its laws equal the simulator's."""

import ast

import numba
import numpy as np
import pytest

from lab.calibration import blocks, claims, curls, duels, hands, knobs, saves, touches
from lab.calibration.__main__ import DATA, read, report
from lab.calibration.groups import GROUPS, group, numbers
from lab.calibration.profile import MOST, best_of, coordinate_search, row_loss
from lab.calibration.regression import bernoulli, binomial, fit, fit_fields, squares
from lab.calibration.scenes import Recording, kick_time
from lab.calibration.summary import PROFILES, lines, verdict
from lab.calibration.tables import MEASURES, TABLES
from lab.football_mutants import FOOTBALL
from lab.grf.stage import Stage
from regista.envs.football.constants import CB, CF, DIRECTION_RIGHT, GK, HALF_LENGTH, LEFT, RIGHT
from regista.envs.football.kick_off import Roster
from regista.envs.football.skills.first_touch import AT_REST, BRING_DOWN, bring_down, in_stride
from regista.envs.football.skills.hands import HOLD, PARRY, ease_of_holding
from regista.envs.football.skills.saves import SAVE, save_chance
from regista.envs.football.skills.tackles import chance_of_built_in

RNG = np.random.default_rng(0)


def recovers(law, names, losses, changed, within=4.0):
    """Return whether a fit from the shipped values finds the changed ones within a number of standard errors."""
    found = fit_fields(law, names, losses)
    wanted = np.array([getattr(changed, name) for name in names])
    assert np.isfinite(found.errors).all()
    return (np.abs(found.values - wanted) < within * found.errors + 1e-6).all()


def test_logistic_regression():
    x = RNG.normal(size=(4000, 2))
    happened = RNG.random(4000) < 1.0 / (1.0 + np.exp(-(0.5 + x @ [1.5, -1.0])))

    def losses(values):
        return bernoulli(1.0 / (1.0 + np.exp(-(values[0] + x @ values[1:]))), happened)

    found = fit(losses, [0.0, 0.0, 0.0])
    assert (np.abs(found.values - [0.5, 1.5, -1.0]) < 4.0 * found.errors).all()
    assert (found.errors < 0.1).all() and (found.errors > 0.02).all()


def test_least_squares_have_the_errors_of_the_textbook():
    rng = np.random.default_rng(0)  # a new generator: the numbers do not depend on earlier tests
    x = rng.normal(size=2000)
    y = 2.0 * x + 0.5 * rng.normal(size=2000)
    found = fit(lambda values: squares(y - values[0] * x, 0.5), [0.0])
    assert found.values[0] == pytest.approx((x @ y) / (x @ x), rel=1e-6)
    assert found.errors[0] == pytest.approx(0.5 / np.sqrt(x @ x), rel=0.1)


def test_shares_of_trials():
    chance, count = 0.3, np.full(50, 30.0)
    shares = RNG.binomial(30, chance, 50) / 30.0
    found = fit(lambda values: binomial(np.full(50, values[0]), shares, count), [0.5])
    assert found.values[0] == pytest.approx(shares.mean(), abs=1e-4)


def test_number_that_no_row_tells_has_no_error_and_bad_starts_are_refused():
    x = RNG.normal(size=100)
    found = fit(lambda values: squares(x - values[0] + 0.0 * values[1], 1.0), [1.0, 5.0])
    assert found.errors[1] == np.inf and found.values[1] == 5.0
    with pytest.raises(ValueError, match="losses at the start"):
        fit(lambda values: np.array([np.nan]), [1.0])


# ---------------------------------------------------------------- fits of laws to data drawn from them


def drawn_shots(count):
    """Draw effort, gap, time, in the box, and m before the line `[count, 5]`."""
    ranges = ((0.0, 8.0), (0.0, 4.0), (0.05, 1.0), (1.0, 1.0), (0.5, 8.0))
    return np.column_stack([RNG.uniform(low, high, count) for low, high in ranges])


def test_saves_are_recovered():
    changed = SAVE._replace(hands=8.0, halfway=0.3, effort=0.6, body=0.8)
    seen = drawn_shots(12000)
    saved = RNG.random(len(seen)) < saves.chances(changed, seen)
    assert recovers(SAVE, saves.NAMES, lambda law: saves.losses((seen, saved), law), changed)


def test_law_of_saves_is_the_simulators():
    seen = drawn_shots(200)
    stage = Stage([(0.0, 0.0), (1.0, 0.0)], (0.0, 0.0), Roster([LEFT, RIGHT], [CF, GK]))
    keeper = stage.matches[0].players[1]
    keeper.skill, keeper.y = SAVE.measured_skill, 0.0
    for shot, chance in zip(seen, saves.chances(SAVE, seen), strict=True):
        keeper.x = HALF_LENGTH - shot[4]
        assert save_chance(keeper, *shot[:3]) == pytest.approx(chance, abs=1e-9)


@pytest.mark.slow
def test_blocks_are_recovered():
    changed = blocks.BLOCK._replace(body=0.35, body_edge=0.7, leg=0.5)
    shots = np.column_stack([RNG.uniform(0.0, 1.6, 20000), RNG.uniform(0.02, 0.2, 20000)])
    stopped = RNG.random(len(shots)) < blocks.chances(changed, *shots.T)
    seen = np.column_stack([shots, stopped])
    found = fit_fields(blocks.LAW, blocks.NAMES, lambda law: blocks.losses(seen, law), 0.0)
    wanted = np.array([getattr(changed, name) for name in blocks.NAMES])
    assert found.values == pytest.approx(wanted, abs=0.06)


@pytest.mark.long
def test_parries_and_holds_are_recovered():
    run, came = RNG.normal(0.0, 4.0, (3000, 2)), RNG.normal((25.0, 0.0), 4.0, (3000, 2))
    met = np.column_stack([RNG.uniform(0.3, 2.0, 3000), np.linalg.norm(came, axis=1), run, came, np.zeros((3000, 4))])
    changed = PARRY._replace(run=2.0, back=0.15)
    met[:, 6:8] = hands.parried(changed, met) + RNG.normal(0.0, 0.5, (3000, 2))
    names = ("ball", "run", "back", "along")
    assert recovers(PARRY, names, lambda law: hands.parry_losses(met, law), changed)
    held = HOLD._replace(fits=0.3)
    met[:, 9] = RNG.random(3000) < 0.02 + 0.96 * hands.hold_chances(held, met)
    assert recovers(HOLD, ("fits", "surely"), lambda law: hands.hold_losses(met, law), held)
    ease = [ease_of_holding(shot[1], shot[0], HOLD.age) for shot in met]
    assert (hands.hold_chances(HOLD, met) > 0.0).tolist() == [value >= HOLD.from_ease for value in ease]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["at_rest", "brought_down"])
def test_first_touches_are_recovered(name):
    table = TABLES[name]
    law = touches.rest_law if name == "at_rest" else touches.pass_law
    along = RNG.uniform(-2.0, -0.1, 3000) if name == "at_rest" else RNG.uniform(-1.5, 6.0, 3000)
    seen = np.column_stack([along, RNG.uniform(-5.0, 5.0, 3000), np.full((3000, 1), 12.0), np.zeros((3000, 4))])
    changed = table.law._replace(**{table.names[0]: 1.2 * getattr(table.law, table.names[0])})
    seen[:, 3:] = law(changed, seen) + RNG.normal(0.0, 0.2, (3000, 4))
    assert recovers(table.law, table.names, lambda other: table.losses(seen, other), changed, within=5.0)


def test_laws_of_first_touches_are_the_simulators():
    stage = Stage([(0.0, 0.0)], (0.0, 0.0), Roster([LEFT], [CF]))
    player, ball = stage.matches[0].players[0], stage.matches[0].ball
    for kernel, law, numbers_, along in (
        (in_stride, touches.rest_law, AT_REST, -0.8),
        (bring_down, touches.pass_law, BRING_DOWN, 2.5),
    ):
        player.direction, player.vx, player.vy = DIRECTION_RIGHT, along, 3.0
        wanted = law(numbers_, np.array([[along, 3.0, 12.0, 0.0, 0.0, 0.0, 0.0]]))[0]
        kernel(ball, player)
        assert [player.vx, player.vy, ball.vx, ball.vy] == pytest.approx(wanted.tolist(), abs=1e-9)


def test_curls_are_recovered():
    seen = np.column_stack([RNG.uniform(-3.0, 3.0, 2000), RNG.uniform(12.0, 30.0, 2000), np.zeros((2000, 2))])
    seen[::3, 3] = 1.0
    changed = curls.FLIGHT._replace(curl=-250.0, high_bend=0.3)
    seen[:, 2] = curls.curl_law(changed, seen) + RNG.normal(0.0, 2.0, 2000)
    found = fit_fields(curls.FLIGHT, ("curl", "high_bend"), lambda law: curls.losses(seen, law))
    assert found.values == pytest.approx([-250.0, 0.3], rel=0.05)


def test_odds_of_keepers_and_backs_are_recovered():
    seen = np.column_stack([RNG.uniform(1.5, 8.0, 8000), RNG.uniform(0.2, 1.2, 8000), np.zeros(8000)])
    for law, changed, chances, name in (
        (claims.CLAIM, {"sure": 1.7}, claims.claim_chances, "claims"),
        (claims.FEET, {"chance": 0.8}, claims.feet_chances, "feet"),
        (duels.TACKLE, {"built_in_far": 1.2}, duels.chances, "duels"),
    ):
        wanted = law._replace(**changed)
        seen[:, 2] = RNG.random(len(seen)) < 0.02 + 0.96 * chances(wanted, seen)
        losses = TABLES[name].losses
        assert recovers(law, TABLES[name].names, lambda other, losses=losses: losses(seen, other), wanted)


def test_odds_of_backs_are_the_simulators():
    stage = Stage([(0.0, 0.0), (0.1, 0.0)], (0.0, 0.0), Roster([LEFT, RIGHT], [CF, CB]))
    match = stage.matches[0]
    match.players[1].skill, match.players[0].x, match.players[0].y, match.ball.y = SAVE.measured_skill, 0.0, 0.0, 0.0
    for speed, far in ((2.0, 0.5), (5.0, 0.5), (7.0, 0.9)):
        match.ball.x = far
        chance = chance_of_built_in(match, match.players[1], match.players[0], speed)
        assert duels.chances(duels.TACKLE, np.array([[speed, far, 0.0]]))[0] == pytest.approx(chance, abs=1e-9)


def test_stumbles_are_recovered():
    lies = np.arange(6)
    seen = np.column_stack([np.tile(3.0 - 0.9 * lies, (50, 1)), np.full(50, 0.3)])
    seen += RNG.normal(0.0, 0.01, seen.shape)
    table = TABLES["stumbles"]
    found = fit_fields(table.law, table.names, lambda law: table.losses(seen, law))
    assert found.values == pytest.approx([3.0, 0.3], abs=0.02)


def test_time_since_a_kick():
    ball = np.zeros((1, 2, 6))
    ball[0, 0, 3], ball[0, 1, 3:5] = 5.0, (25.0, 10.0)
    ball[0, 1, :2] = np.array([0.06 * 5.0, 0.0]) + 0.04 * np.array([25.0, 10.0])
    recording = Recording(ball, *[np.zeros(1)] * 7)
    assert kick_time(recording, 0, 1) == pytest.approx(0.04)


# ---------------------------------------------------------------- stored measurements, knobs and profiles


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize("name", TABLES)
def test_stored_measurements_can_be_fitted(name):
    rows = read(TABLES[name].source)
    assert len(rows) >= 100 and (DATA / f"{TABLES[name].source}.csv").stat().st_size < 200_000
    assert TABLES[name].source in MEASURES
    lines = report(TABLES[name], rows, rows).splitlines()
    assert all(line.rstrip().endswith("+0.0") for line in lines[3 : 3 + len(TABLES[name].names)])


def test_knobs_are_loads_of_their_shipped_values():
    which = knobs.parse("skills.saves.SAVE.body")
    turned = knobs.Turned([which])
    text = "from regista.envs.football.skills.saves import SAVE as ODDS\n"
    text += "def f(x):\n    return x * ODDS.body + ODDS.hands\n"
    tree = turned(FOOTBALL / "skills" / "hands.py", ast.parse(text))
    assert "x * _knob(" in ast.unparse(tree) and "ODDS.hands" in ast.unparse(tree)
    assert knobs.read(which) == SAVE.body
    address = knobs.VALUES.ctypes.data + 8 * knobs.place(which)

    @numba.njit
    def loaded():
        return knobs.knob(address)

    assert loaded() == SAVE.body
    knobs.turn(which, 0.5)
    assert loaded() == 0.5


def test_bad_knobs_are_refused():
    with pytest.raises(ValueError, match="a knob is called like"):
        knobs.parse("SAVE body")
    with pytest.raises(RuntimeError, match="before football is imported"):
        knobs.install([knobs.parse("skills.saves.SAVE.body")])
    with pytest.raises(ValueError, match="it has none"):
        knobs.in_source("skills.saves", "SAVE", "nothing")
    with pytest.raises(ValueError, match="a group is one of"):
        group("nothing")


@pytest.mark.slow
@pytest.mark.parametrize("name", GROUPS)
def test_groups_name_numbers_of_the_simulator(name):
    for each in map(knobs.parse, group(name)):
        value = knobs.in_source(each.module, each.name, each.field)
        assert (value[each.index] if each.index >= 0 else value) != 0.0
    assert numbers("skills.saves.SAVE.body") == ["skills.saves.SAVE.body"]


def test_coordinate_search_finds_the_least():
    wanted = (2.0, 0.5, -3.0)
    values, least = coordinate_search(
        lambda values: sum((value / best - 1.0) ** 2 for value, best in zip(values, wanted, strict=True)),
        (1.0, 1.0, -1.0),
    )
    assert values == pytest.approx(wanted, rel=0.05) and least < 0.01


def test_verdicts_on_shipped_values():
    assert verdict([2.0, 1.5, 1.2, 1.0, 1.2, 1.5, 2.0], 0.05) == "best"
    assert verdict([2.0, 1.5, 1.2, 1.04, 1.0, 1.5, 2.0], 0.05) == "near"
    assert verdict([2.0, 1.5, 1.2, 1.1, 1.0, 1.5, 2.0], 0.05) == "elsewhere"
    assert verdict([1.0, 1.0, 1.0, 1.01, 1.0, 1.0, 1.0], 0.05) == "undetermined"


def test_stored_profiles_are_of_groups():
    names = {path.stem for path in PROFILES.glob("*.csv")}
    assert names and names <= set(GROUPS)
    assert all(lines(path)[0].startswith(path.stem) for path in PROFILES.glob("*.csv"))


def test_best_value_of_a_profile():
    assert best_of((0.8, 0.9, 1.0, 1.1), (3.0, 1.02, 1.0, 2.0)) == (1.0, 0.9, 1.0)
    assert best_of((0.8, 0.9, 1.0, 1.1), (1.0, 1.0, 1.0, 1.0)) == (1.0, 0.8, 1.1)
    assert row_loss(0.2, 0.1) == pytest.approx(4.0)
    assert row_loss(np.nan, 0.1) == row_loss(5.0, 0.1) == MOST
