"""Recordings are read back without a viewer."""

import gc
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from regista.experiments.run.recording import RunRecorder, viewer_answers
from tests.experiments.probe import DRAWS, ProbePainter, batch
from ued.config import BufferConfig
from ued.core.curriculum import ThetaSpace
from ued.core.level_space import level_dtype
from ued.levels.buffer import LevelBuffer
from ued.levels.record import NONE, level_record_dtype, make_records
from ued.recorder.layout import layout, shown
from ued.recorder.recorder import CurriculumRecorder, Recording
from ued.recorder.scene_log import Episodes
from ued.recorder.shades import SOURCE_COLORS, ramp, smooth, unique_names
from ued.recorder.theta_log import MOST_COLUMNS, ThetaLog
from ued.recorder.writer import Writer

rerun = pytest.importorskip("rerun")
ROOT = Path(__file__).resolve().parents[2]
UPDATES = 30


def table(path, entity, column):
    """Return rows of one component column by update."""
    from rerun.chunk import RrdReader

    found = {}
    for chunk in RrdReader(str(path)).stream().filter(content=entity):
        if str(chunk.entity_path) == entity and not chunk.is_static and "update" in chunk.timeline_names:
            rows = chunk.to_record_batch()
            found |= dict(zip(rows.column("update").to_pylist(), rows.column(column).to_pylist(), strict=True))
    return dict(sorted(found.items()))


def filled_buffer():
    """Return a buffer of a level, its edited copy, and a copy of that."""
    buffer, parent = LevelBuffer(ThetaSpace(3), BufferConfig(capacity=4)), NONE
    for value in (0.1, 0.2, 0.3):
        levels = np.zeros(1, level_dtype(3))
        levels["theta"] = value
        records = make_records(level_record_dtype(levels.dtype), levels)
        records["score"], records["parent"] = value, parent
        buffer.insert(records, np.array([value]))
        parent = buffer.slots["id"][-1]
    return buffer


@pytest.mark.slow
def test_a_buffers_tree_leads_from_parents_to_their_copies(recorded):
    path, _ = recorded
    ((_, lines), *_) = table(path, "/buffer/tree/descent", "LineStrips2D:strips").items()
    ((_, places), *_) = table(path, "/buffer/tree/levels", "Points2D:positions").items()
    third, second, first = places  # the highest score first
    assert {tuple(map(tuple, line)) for line in lines} == {(tuple(first), tuple(second)), (tuple(second), tuple(third))}
    (text,) = table(path, "/events", "TextLog:text")[15]
    assert text == "collapse: all levels are alike"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return a recording of 30 updates, two episodes of each student, in strict mode: a bad argument raises."""
    rerun.set_strict_mode(True)
    path = tmp_path_factory.mktemp("rrd") / "curriculum.rrd"
    rng = np.random.default_rng(0)
    recorder = CurriculumRecorder(
        Recording(path, "regista-1", "probe 0", UPDATES * 1000, {"seed": "0"}), ProbePainter(), DRAWS
    )
    batches = [batch(update, rng) for update in range(1, UPDATES + 1)]
    for update, levels in enumerate(batches, start=1):
        metrics = {"regret": float(levels.score.mean()), "eval/a scene": 0.5, "nothing": float("nan")}
        metrics |= {"levels/random": 32.0, "levels/edited": 0.0, "levels/replayed": float(update == 9)}
        recorder.record(update, update * 1000, levels, metrics)
        if update % 15 == 0:
            for student in levels.returns:
                walk = np.cumsum(rng.normal(0.3, 0.3, (12, 2, 2)), 0)
                recorder.episodes(student, update, update * 1000, Episodes(walk, [0, 7], 0.1, "return +1.00"))
            recorder.level_buffer(10, filled_buffer())
            recorder.event("collapse", "all levels are alike")
        if update == 20:
            recorder.flush()
    recorder.close()
    rerun.set_strict_mode(False)
    return path, batches


@pytest.mark.slow
def test_the_file_is_complete(recorded):
    from rerun.chunk import RrdReader

    path, _ = recorded
    verified = subprocess.run(
        [sys.executable, "-m", "rerun_cli", "rrd", "verify", path], capture_output=True, text=True
    )
    assert verified.returncode == 0 and "1 file" in verified.stdout + verified.stderr
    reader = RrdReader(str(path))
    assert len(reader.recordings()) == 1 and len(reader.blueprints()) == 1


def test_every_update_has_its_metrics(recorded):
    path, batches = recorded
    regret = table(path, "/metrics/regret", "Scalars:scalars")
    assert list(regret) == list(range(1, UPDATES + 1))
    assert [row[0] for row in regret.values()] == [float(levels.score.mean()) for levels in batches]


def test_levels_are_where_the_painter_puts_them_the_highest_score_first(recorded):
    path, batches = recorded
    rows = table(path, "/scene/levels/0/points", "Points2D:positions")
    assert list(rows) == list(range(1, UPDATES + 1))
    for update, points in rows.items():
        levels = batches[update - 1]
        best = levels.theta[int(levels.score.argmax())]
        assert np.allclose(points, ProbePainter().positions(best[None])[0], atol=1e-4)


def test_quantiles_of_theta_are_in_the_units_of_the_draws(recorded):
    path, batches = recorded
    rows = table(path, "/theta/place.x/quantiles", "Scalars:scalars")
    for update, values in rows.items():
        assert np.allclose(values, np.quantile(batches[update - 1].theta[:, 0] * 50.0, [0.1, 0.5, 0.9]))


def test_every_entity_of_the_layout_is_there(recorded):
    from rerun.chunk import RrdReader

    path, _ = recorded
    entities = {line.split()[0] for line in RrdReader(str(path)).store().summary().splitlines()}
    assert {
        "/scene/ground",
        "/scene/batch",
        "/scene/heat/map",
        "/scene/rollout/protagonist/path/lines",
        "/scene/rollout/antagonist/now",
        "/metrics/return_per_level/protagonist",
        "/metrics/score_per_level",
        "/theta/depth/histogram",
        "/theta/over_time/2/map",
        "/theta/over_time/cursor",
        "/levels/card",
    } <= entities


def test_every_entity_is_one_chunk_although_it_was_flushed_in_between(recorded):
    from rerun.chunk import RrdReader

    chunks = [chunk for chunk in RrdReader(str(recorded[0])).stream() if not chunk.is_static]
    found = [(str(chunk.entity_path), tuple(chunk.timeline_names)) for chunk in chunks]
    metrics = [path for path, _ in found if path.startswith("/metrics/")]
    assert len(metrics) == len(set(metrics)) > 4
    timelines = {path: set(names) for path, names in found}
    assert timelines["/metrics/regret"] == {"update", "env_steps"}
    assert timelines["/metrics/score_per_level"] == {"update", "env_steps", "movie"}


def test_looks_are_written_once(recorded):
    from rerun.chunk import RrdReader

    path, _ = recorded
    still = {}
    for chunk in RrdReader(str(path)).stream():
        if chunk.is_static:
            still[str(chunk.entity_path)] = chunk.to_record_batch()
    painter = ProbePainter()
    for place in ("levels/0/points", "rollout/protagonist/now"):
        looks = still[f"/scene/{place}"]
        assert looks.column("Points2D:class_ids").to_pylist() == [list(painter.classes)]
        assert looks.column("Points2D:show_labels").to_pylist() == [[False]]
    assert table(path, "/theta/depth/histogram", "BarChart:values").keys() == {1, *range(5, UPDATES + 1, 5)}
    assert len(still["/theta/depth/histogram"].column("BarChart:widths").to_pylist()[0]) == 24


def test_sources_are_shown_from_their_first_level_on(recorded):
    """The legend lists no source that a method never has."""
    from rerun.chunk import RrdReader

    path, _ = recorded
    shown = {name: table(path, f"/metrics/levels/{name}", "Scalars:scalars") for name in SOURCE_COLORS}
    assert [*shown["random"]] == [*range(1, UPDATES + 1)] and [*shown["replayed"]] == [*range(9, UPDATES + 1)]
    assert shown["replayed"][9] == [1.0] and shown["replayed"][10] == [0.0]
    known = {str(chunk.entity_path) for chunk in RrdReader(str(path)).stream()}
    assert {f"/metrics/levels/{name}" for name in SOURCE_COLORS} & known == {
        "/metrics/levels/random",
        "/metrics/levels/replayed",
    }


@pytest.mark.parametrize(
    ("students", "kinds", "name"),
    [(("student",), {"buffer"}, "Score"), (("one", "other"), set(), "Regret"), (("student",), set(), None)],
)
def test_scores_have_a_view_as_high_as_that_of_returns(students, kinds, name):
    overview = layout(ProbePainter(), ["x"], students, kinds).root_container.contents[0]
    curves = [view.name for view in overview.contents[1].contents[0].contents]
    assert curves == [f"{kind} per level (mean ± std)" for kind in ("Return", name) if kind]


def test_every_curve_of_the_layout_is_shown():
    assert shown("metrics/eval/a scene") and shown("metrics/levels/random") and not shown("metrics/time/sim")


@pytest.mark.parametrize(("columns", "labels"), [(3, 3), (10, 10), (172, 10)])
def test_densities_of_many_columns_have_a_height_and_few_labels(columns, labels):
    written = {}
    stream = SimpleNamespace(log=lambda entity, *parts, static=False: written.update({str(entity): parts}))
    draws = [DRAWS[0] for _ in range(columns)]
    log = ThetaLog(stream, SimpleNamespace(), draws)
    log.expect(8)
    log.open()
    texts = written["theta/over_time/axis"][0].labels.as_arrow_array().to_pylist()
    assert sum(text.startswith("place.x") for text in texts) == labels and len(texts) == labels + 5
    places = [parts[0] for entity, parts in written.items() if entity.split("/")[-1].isdigit()]
    assert len(places) == min(columns, MOST_COLUMNS)
    assert all(place.scale.as_arrow_array().to_pylist()[0][1] > 0 for place in places)


def test_two_equal_names_are_told_apart():
    assert unique_names([*DRAWS, DRAWS[0]]) == ["place.x 1", "place.y", "depth", "place.x 2"]


def test_smoothing_keeps_the_mass_and_the_shape():
    grid = np.zeros((21, 33))
    grid[10, 16] = 4.0
    blurred = smooth(grid)
    assert blurred.shape == grid.shape
    assert blurred.sum() == pytest.approx(4.0, rel=1e-6)
    assert np.unravel_index(blurred.argmax(), grid.shape) == (10, 16)


def test_a_ramp_of_colors_hits_its_ends():
    colors = ramp(np.array([0.0, 1.0, np.nan]), ((0, 0, 0), (10, 20, 30)))
    assert colors.tolist() == [[0, 0, 0], [10, 20, 30], [0, 0, 0]]


def test_a_recording_that_is_large_enough_ends(tmp_path, capsys):
    (tmp_path / "curriculum.rrd").write_bytes(bytes(1_000_001))
    ended = []
    recorder = RunRecorder.__new__(RunRecorder)
    recorder.run = SimpleNamespace(
        recordings=lambda: [tmp_path / "curriculum.rrd"], config=SimpleNamespace(record_limit=1)
    )
    recorder.recorder = SimpleNamespace(flush=lambda: None, close=lambda: ended.append(True))
    recorder.flush()
    recorder.flush()
    assert ended == [True] and recorder.recorder is None
    assert capsys.readouterr().err == "regista: the recording has reached 1 MB and ends; see --record-limit\n"


@pytest.mark.slow
@pytest.mark.parametrize("hangs", [False, True])
def test_a_stream_that_its_disk_has_failed_is_left_to_itself(monkeypatch, hangs):
    class Stream:
        def disconnect(self):
            if hangs:
                threading.Event().wait()
            raise RuntimeError("Flush timed out")

        def __del__(self):  # Rerun's waits for its writer here
            freed.append(True)

    freed, left = [], []
    monkeypatch.setattr(rerun, "unregister_shutdown", lambda: left.append(True))
    monkeypatch.setattr("ued.recorder.writer.PATIENCE", 0.5 if hangs else 60.0)
    writer = Writer(Stream())
    with pytest.raises(RuntimeError, match="did not respond within" if hangs else "Flush timed out"):
        writer.finish()
    del writer
    gc.collect()
    assert left and not freed


@pytest.mark.slow
def test_a_program_that_ends_in_an_error_waits_for_no_writer(tmp_path):
    """Nor is a stream freed before: that would wait as well."""
    script = tmp_path / "script.py"
    script.write_text(
        "import threading, ued.recorder.writer as writer\n"
        "class Stream:\n"
        "    def disconnect(self):\n        print('waited'), threading.Event().wait()\n"
        "    def __del__(self):\n        threading.Event().wait()\n"
        "writer.PATIENCE = 0.2\n"
        "def run():\n    writer.Writer(Stream())\n    raise ValueError('an error of the run')\n"
        "run()\n"
    )
    ended = subprocess.run([sys.executable, script], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 1 and ended.stdout == "waited\n" and "an error of the run" in ended.stderr


def test_a_viewer_is_there_or_not():
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"127.0.0.1:{server.getsockname()[1]}"
        assert viewer_answers(address)
    assert not any(map(viewer_answers, (address, "nowhere", "127.0.0.1:99999")))


@pytest.mark.slow
def test_a_viewer_gets_what_the_file_gets(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    shown, address = tmp_path / "shown.rrd", f"127.0.0.1:{port}"
    flags = ["--bind", "127.0.0.1", "--port", str(port), "--save", shown]  # a viewer without a window
    viewer = subprocess.Popen([sys.executable, "-m", "rerun_cli", *flags], stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 60
        while not viewer_answers(address) and time.monotonic() < deadline:
            time.sleep(0.1)
        recording = Recording(tmp_path / "curriculum.rrd", "regista-2", "probe 0", 3000, {"seed": "0"}, address)
        recorder = CurriculumRecorder(recording, ProbePainter(), DRAWS)
        for update in (1, 2, 3):
            recorder.record(update, update * 1000, batch(update, np.random.default_rng(0)), {"regret": update / 4})
        recorder.close()
    finally:
        viewer.send_signal(signal.SIGINT)
        viewer.wait(60)
    assert {update: value for update, (value,) in table(shown, "/metrics/regret", "Scalars:scalars").items()} == {
        1: 0.25,
        2: 0.5,
        3: 0.75,
    }
