"""`python -m lab.thesis`: the runs of chapter 4, its figures and tables, and the conditions for publishing."""

import pytest

from lab.studies.rows import Row, add, load
from lab.thesis import __main__ as command
from lab.thesis import curves, figures, plan, study, tables
from regista.experiments.pictures import plots
from regista.experiments.pictures.variants import shades_of
from regista.experiments.run import build
from regista.experiments.run.errors import CommandError, UsageError
from regista.minigames import MINIGAMES

BRIEF = ["--seeds", "2", "--env-steps", "20000", "--episodes", "4", "--processes", "1"]


def row(agent="dr", seed=0, scene="train", goals=10, game="1v1Restricted"):
    return Row(game, agent, "closest1", scene, seed, 9, 20, goals / 20, 0.5, goals, 0, 30.0, 1.0, "a", "1")


def measured(runs=6):
    """Return rows of a game in the order of a file: methods and scenes in alphabetical order."""
    scenes = ["train", *(label for label, _ in MINIGAMES["1v1Restricted"].tests)]
    gain = {"dr": 0, "paired": 8}
    return sorted(
        row(agent, seed, s, 4 + gain[agent] + seed % 2) for agent in gain for seed in range(runs) for s in scenes
    )


def test_the_experiment_is_that_of_the_thesis():
    arms = list(plan.paired_arms([*plan.FIGURES], [*plan.METHODS], plan.Budget()))
    assert len(arms) == 10 * 4 * 5 and set(plan.FIGURES) == set(MINIGAMES)
    assert {arm.seed for arm in arms} == set(range(10))
    steps = {(arm.agent, arm.settings["total_env_steps"]) for arm in arms}
    assert steps == {(name, 2_500_000 if name == "dr_half" else 5_000_000) for name in plan.METHODS}
    found = {arm.agent: (arm.settings["method"], arm.settings.get("paired.roles")) for arm in arms}
    assert found["paired_dennis2020"] == ("paired", "dennis2020") and found["paired"] == ("paired", "population")
    steps = {arm.game: arm.settings["total_env_steps"] for arm in plan.table_arms(plan.table_games(), plan.Budget())}
    assert len(steps) == 6 and steps["offense/avoid_pass_shoot"] == 10_000_000 == 2 * steps["offense/easy_crossing"]


@pytest.mark.parametrize("preset", ["fast", "thesis"])
def test_every_run_can_be_begun_and_default_regret_is_the_default(preset, tmp_path):
    runs = study.StudyRuns(tmp_path, plan.base(preset), {})
    budget = plan.Budget(range(1), preset)
    arms = [*plan.paired_arms([*plan.FIGURES], [*plan.METHODS], budget), *plan.table_arms(plan.table_games(), budget)]
    for arm in arms:
        config = runs.plan(arm.game, arm.seed, arm.settings)[1]
        assert config.env.representation == ("features" if preset == "fast" else "smm_stacked")
        assert config.env.rewards == "scoring"
        if arm.agent == "paired":
            default = build.find_game(arm.game).start("fast").paired
            assert (config.paired.roles, config.paired.dr_fraction) == (default.roles, default.dr_fraction)


@pytest.mark.slow
def test_figures_have_the_order_of_the_thesis_and_tables_marks():
    rows = measured()
    assert list(figures.scene_names(rows).values()) == [
        "training\ndistribution",
        "test 0\neasy",
        "test 1\nmedium",
        "test 2\nhard",
    ]
    assert [one.agent for one in plan.in_order(rows)][::24] == ["dr", "paired"]
    text = tables.paired_tables(rows)
    head = text.splitlines()[2]
    assert head == "| method |  | train | easy | medium | hard | runs | env_steps |"
    assert "**Figure 4.5: 1v1 Restricted**" in text and "over the 4 differences of this table" in text
    gains = next(line for line in text.splitlines() if line.startswith("|  | − dr |"))
    assert gains.count("+0.40 [") == gains.count("] *") == 4
    assert "6 runs each: differences under" in text and "`python -m lab.thesis paired`" in text


def test_figures_explain_their_marks_and_close_colors_have_other_lines(monkeypatch, tmp_path):
    drawn = []
    monkeypatch.setattr(figures.plots, "save", lambda figure, path: drawn.append(figure))
    values = [
        curves.Value("1v1Free", agent, 0, steps, curve, 0.5, "1")
        for agent in ("dr", "paired", "paired_literal", "paired_dennis2020")
        for steps in (250_000, 500_000)
        for curve in curves.CURVES
    ]
    figures.draw_curves(values, tmp_path / "curves.png")
    figures.draw_strategies([row("built-in", scene="A: chases the ball", game="3v2FourBehaviors")], tmp_path / "a.png")
    shown, bars = drawn
    looks = {line.get_label(): line for line in shown.axes[0].lines}
    assert (
        len({str(line._dash_pattern) for line in looks.values()}) == 3
    )  # the methods' own, and one for each other method
    shade = looks["PAIRED (Dennis et al.)"].get_color()
    assert shade in shades_of(plots.color("paired")) and looks["DR"].get_color() == plots.color("dr")
    assert shown.axes[0].get_xlim()[0] == 0
    (legend,) = bars.legends
    assert [text.get_text() for text in legend.get_texts()] == ["95% CI"]


def test_table_4_1_stands_beside_the_published_numbers():
    rows = [row(seed=seed, game="offense/easy_crossing", goals=10 + seed) for seed in range(5)]
    line = tables.randomization_table(rows).splitlines()[2]
    assert line.startswith("| offense/easy_crossing | +0.60 [") and "| +0.87 | +0.50 | 9 | 5 |" in line


def test_a_text_goes_into_its_place_on_the_page(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- thesis: paired -->\nold\n<!-- end -->\nb <!-- end -->\n")
    tables.publish("paired", "new", page)
    assert page.read_text() == "a\n<!-- thesis: paired -->\nnew\n<!-- end -->\nb <!-- end -->\n"
    with pytest.raises(CommandError, match="has no place"):
        tables.publish("strategies", "new", page)
    for name in ("paired", "strategies", "randomization"):
        assert f"<!-- thesis: {name} -->\n" in tables.PAGE.read_text()


@pytest.mark.parametrize(
    "more", [["--env-steps", "10"], ["--preset", "thesis"], ["--episodes", "5"], ["--seeds", "11"]]
)
def test_only_the_experiment_itself_is_published(more, tmp_path):
    with pytest.raises(UsageError, match=f"with this {more[0]} it is not the experiment.*leave out --publish"):
        command.main(["paired", "--publish", "--out", str(tmp_path), *more])
    with pytest.raises(UsageError, match="must be 1 or more"):
        command.main(["paired", "--seeds", "0"])
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_the_built_in_ai_meets_the_four_strategies(tmp_path, capsys):
    assert command.main(["strategies", "--episodes", "30", "--out", str(tmp_path)]) == 0
    rows = load(tmp_path / "results" / "thesis_strategies.csv")
    assert [one.scene[0] for one in rows] == ["A", "B", "C", "D"] and {one.game for one in rows} == {"3v2FourBehaviors"}
    assert {one.episodes for one in rows} == {30} and sum(one.scored for one in rows) > 20
    assert "| A: chases the ball | +0." in capsys.readouterr().out
    assert command.main(["strategies", "--episodes", "40", "--out", str(tmp_path)]) == 0
    assert load(tmp_path / "results" / "thesis_strategies.csv") == rows  # runs with rows are not played again


@pytest.mark.long
def test_runs_are_trained_played_and_drawn_once(begun, tmp_path, capsys):
    words = ["paired", *BRIEF, "--games", "ChoosePassing", "--methods", "dr", "paired", "--out", str(tmp_path)]
    assert command.main(words) == 0
    assert begun == [f"ChoosePassing-{agent}-features-{seed}" for seed in (0, 1) for agent in ("dr", "paired")]
    rows = load(tmp_path / "results" / "thesis_paired.csv")
    assert len(rows) == 2 * 2 * 3 and {one.simulator for one in rows} == {"1"}
    values = load(tmp_path / "results" / "thesis_curves.csv", curves.Value)
    assert {value.curve for value in values if value.agent == "dr"} == {"agent"}
    assert {value.curve for value in values if value.agent == "paired"} == set(curves.CURVES)
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {"figure_4_7.png", "figure_4_9.png"}
    assert "**Figure 4.7: Choose Pass**" in capsys.readouterr().out
    assert command.main(words) == 0 and len(begun) == 4
    add(tmp_path / "results" / "thesis_paired.csv", [rows[0]._replace(simulator="0")])
    assert command.run_command(command.main, words) == 1
    assert "neither published nor added to" in capsys.readouterr().err
