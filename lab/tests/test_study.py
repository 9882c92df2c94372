"""`python -m lab.studies`: its runs, how it continues, and its output files."""

from pathlib import Path

import numpy as np
import pytest

from lab.studies import rows, runs, tables
from lab.studies.__main__ import main
from lab.studies.benchmark_study import (
    FIGURE_2_7,
    PAIRS,
    BenchmarkStudy,
    BenchmarkStudyConfig,
    places_of,
    starting_point,
)
from lab.studies.measuring import measure_random
from regista.experiments.commands.train import train
from regista.experiments.run import build
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch import workers
from regista.experiments.run.launch.signals import StopRequest
from regista.experiments.run.results import mean_return
from regista.minigames.suites import BENCHMARK
from tests.floors import ROOT

pytestmark = pytest.mark.slow

# ---------------------------------------------------------------- the thesis's benchmark

TWO = ["offense/easy_crossing", "grf/run_to_score_with_keeper"]


@pytest.fixture
def single(begun, tmp_path):
    """Return the command line, and the names of the runs that it has begun."""
    words = ["--out", str(tmp_path)]
    short = ["--total-env-steps", "64", "--num-envs", "4", "--num-steps", "8", "--episodes", "6", "--processes", "1"]
    return ["generalization", "--games", *TWO, "--seeds", "1", *short, *words], begun


def test_a_benchmark_is_measured_and_its_rows_are_tabulated_beside_published_ones(single, tmp_path, capsys):
    words, begun = single
    assert main(words) == 0
    text = capsys.readouterr().out
    assert begun == ["offense_easy_crossing-features-0", "grf_run_to_score_with_keeper-features-0"]
    config = RunFolder.open(tmp_path / "fast" / begun[1]).config
    assert config.env.rewards == "scoring" and config.env.control == "closest1"  # as published, not the best
    found = rows.load(tmp_path / "results" / "fast.csv")
    agents = {(row.game, row.agent, row.scene) for row in found}
    assert agents == {
        (game, agent, scene) for game in TWO for agent in ("ppo", "random") for scene in ("train", "test")
    } | {(TWO[1], "expert", "train")}
    for row in found:
        assert row.episodes == 6 and row.scored + row.conceded <= 6
        assert row.goal_difference == pytest.approx((row.scored - row.conceded) / 6, abs=1e-5)
        assert (row.env_steps, row.seconds > 0) == ((64, True) if row.agent == "ppo" else (0, False))
    assert "| offense/easy_crossing | closest1 | ppo |" in text and "| 1 | 64 |" in text
    assert "simulator version 1; `python -m lab.studies.tables fast`." in text
    (easy,) = (line for line in text.splitlines() if line.startswith("| offense/easy_crossing | closest1 | ppo |"))
    told = page_cells(easy)
    assert (told[4], told[7]) == ("+0.52 ± 0.12", "+0.01 ± 0.03")


@pytest.mark.long
def test_what_is_in_the_tables_is_not_made_again_and_more_seeds_are_added(single, tmp_path):
    words, begun = single
    assert main(words) == 0
    before = (tmp_path / "results" / "fast.csv").read_text()
    for path in (tmp_path / "fast").rglob("*.pt"):
        path.unlink()  # on another machine, only the tables exist
    assert main(words) == 0
    assert len(begun) == 2 and (tmp_path / "results" / "fast.csv").read_text() == before
    words[words.index("--seeds") + 1] = "2"
    assert main(words) == 0
    assert begun[2:] == ["offense_easy_crossing-features-1", "grf_run_to_score_with_keeper-features-1"]
    again = (tmp_path / "results" / "fast.csv").read_text()
    assert set(before.splitlines()) < set(again.splitlines()) and len(again.splitlines()) == 1 + 9 + 4


def test_teams_are_moved_as_the_games_have_it(single, tmp_path, capsys):
    words, begun = single
    words[:4] = ["multi", "--games", "offense/hard_crossing"]
    assert main(words) == 0
    assert begun == ["offense_hard_crossing-allNonGK-features-0"]
    found = rows.load(tmp_path / "results" / "fast.csv")
    assert {(row.agent, row.control) for row in found} == {("team_ppo", "allNonGK"), ("random", "allNonGK")}
    text = capsys.readouterr().out
    (team,) = (line for line in text.splitlines() if line.startswith("| offense/hard_crossing | allNonGK | team_ppo |"))
    assert page_cells(team)[4] == "-0.02 ± 0.06" and page_cells(team)[-2:] == ["1", "64"]
    assert main(words) == 0 and len(begun) == 1


@pytest.mark.long
def test_teams_share_a_policy_or_a_critic_beside_those_of_the_thesis(single, tmp_path):
    words, begun = single
    words[:4] = ["teams", "--games", "offense/hard_crossing"]
    assert main(words) == 0
    stem = "offense_hard_crossing-allNonGK-"
    assert begun == [f"{stem}{kind}features-0" for kind in ("", "shared_ppo-", "shared_mappo-")]
    learned = [RunFolder.open(tmp_path / "fast" / name).config.ppo for name in begun]
    assert [(ppo.team, ppo.critic) for ppo in learned] == [
        ("independent", "own"),
        ("shared", "own"),
        ("shared", "central"),
    ]
    measured = {row.agent for row in rows.load(tmp_path / "results" / "fast.csv")}
    assert measured == {"team_ppo", "team_shared_ppo", "team_shared_mappo", "random"}
    assert main(words) == 0 and len(begun) == 3
    words[:3] = ["multi", "--games", "offense/hard_crossing"]
    assert main([*words, "--team", "shared"]) == 0 and len(begun) == 3  # the second of these runs
    assert len(BenchmarkStudy("teams", BenchmarkStudyConfig(), {}).games()) == 3


@pytest.mark.long
def test_demonstrations_are_played_cloned_and_trained_on_from(single, tmp_path, capsys):
    pytest.importorskip("minari")
    words, begun = single
    words[:4] = ["demonstrations", "--games", "offense/11_vs_gk", "--control", "closest1", "--demonstrations", "4"]
    assert main([*words, "--kl-to-clone", "0.25"]) == 0
    stem = "offense_11_vs_gk-closest1-features-clone-0"
    assert begun == ["offense_11_vs_gk-features-0", "offense_11_vs_gk-pretrained-features-0"]
    assert (tmp_path / "fast" / stem / "checkpoint.pt").is_file()
    assert (tmp_path / "fast" / begun[1] / "origin.pt").is_file()
    found = {row.agent: row for row in rows.load(tmp_path / "results" / "fast.csv") if row.scene == "train"}
    assert found.keys() == {"ppo", "cloned", "pretrained", "random", "expert", "team_expert"}
    assert [found[agent].env_steps for agent in ("ppo", "cloned", "pretrained")] == [64, 0, 64]
    assert "| +0.89 ± 0.03 |" in capsys.readouterr().out
    assert main([*words, "--kl-to-clone", "0.25"]) == 0 and len(begun) == 2
    assert main([*words, "--kl-to-clone", "0.25", "--publish"]) == 2


def test_the_thesis_has_fifteen_rows_of_teams():
    games = BenchmarkStudy("multi", BenchmarkStudyConfig(), {}).games()
    assert len(games) == 15 and ("offense/11_vs_gk", "2") in games and ("defense/2vs2", "all") in games
    assert BenchmarkStudy("single", BenchmarkStudyConfig(games=("defense/2vs2",)), {}).games() == [
        ("defense/2vs2", "closest1")
    ]
    pairs = BenchmarkStudy("demonstrations", BenchmarkStudyConfig(), {}).games()
    assert len(pairs) == 9 and ("grf/run_to_score_with_keeper", "closest1") in pairs
    with pytest.raises(UsageError, match="no semi-expert program is known for defense/2vs2"):
        BenchmarkStudy("demonstrations", BenchmarkStudyConfig(games=("defense/2vs2",)), {}).games()
    with pytest.raises(UsageError, match="no team is known for 1v1Free; say whom"):
        BenchmarkStudy("multi", BenchmarkStudyConfig(games=("1v1Free",)), {}).games()
    assert BenchmarkStudy("multi", BenchmarkStudyConfig(games=("1v1Free",)), {"env.control": "all"}).games() == [
        ("1v1Free", "all")
    ]


def test_rows_of_the_benchmark_are_those_of_ppo_on_levels_as_they_come(capsys):
    assert main(["single", "--method", "plr"]) == 2
    assert "unknown flag --method" in capsys.readouterr().err


@pytest.mark.long
def test_a_study_that_was_stopped_keeps_what_is_done(single, tmp_path, monkeypatch):
    words, begun = single
    clock = iter([0.0] * 9)
    monkeypatch.setattr(runs.time, "monotonic", lambda: next(clock, 1e9))
    assert main([*words, "--hours", "1"]) == 0
    assert len(begun) < 2
    monkeypatch.undo()
    monkeypatch.setattr(
        workers, "train_all", lambda begun, *_: [train(RunFolder.open(run.path), StopRequest()) for run in begun]
    )
    assert main(words) == 0
    assert len(rows.load(tmp_path / "results" / "fast.csv")) == 9


def test_studies_are_named_and_kept_apart(single, capsys):
    words, begun = single
    assert main(["singel"]) == 2
    assert (
        "no study 'singel' (did you mean 'single'?); there are single, generalization, multi, "
        in capsys.readouterr().err
    )
    assert main([*words, "--gamma", "0.5", "--publish"]) == 2
    assert "it is no run of preset fast; leave out --publish" in capsys.readouterr().err
    assert main(["single", "--games", "offense/easy_crosing"]) == 2
    assert "did you mean 'offense/easy_crossing'" in capsys.readouterr().err
    assert begun == []
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "generalization: one agent" in capsys.readouterr().out


def test_the_page_of_a_study_is_found_by_either_order(capsys):
    pages = []
    for words in (["--help", "single"], ["single", "--help"]):
        with pytest.raises(SystemExit, match="0"):
            main([*words])
        pages.append(capsys.readouterr().out)
    assert pages[0] == pages[1] and pages[0].startswith("usage: python -m lab.studies single")


def test_presets_are_those_of_training(tmp_path):
    thesis = starting_point(BenchmarkStudyConfig(preset="thesis"))
    assert thesis.env.representation == "smm_stacked" and thesis.total_env_steps == 5_000_000 and thesis.num_envs == 16
    start = build.find_game("1v1Restricted").start("thesis")
    for name in ("ppo", "paired", "num_envs", "total_env_steps"):
        assert getattr(thesis, name) == getattr(start, name)
    fast = starting_point(BenchmarkStudyConfig())
    assert fast.env.representation == "features" and fast.ppo.hidden_size == 64
    assert len(FIGURE_2_7) == 13
    assert [game for game, _ in PAIRS["generalization"]] == list(BENCHMARK) and len(BENCHMARK) == 22


def page_cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


def made(game, goal_difference, scene="train", seed=0, agent="ppo"):
    return rows.Row(game, agent, "closest1", scene, seed, 100, 50, goal_difference, 0.5, 20, 10, 30.0, 1.0, "abc", "1")


def test_rows_come_back_from_their_file_and_take_the_place_of_older_ones(tmp_path):
    path = tmp_path / "rows.csv"
    first = [made("defense/2vs2", -0.25), made("defense/2vs2", -0.5, seed=1)]
    assert rows.add(path, first) == first == rows.load(path)
    assert rows.add(path, [made("defense/2vs2", 0.125)])[0].goal_difference == 0.125
    assert rows.trained(rows.load(path), "defense/2vs2", "ppo", "closest1", 1) == 100
    assert rows.trained(rows.load(path), "defense/2vs2", "ppo", "all", 1) == 0
    both = mean_return([row.result() for row in rows.load(path)])
    assert not both.known and both.estimate == pytest.approx(np.mean([0.125, -0.5]))


def test_tables_of_rows_are_printed_or_put_into_their_place_on_a_page(tmp_path, capsys):
    rows.add(tmp_path / "fast.csv", [made("defense/2vs2", -0.25, seed=seed) for seed in range(5)])
    assert tables.main(["fast", "--results", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    (line,) = (line for line in printed.splitlines() if line.startswith("| defense/2vs2 | closest1 | ppo | -0.25 [-0."))
    assert page_cells(line)[-2:] == ["5", "100"]
    page = tmp_path / "PAGE.md"
    page.write_text("# Mine\n\n<!-- study: fast -->\nold\n<!-- end -->\n\nMine after.\n")
    for _ in range(2):
        assert tables.main(["fast", "--results", str(tmp_path), "--page", str(page)]) == 0
        text = page.read_text()
        assert text == f"# Mine\n\n<!-- study: fast -->\n{printed}<!-- end -->\n\nMine after.\n"
    page.write_text("# Mine\n")
    tables.publish(tmp_path, "fast", page)
    assert page.read_text() == f"# Mine\n\n## Study fast\n\n<!-- study: fast -->\n{printed}<!-- end -->\n"
    page.write_text("<!-- study: fast -->\n")
    with pytest.raises(CommandError, match="has the mark '<!-- study: fast -->' without '<!-- end -->'"):
        tables.publish(tmp_path, "fast", page)
    with pytest.raises(UsageError, match="no stored rows 'best'; there are curricula, tuning, "):
        tables.main(["best"])
    rows.add(tmp_path / "thesis.csv", [made("defense/2vs2", -0.25)._replace(simulator="0")])
    with pytest.raises(CommandError, match="they can be neither published nor added to"):
        tables.publish(tmp_path, "thesis")


def test_uniform_keys_are_played_on_all_scenes(tmp_path):
    config = runs.StudyRuns(tmp_path, runs.training(), {}).open("grf/empty_goal_close", 0).config
    found = measure_random(config, 4)
    assert [(row.agent, row.scene, row.env_steps) for row in found] == [("random", "train", 0), ("random", "test", 0)]


def test_a_study_writes_into_the_checkout_only_when_it_is_told_to(tmp_path):
    config = BenchmarkStudyConfig()
    assert places_of(config) == (Path("runs/benchmark/results"), None)
    published = places_of(BenchmarkStudyConfig(publish=True))
    assert published.page.is_file()
    assert published.results == ROOT / "lab" / "studies" / "results"


def test_measured_runs_of_other_settings_are_not_taken_for_these(single, capsys):
    words, begun = single
    assert main(words) == 0
    assert main([*words, "--gamma", "0.5"]) == 1
    assert "was trained with ppo.gamma = 0.995; it cannot continue with 0.5" in capsys.readouterr().err
    assert len(begun) == 2
