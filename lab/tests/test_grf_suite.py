"""`python -m lab.benchmarks --suite grf`: rows, stage, report, and that families can be measured and drawn."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from lab.benchmarks.__main__ import main
from lab.grf.measure import MEASURES
from lab.grf.report import FAMILIES, family_module, read_data, render_family
from lab.grf.rows import Row, by_distance, by_factor, by_share
from lab.grf.stage import Stage, keys, metres, units
from regista.envs.football.constants import CB, DIRECTION_RIGHT, IDLE, SHORT_PASS, STAND
from regista.envs.football.kick_off import Roster

DATA = Path(__file__).parents[1] / "grf" / "data"


def test_differences_are_in_the_terms_of_their_tolerance():
    assert by_share("f", "n", 5.5, 5.0, "m/s", 0.05).difference == pytest.approx(0.1)
    assert by_distance("f", "n", 0.01, -0.02, "units", 0.05).difference == pytest.approx(0.03)
    assert by_factor("f", "n", 4.0, 6.0, "", 0.5).difference == pytest.approx(0.5)
    assert by_factor("f", "n", 0.0, 6.0, "", 0.5).difference == math.inf


def test_the_page_beside_the_data_names_every_file_and_every_column():
    page = (DATA / "README.md").read_text()
    described = {
        cells[1].strip(" `"): cells for cells in (line.split("|") for line in page.splitlines()) if len(cells) == 6
    }
    paths = sorted(DATA.glob("*.csv"))
    assert {path.name for path in paths} == {name for name in described if name.endswith(".csv")}
    for path in paths:
        _, _, family, _, columns, _ = described[path.name]
        assert family.strip() in (*FAMILIES, *MEASURES)
        assert {f"`{column}`" for column in read_data(path.stem)[0]} <= set(re.findall("`[a-z_]+`", columns)), path.name


@pytest.mark.parametrize(("difference", "ok"), [(0.05, True), (0.051, False), (math.nan, False)])
def test_a_row_is_ok_within_its_tolerance(difference, ok):
    assert Row("f", "n", 1.0, 1.0, "", difference, 0.05).ok is ok


def test_the_stage_turns_y_round_and_mirrors_the_right_team_only_where_asked():
    roster = Roster([0, 1], [CB, CB])
    straight = Stage([(0.5, 0.1), (0.2, 0.1)], (0, 0), roster).trace().places[0, 0]
    mirrored = Stage([(0.5, 0.1), (0.2, 0.1)], (0, 0), roster, mirrored=True).trace().places[0, 0]
    np.testing.assert_allclose(straight, [(27.2, -8.36), (10.88, -8.36)])
    np.testing.assert_allclose(mirrored, [(27.2, -8.36), (-10.88, 8.36)])
    np.testing.assert_allclose(units(metres((0.3, -0.2))), (0.3, -0.2))


def test_who_is_told_to_stand_stands_even_beside_the_ball():
    trace = Stage([(0.0, 0.0), (0.3, 0.0)], (0.01, 0.0), Roster([0, 1], [CB, CB])).play([(STAND, STAND)] * 20)
    assert np.all(trace.places == trace.places[0])


def test_keys_are_sticky_and_everybody_has_his_own():
    stage = Stage([(-0.5, 0.1), (0.5, 0.1)], (0.0, 0.4), Roster([0, 1], [CB, CB]), n=3)
    trace = stage.play(keys((DIRECTION_RIGHT, 1), (IDLE, 9), others=(STAND,)))
    assert trace.places.shape == (11, 3, 2, 2)
    assert np.all(trace.places[-1, :, 0, 0] > trace.places[0, :, 0, 0] + 2.0)
    assert np.all(trace.places[-1, :, 1] == trace.places[0, :, 1])


def test_a_policy_sees_the_matches():
    stage = Stage([(0.0, 0.0), (0.3, 0.0)], (0.005, 0.0), Roster([0, 0], [CB, CB]), n=2)
    trace = stage.play(lambda now: (SHORT_PASS if now.matches.step[0] == 1 else IDLE, STAND), 12)
    assert np.all(trace.ball[-1, :, 0] > 1.0)


def test_a_policy_needs_a_number_of_steps():
    with pytest.raises(ValueError, match="how many steps"):
        Stage([(0.0, 0.0)], (0.0, 0.0), Roster([0], [CB])).play(lambda now: IDLE)


def test_every_family_says_what_it_is():
    for name in FAMILIES:
        module = family_module(name)
        assert module.TITLE and 0.0 < module.REQUIRED <= 1.0 and callable(module.measure) and callable(module.figure)


def test_a_table_counts_what_is_within_tolerance():
    rows = [by_share("motion", "a", 5.0, 5.0, "m/s", 0.05), by_share("motion", "b", 6.0, 5.0, "m/s", 0.05)]
    table = render_family("motion", rows)
    assert "MISSES" in table and table.endswith("1 of 2 within tolerance (wanted 2)")


@pytest.mark.long
def test_the_steady_speeds_are_the_originals():
    targets = {(row["keys"], row["ball"]): float(row["speed"]) for row in read_data("steady_speeds")}
    rows = [row for row in family_module("motion").measure(0.1) if row.name.startswith("steady")]
    assert len(rows) == len(targets) == 8
    assert all(row.ok for row in rows), [row for row in rows if not row.ok]


@pytest.mark.drawn
@pytest.mark.slow
@pytest.mark.long
def test_the_command_prints_json_and_draws(capsys, tmp_path):
    arguments = ["--suite", "grf", "--family", "motion", "--effort", "0.1", "--json"]
    assert main([*arguments, "--figures", str(tmp_path / "figures")]) == 0
    found = json.loads(capsys.readouterr().out)["results"]["motion"]
    assert all(row["family"] == "motion" for row in found)
    assert (tmp_path / "figures" / "motion.png").stat().st_size > 1000


def test_a_family_that_does_not_exist_is_named(capsys):
    assert main(["--suite", "grf", "--family", "motions"]) == 2
    assert "no 'motions'" in capsys.readouterr().err
    assert main(["--suite", "grf", "--measure", "--family", "keeper"]) == 2
    assert capsys.readouterr().err.startswith("regista: --family: no 'keeper', only academy, d")


@pytest.mark.long
def test_the_simulators_suite_prints_json(capsys):
    assert main(["--suite", "sim", "--num-envs", "4", "--seconds", "0.01", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["machine"]["cores"] >= 1
    assert all(row["steps_per_second"] > 0 for row in found["results"]["simulator"][1:])
