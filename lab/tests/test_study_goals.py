"""Tables of the thesis's benchmark: ours beside published numbers."""

import math

import pytest

from lab.studies import goals, tables
from lab.studies.rows import Row, add
from regista.minigames.published import find_published

GAMES = ("defense/2vs2", "defense/2vs2_counterattack", "defense/2vs2_high_pass", "offense/11_vs_gk")


def made(game, goal_difference, scene="train", seed=0, agent="ppo", control="closest1"):
    return Row(game, agent, control, scene, seed, 100, 50, goal_difference, 0.5, 20, 10, 30.0, 1.0, "abc", "1")


def published(game, agent="ppo", split="train"):
    return find_published(game, agent, split).goal_difference


def test_a_random_policy_is_a_column_and_published_numbers_stand_beside_ours():
    rows = [made(GAMES[0], -0.25, seed=seed) for seed in range(5)] + [made(GAMES[0], -0.5, "test")]
    rows += [made(GAMES[0], -0.9, agent="random"), made(GAMES[0], -0.7, "test", agent="random")]
    head, row = goals.goals_table(rows)
    cells = dict(zip(head[:6], row[:6], strict=True))
    assert cells["train"].startswith("-0.25 [-0.") and cells["published"] == "-0.13 ± 0.06"
    assert (cells["random"], row[6].split()[0], row[8:]) == ("-0.90", "-0.50", ["-0.70", "5", "100"])


def test_teams_have_a_table_of_their_own_and_the_published_numbers_of_their_players():
    rows = [made(GAMES[3], 0.5), *(made(GAMES[3], 0.1, agent="team_ppo", control=control) for control in ("2", "3"))]
    rows.append(made(GAMES[3], 0.02, agent="random", control="2"))
    one, teams = goals.of_one_agent(rows), goals.of_teams(rows)
    assert one.count("offense/11_vs_gk") == 1
    lines = [line.split(" | ") for line in teams.splitlines() if "11_vs_gk" in line]
    assert [(line[1], line[4], line[5]) for line in lines] == [
        ("2", "+0.12 ± 0.04", "+0.02"),
        ("3", "+0.11 ± 0.05", ""),
    ]


def test_a_study_without_teams_leaves_their_page_alone(tmp_path):
    add(tmp_path / "thesis.csv", [made(GAMES[3], 0.5)])
    tables.publish_teams(tmp_path, "thesis", tmp_path / "teams.md")
    assert not (tmp_path / "teams.md").exists()
    add(tmp_path / "thesis.csv", [made(GAMES[3], 0.1, agent="team_ppo", control="2")])
    tables.publish_teams(tmp_path, "thesis", tmp_path / "teams.md")
    assert "| offense/11_vs_gk | 2 | team_ppo |" in (tmp_path / "teams.md").read_text()


@pytest.mark.slow
def test_agreement_with_published_numbers_is_told_over_games():
    shifts = dict(zip(GAMES, (0.0, 0.01, -0.01, 0.6), strict=True))
    rows = [made(game, published(game) + shift, seed=seed) for game, shift in shifts.items() for seed in range(5)]
    games, correlation, difference, apart = goals.agreement(rows, "ppo", "train")
    assert (games, correlation) == ("4", "1.00 [1.00, 1.00]")
    assert float(difference) == pytest.approx(0.155, abs=0.006) and apart == "1 of 4"
    assert goals.agreement(rows[:15], "ppo", "train") == []
    assert "one agent, training scenes | all | 4 | 1.00 [1.00, 1.00] |" in goals.of_one_agent(rows)


def test_random_teams_are_not_compared_with_published_random_agents():
    rows = [made(game, -0.5, "test", agent="random") for game in GAMES[:3]]
    rows += [made(game, -0.9, "test", agent="random", control="all") for game in GAMES[:3]]
    assert goals.agreement([*rows, *rows], "random", "test") == []
    assert [
        goals.cell(rows, GAMES[0], control, "random", "test").published is None for control in ("closest1", "all")
    ] == [
        False,
        True,
    ]


def test_a_difference_is_measured_against_both_intervals():
    known = find_published(GAMES[3], "ppo")
    rows = [made(game, published(game), seed=seed) for game in GAMES[:3] for seed in range(5)]
    wide = [made(GAMES[3], known.goal_difference + known.interval * 0.9, seed=seed) for seed in range(5)]
    assert goals.agreement(rows + wide, "ppo", "train")[-1] == "0 of 4"
    assert math.isclose(goals.cell(wide, GAMES[3], "closest1", "ppo", "train").published.interval, known.interval)
