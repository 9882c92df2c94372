"""Cards of a recording: the formula of a score with its numbers, the outcome of each episode, beside the scenes."""

import itertools

import numpy as np
import pytest

from regista.experiments.run.recording import score_rule
from tests.experiments.probe import DRAWS, ProbePainter, batch
from ued.config import PairedConfig, PairedLiteralConfig, PLRConfig
from ued.core.level_space import level_dtype
from ued.levels.batch import LevelBatch
from ued.levels.record import level_record_dtype, make_records
from ued.levels.scores import SCORES, fields, score
from ued.methods.paired import paired_regret
from ued.recorder import cards, labels
from ued.recorder.layout import MAP_LEFT

rerun = pytest.importorskip("rerun")

from ued.recorder.recorder import CurriculumRecorder, Recording  # noqa: E402
from ued.recorder.scene_log import Episodes  # noqa: E402
from ued.recorder.theta_log import LABEL_CHARACTER, axis_label  # noqa: E402


def scored(rule="max_mc"):
    """Return two levels of one student, scored by a rule: best returns 1.0 and 0.0, values 0.25 and -0.1."""
    level = level_dtype(3)
    records = make_records(level_record_dtype(level, 1, 1, extra=fields(rule, 1)), np.zeros(2, level))
    records["id"], records["num_played"] = (7, 8), 1
    records["returns"][:, 0, 0], records["best"] = (0.5, 0.0), (1.0, 0.0)
    if "mean_value" in records.dtype.names:
        records["mean_value"][:, 0, 0] = 0.25, -0.1
    records["score"] = score(rule, records, records["best"])
    return LevelBatch(records, ["student"])


def test_every_score_has_a_formula():
    assert set(cards.FORMULAS) == set(SCORES)


def test_max_mc_is_told_with_its_two_numbers():
    levels = scored()
    text = "**MaxMC** = best return ever − mean value of the critic = "
    assert cards.formula(levels, 0, "max_mc") == f"{text}1.00 − 0.25 = **0.75**"
    assert cards.formula(levels, 1, "max_mc") == f"{text}0.00 − (-0.10) = **0.10**"
    assert cards.formula(levels, 0, "") == ""
    assert "your function = **0.75**" in cards.formula(levels, 0, "mine:score")
    card = cards.level_card(3, levels, ["a", "b", "c"], lambda theta: theta, "max_mc")
    assert "1.00 − 0.25" in card and "Level 7, random" in card
    assert "1.00 − 0.25" in cards.slot_card(levels, 0, "max_mc")


@pytest.mark.parametrize("kind", ["max_mean", "mean_mean"])
@pytest.mark.parametrize("roles", ["population", "flexible", "dennis2020"])
def test_regret_is_told_with_the_numbers_of_its_definition(roles, kind):
    level, rng = level_dtype(3), np.random.default_rng(0)
    records = make_records(level_record_dtype(level, 2, 3), np.zeros(20, level))
    records["returns"] = rng.choice([-1.0, 0.0, 0.5, 1.0], (20, 2, 3))
    config = PairedConfig(roles=roles, regret=kind)
    records["score"], levels = paired_regret(records, config), LevelBatch(records, ["protagonist", "antagonist"])
    rule = score_rule(config)
    for index, regret in enumerate(records["score"]):
        assert np.subtract(*cards.regret_terms(records["returns"][index], rule)) == pytest.approx(regret)
        assert cards.formula(levels, index, rule).endswith(f" = **{regret:.2f}**")
        assert cards.formula(levels, index, rule).count(" − ") == 2
    records["score"][0] += 1  # as one that was clipped
    assert cards.formula(levels, 0, rule).count(" − ") == 1
    assert (score_rule(PairedLiteralConfig()), score_rule(PLRConfig())) == ("dennis2020 max_mean", "max_mc")
    assert score_rule(PairedConfig(antagonist="scripted")) == "dennis2020 max_mean" and score_rule(None) == ""


def test_a_level_with_several_visits_has_one_card():
    levels = batch(1, np.random.default_rng(0), 4)
    levels.records["id"], levels.records["score"] = (5, 6, 5, 5), (0.1, 0.2, 0.4, 0.3)
    assert cards.by_score(levels, 6).tolist() == [2, 1] and cards.by_score(levels, 1).tolist() == [2]
    assert "the highest score of 3 visits in this update" in cards.slot_card(levels, 2)
    assert "visits" not in cards.slot_card(levels, 1) and f"{cards.BEST} +" in cards.slot_card(levels, 1)


def test_labels_neither_overlap_nor_are_cut_off():
    bounds, texts = (-111.0, 111.0, -70.0, 70.0), ["start", *(f"end {k}: return +1.00" for k in range(1, 7))]
    for corner in ((105.0, 10.0), (-110.0, -70.0), (110.0, 70.0), (0.0, 0.0)):
        places = np.array(corner) + np.random.default_rng(0).normal(0, 0.5, (len(texts), 2))
        found = labels.spread(places, texts, bounds)
        character, line, below = (222 * size for size in (labels.CHARACTER, labels.LINE, labels.BELOW))
        half = np.array([len(text) * character / 2 for text in texts])
        assert (found[:, 0] - half > -111).all() and (found[:, 0] + half < 111).all()
        assert (found[:, 1] - below - line / 2 > -70.01).all() and (found[:, 1] < 70.01).all()
        for one, other in itertools.combinations(range(len(texts)), 2):
            apart = np.abs(found[one] - found[other])
            assert apart[0] > half[one] + half[other] or apart[1] > 0.98 * line
    alone = labels.spread(np.array([[3.0, 4.0]]), ["start"], bounds)
    assert alone.tolist() == [[3.0, 4.0]]


def test_labels_of_densities_end_beside_them():
    for name in ("x", "a_parameter_with_a_name_that_is_much_too_long"):
        text = axis_label(name, -99.5, -98.0)
        assert text.endswith(": -99.5 to -98") and len(text) * LABEL_CHARACTER < MAP_LEFT
    assert axis_label("ego.x", 0, 80) == "ego.x: 0 to 80"


@pytest.fixture
def written(tmp_path):
    """Return what a recording of one update with two episodes says, by entity."""
    from rerun.chunk import RrdReader

    path = tmp_path / "curriculum.rrd"
    recorder = CurriculumRecorder(Recording(path, "cards", "probe", 1000, {}), ProbePainter(), DRAWS)
    recorder.record(1, 1000, batch(1, np.random.default_rng(0)), {"eval/a scene": 0.5, "eval/another": 0.1})
    walk = np.cumsum(np.full((12, 2, 2), 0.5), 0)
    ends = ["return +1.00", "return +0.00"]
    recorder.episodes("protagonist", 1, 1000, Episodes(walk, [0, 7], 0.1, "protagonist in update 1", ends))
    recorder.close()
    return [(str(chunk.entity_path), chunk.to_record_batch()) for chunk in RrdReader(str(path)).stream()]


def column(written, entity, name):
    (found,) = [rows.column(name).to_pylist() for path, rows in written if path == entity and name in rows.column_names]
    return found[-1]


def test_start_end_and_outcome_of_each_episode_are_marked(written):
    root = "/scene/rollout/protagonist/path"
    assert column(written, f"{root}/labels", "Points2D:labels") == [
        "start 1",
        "start 2",
        "end 1: return +1.00",
        "end 2: return +0.00",
    ]
    places = column(written, f"{root}/marks", "Points2D:positions")
    assert np.allclose(places, [[0.5, 0.5], [4.0, 4.0], [3.5, 3.5], [6.0, 6.0]])
    moved = np.array(column(written, f"{root}/labels", "Points2D:positions")) != np.array(places)
    leaders = column(written, f"{root}/leaders", "LineStrips2D:strips")  # from marks to labels that have moved
    assert 0 < len(leaders) == moved.any(1).sum() and {tuple(line[0]) for line in leaders} <= set(map(tuple, places))
    (card,) = column(written, "/rollouts/protagonist", "TextDocument:text")
    assert "| 1 | return +1.00 | 6 |\n| 2 | return +0.00 | 4 |" in card


def test_no_text_lies_over_a_level(written):
    over = {
        path for path, rows in written if path.startswith("/scene/levels") and "Points2D:labels" in rows.column_names
    }
    assert not over
    assert "level " in column(written, "/levels/0", "TextDocument:text")[0]


def test_test_scenes_have_wide_lines_in_colors_of_their_own(written):
    scenes = ["/metrics/eval/a\\ scene", "/metrics/eval/another"]
    looks = {path: rows for path, rows in written if path in scenes and "SeriesLines:colors" in rows.column_names}
    assert len(looks) == 2
    colors = [rows.column("SeriesLines:colors").to_pylist()[0][0] for rows in looks.values()]
    assert len(set(colors)) == 2
    assert all(rows.column("SeriesLines:widths").to_pylist()[0][0] >= 2 for rows in looks.values())
