"""What a recording and a page of levels show is what was played: values, bars, episodes and their numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from regista.experiments.pictures import gallery
from regista.experiments.run.recording import endings
from regista.experiments.run.replays import MAX_STEPS, Replay, Stage, came_out_alike
from tests.experiments.probe import DRAWS, ProbePainter, batch
from ued.core.level_space import level_dtype
from ued.core.parameters import Choice, Column, Integer, Range
from ued.levels.batch import LevelBatch
from ued.levels.record import level_record_dtype, make_records
from ued.probes import Frontier
from ued.recorder.shades import student_color, unit

rerun = pytest.importorskip("rerun")

from ued.recorder.recorder import CurriculumRecorder, Recording  # noqa: E402
from ued.recorder.scene_log import SceneLog  # noqa: E402
from ued.recorder.theta_log import MAP_WIDTH, ThetaLog  # noqa: E402

OPTIONS = SimpleNamespace(
    name="kind", kind="choice", low=0.0, high=2.0, options=("car", "bus", "van"), weights=(8.0, 1.0, 1.0)
)
WHOLE = SimpleNamespace(name="lanes", kind="integers", low=1.0, high=3.0, options=(), weights=())
DISCRETE = [
    Column("ground", Choice("ice", "mud", "sand", weights=(8, 1, 1))),
    OPTIONS,
    Column("legs", Integer(1, 3)),
    WHOLE,
]


def log_of(draws):
    """Return the log of θ for these columns, and what it writes by entity."""
    written = {}

    def log(entity, *parts, static=False):
        name = "/".join(entity) if isinstance(entity, list) else str(entity)
        written.setdefault(name, []).append(parts[0])

    rows = SimpleNamespace(scalars=lambda *_: None)
    return ThetaLog(SimpleNamespace(log=log), rows, draws), written


def numbers(chart, part):
    """Return a component of a bar chart as numbers."""
    return np.array(getattr(chart, part).as_arrow_array().to_pylist()[0]["buffer"])


def test_values_of_columns_with_cells_are_those_of_the_level():
    log, _ = log_of(DISCRETE)
    assert log.names == ["ground (0 ice, 1 mud, 2 sand)", "kind (0 car, 1 bus, 2 van)", "legs", "lanes"]
    theta = np.array([[0.7, 0.7, -0.99, -0.99], [0.9, 0.9, 0.99, 1.0], [-0.2, 0.59, 0.0, -0.3]])
    assert np.allclose(log.values(theta), [[1, 1, 1, 1], [2, 2, 3, 3], [0, 0, 2, 2]])
    axes = [gallery._axis(draw, draw.name) for draw in DISCRETE]
    assert [axis["count"] for axis in axes] == [3, 3, 3, 3]
    assert np.allclose(axes[0]["edges"], [0.6, 0.8]) and np.allclose(axes[1]["edges"], [0.6, 0.8])
    assert [(axis["low"], axis["high"]) for axis in axes] == [(-0.5, 2.5), (-0.5, 2.5), (0.5, 3.5), (0.5, 3.5)]


def test_bars_stand_where_their_values_are():
    log, written = log_of([Column("x", Range(-5, 5)), OPTIONS])
    log.open()
    (uniform,), (options,) = (written[f"theta/{name}/uniform"] for name in log.names)
    places, widths = numbers(uniform, "abscissa"), np.diff([*numbers(uniform, "abscissa"), 5.0])
    assert places[0] == pytest.approx(-5)  # the viewer draws a bar from its place on, to the right
    assert np.allclose(uniform.widths.as_arrow_array().to_pylist(), widths)
    assert np.allclose(numbers(options, "abscissa"), [-0.5, 0.5, 1.5])  # around the numbers of the options


def test_no_level_at_the_end_of_a_range_is_lost():
    log, written = log_of([Column("x", Range(0.3, 0.9))])
    log.record(1, np.array([[1.0], [1.0], [-1.0], [0.0]]))
    (chart,) = written["theta/x/histogram"]
    assert numbers(chart, "values").sum() == 1.0


def test_densities_have_a_column_for_every_update():
    log, written = log_of([Column("x", Range(0, 1))])
    log.expect(4)
    for update in range(1, 5):
        log.note(update, np.zeros((update, 1)))
        log.record(update, np.zeros((update, 1)))
    assert log._density[0].sum(1).tolist() == [1, 2, 3, 4]
    cursors = [strip.strips.as_arrow_array().to_pylist()[0][0][0] for strip in written["theta/over_time/cursor"]]
    assert np.allclose(cursors, MAP_WIDTH * (np.arange(4) + 0.5) / 4)


def test_negative_scores_have_shades():
    assert unit(np.array([-1.0, 0.0, np.nan, -0.5])).tolist() == [0, 1, 0, 0.5]
    assert unit(np.array([0.5, 1.0])).tolist() == [0.5, 1.0]
    assert unit(np.full(2, -1.0)).tolist() == [0, 0] and unit(np.full(2, np.nan)).tolist() == [0, 0]


@pytest.mark.slow
def test_a_large_population_is_recorded(tmp_path):
    level, students = level_dtype(3), [f"student{k}" for k in range(6)]
    records = make_records(level_record_dtype(level, 6, 1), np.zeros(2, level))
    records["num_played"], records["returns"] = 1, 0.5
    recorder = CurriculumRecorder(Recording(tmp_path / "many.rrd", "many", "probe", 100, {}), None, DRAWS)
    recorder.record(1, 100, LevelBatch(records, students), {})
    recorder.close()
    assert len({student_color(k) for k in range(4)}) == 4 and student_color(5) == student_color(1)


def replay_of(steps, episodes):
    """Return a replay of an environment of paths of `steps` steps, and what it shows: the place on the path."""
    env = Frontier(1, longest=steps)
    level = env.make_levels(np.array([[1.0, 1.0, 1.0, -1.0]]))
    actions = np.full(steps * episodes, (env.turns[0] + 1) % 4)[:MAX_STEPS]
    replay = Replay(1, 7, 9, "student", level, actions, np.zeros(episodes))
    return replay, Stage(env, SimpleNamespace(frame=lambda env: np.array([[float(env.place[0]), 0.0]])))


def test_a_replayed_episode_is_shown_from_its_start_to_its_end():
    replay, stage = replay_of(5, 2)
    played = stage.play(replay)
    assert [frame[0, 0] for frame in played.frames] == [0, 1, 2, 3, 4, 5] * 2 and played.begins == [0, 6]
    assert endings(replay, played) == ["return +0.00"] * 2


@pytest.mark.slow
def test_long_episodes_are_shown_as_far_as_they_are_saved():
    replay, stage = replay_of(300, 8)
    played = stage.play(replay)
    assert len(played.returns) == MAX_STEPS // 300 and came_out_alike(replay, played.returns)
    assert not came_out_alike(replay, played.returns + 1)
    assert endings(replay, played) == ["return +0.00"] + ["return +0.00 (cut off)"] * 7
    short = Replay(1, 7, 9, "student", replay.level, replay.actions[:700], replay.returns)
    assert not came_out_alike(short, stage.play(short).returns)  # it ended otherwise


def test_returns_of_replays_are_stored_without_loss():
    replay, stage = replay_of(5, 3)
    replay.returns[:] = 1 / 3, 1234567.0, -0.1
    row = {name: str(value) for name, value in replay.row().items()}
    assert row["returns"] == "0.3333333333333333 1234567 -0.1"
    assert Replay.of_row(row, stage.env).returns.tolist() == replay.returns.tolist()


def test_scores_of_several_visits_of_a_level_are_not_confused(monkeypatch):
    from regista.experiments.run import recording

    levels = batch(1, np.random.default_rng(0), 3)
    levels.records["id"], levels.records["visit"], levels.records["score"] = 7, (8, 9, 10), (0.1, 0.9, 0.2)
    shown = []
    played = SimpleNamespace(frames=[np.zeros((1, 2))] * 3, begins=[0], returns=np.zeros(1))
    recorder = SimpleNamespace(
        recorder=SimpleNamespace(episodes=lambda *parts: shown.append(parts[-1])),
        stage=SimpleNamespace(play=lambda _: played, step_seconds=0.1),
    )
    update = SimpleNamespace(levels=levels, number=1, env_steps=10)
    recording.RunRecorder._show(recorder, [replay_of(2, 1)[0]], update)
    assert "score 0.90" in shown[0].outcome


def test_episodes_are_marked_at_what_moves():
    painter = ProbePainter()
    log = SceneLog(SimpleNamespace(), painter)
    still, moving = np.zeros((4, 1, 2)), np.cumsum(np.ones((4, 1, 2)), 0)
    assert log._marked([np.concatenate([moving, still], 1)]) == painter.focus == 0
    assert log._marked([np.concatenate([still, moving], 1)]) == 1  # as in a maze, whose focus is the goal
    assert log._marked([np.concatenate([still, still], 1)]) == 0


def test_ticks_of_updates_stand_at_their_updates():
    log, written = log_of([Column("x", Range(0, 1))])
    log.expect(6)
    log.open()
    (axis,) = written["theta/over_time/axis"]
    texts, places = axis.labels.as_arrow_array().to_pylist(), axis.positions.as_arrow_array().to_pylist()
    ticks = [(int(text[1:]), x) for text, (x, _) in zip(texts, places, strict=True) if text.startswith("#")]
    assert len(ticks) == 5 and all(x == pytest.approx(update / 6 * MAP_WIDTH) for update, x in ticks)
