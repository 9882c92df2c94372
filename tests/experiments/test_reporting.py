"""Whoever is told of a run: what somebody should know, who fails without ending it, other people's trackers."""

from types import SimpleNamespace

import numpy as np
import pytest

from regista.experiments.__main__ import main
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.events import NARROW_UPDATES, QUIET_UPDATES, Watch
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.reporting import Reporters
from regista.experiments.run.table import read_columns, read_rows
from tests.experiments.probe import ProbeMethod, ProbeUPOMDP
from ued.learning.learner import episode_metrics
from ued.learning.worker import Episodes
from ued.statistics import of_episodes

SHORT = ["--total-env-steps", "8000", "--eval-every", "4000", "--eval-episodes", "4", "--no-record"]


def told(rows, **known):
    """Return what a watch says of these rows: (row, event)."""
    watch = Watch(**known)
    return [(number, event.event) for number, row in enumerate(rows, 1) for event in watch.look(row)]


def test_no_episode_is_told_once_until_one_has_ended():
    silent = [{"episodes/student": 0.0}] * (QUIET_UPDATES + 5)
    rows = [*silent, {"episodes/student": 1.0}, *silent]
    assert told(rows) == [(QUIET_UPDATES, "no episode"), (2 * QUIET_UPDATES + 6, "no episode")]


@pytest.mark.parametrize(
    ("limit", "words"), [(1000, "the limit is 1_000"), (None, "the environment declares no limit")]
)
def test_no_episode_says_how_long_the_longest_one_is_and_what_its_limit_is(limit, words):
    watch = Watch(limit=limit)
    events = [
        event
        for update in range(1, QUIET_UPDATES + 1)
        for event in watch.look({"episodes/student": 0.0, "open/student": 64.0 * update})
    ]
    expected = f"no episode of student has ended in 10 updates; the longest open one has 640 steps so far, {words}"
    assert [event.text for event in events] == [expected]
    watch = Watch(limit=limit)  # of a run that did not note the length yet
    older = [event for _ in range(QUIET_UPDATES) for event in watch.look({"episodes/student": 0.0})]
    assert [event.text for event in older] == [f"no episode of student has ended in 10 updates; {words}"]


def steps_of(name, *steps, each=100):
    """Return rows of so many gradient steps, `each` env_steps apart."""
    return [{f"{name}/gradient_steps": float(n), "env_steps": each * k} for k, n in enumerate(steps, 1)]


def test_who_learns_nothing_is_told_at_half_of_the_run_and_at_its_end():
    for name in ("student", "adversary"):
        assert told(steps_of(name, *[0] * 10), total=1000) == [(5, "no learning"), (10, "no learning")]
    assert told(steps_of("student", *[0] * 7, 8, 8, 8), total=1000) == [(5, "no learning"), (10, "little learning")]
    assert told(steps_of("student", 0, *[8] * 9), total=1000) == []
    assert told(steps_of("adversary", 0, 0, 0, 0, 8, 0, 0, 0, 0, 8), total=1000) == []  # it waits for many levels
    assert told(steps_of("student", 0, 0, 0), total=1000) == []  # not over yet
    watch = Watch(total=300)
    (event,) = [event for row in steps_of("student", 8, 0, 0) for event in watch.look(row)]
    assert event.text == "student has taken gradient steps in only 1 of 3 updates (33%)"


def evaluated(value, error=0.05):
    """Return the row of an evaluation: a mean return with its interval."""
    return {"eval/hard": value, "eval_low/hard": value - error, "eval_high/hard": value + error}


def goals(scored, episodes):
    """Return the row of an evaluation in which so many episodes have a goal."""
    found = of_episodes(np.repeat([1.0, 0.0], [scored, episodes - scored]))
    return dict(zip(("eval/hard", "eval_low/hard", "eval_high/hard"), found, strict=True))


def test_forgetting_is_losing_half_of_what_was_gained():
    returns = [0.2, 0.8, 0.6, float("nan"), 0.4, float("nan"), 0.3, 0.7, 0.1]
    assert told([evaluated(value) for value in returns]) == [(5, "forgetting"), (9, "forgetting")]
    assert told([evaluated(value) for value in (0.5, 0.4, 0.1)]) == []  # nothing had been gained
    assert told([evaluated(value) for value in (-1290.0, -1253.0, -1287.0)]) == []  # nor more than by chance


def test_a_goal_fewer_is_not_forgotten():
    """One goal in 16 episodes after two: the intervals of both have most in common."""
    assert told([goals(0, 16), goals(2, 16), goals(1, 16), goals(0, 16)]) == []
    assert told([goals(0, 16), goals(14, 16), goals(2, 16)]) == [(3, "forgetting")]
    assert told([goals(0, 4), goals(4, 4), goals(0, 4)]) == []  # too few episodes for an interval
    assert told([goals(0, 500), goals(100, 500), goals(30, 500)]) == [(3, "forgetting")]


def test_returns_are_forgotten_where_they_differ_by_more_than_episodes_do():
    assert told([evaluated(value, error=0.5) for value in (0.2, 0.8, 0.1)]) == []


def test_collapse_and_invalid_proposals():
    narrow = [{"theta_coverage": 0.2}] * NARROW_UPDATES
    assert told([*narrow[1:], {"theta_coverage": 0.3}, *narrow]) == [(2 * NARROW_UPDATES, "collapse")]
    assert told([{"levels/replaced": 4.0, "levels/proposed": 6.0}] * 5) == [(3, "invalid proposals")]
    assert told([{"levels/replaced": 2.0, "levels/proposed": 8.0}] * 5) == []


def test_a_continued_run_says_what_it_would_have_said(tmp_path, capsys):
    run = SimpleNamespace(metrics=SimpleNamespace(path=tmp_path / "metrics.csv"))
    run.config = SimpleNamespace(minigame="1v1Free", total_env_steps=100)
    rows = "1,0.2,0.1,0.3,\n2,0.8,0.7,0.9,8\n3,,,,0\n"
    header = "update,eval/hard,eval_low/hard,eval_high/hard,student/gradient_steps\n"
    (tmp_path / "metrics.csv").write_text(header + rows)
    reporters = Reporters(run, ProbeUPOMDP())
    assert [event.event for event in reporters.watch.look(evaluated(0.3))] == ["forgetting"]
    assert reporters.watch.learning.updates == {"student": 2} and reporters.watch.learning.learned == {"student": 1}


def test_rolling_returns_outlast_updates_without_an_episode():
    none = Episodes(np.zeros(0), np.zeros(0))
    assert np.isnan(episode_metrics("student", none, np.zeros(0))["return_100/student"])
    metrics = episode_metrics("student", none, np.array([1.0, 0.0]))
    assert metrics["return_100/student"] == 0.5 and np.isnan(metrics["return/student"])


def test_one_who_fails_is_told_nothing_more_and_the_run_goes_on(probe, tmp_path, capsys):
    class Fails:
        reports = 0

        def report(self, update):
            Fails.reports += 1
            raise OSError("no room")

    run = RunFolder.create(tmp_path / "run", TrainConfig())
    reporters = Reporters(run, ProbeUPOMDP())
    reporters.add("counted", Fails)
    reporters.add("opened", lambda: 1 / 0)
    method = ProbeMethod(SimpleNamespace(seed=0), ProbeUPOMDP())
    for _ in range(3):
        reporters.report(method, method.update())
    reporters.close()
    said = capsys.readouterr().err
    assert Fails.reports == 1 and said.count("no more updates are counted: OSError: no room") == 1
    assert "no more updates are opened: ZeroDivisionError" in said
    assert len(read_rows(run.metrics.path)) == 3 and len(read_rows(run.levels.path)) == 24


def test_tensorboard_has_every_scalar_under_its_name(probe, tmp_path):
    pytest.importorskip("tensorboard")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    path = tmp_path / "run"
    assert main(["train", "1v1Restricted", "--out", str(path), *SHORT, "--report", "tensorboard"]) == 0
    events = EventAccumulator(str(path / "tensorboard"))
    events.Reload()
    table = read_columns(path / "metrics.csv")
    assert set(events.Tags()["scalars"]) == set(table)
    scalars = events.Scalars("regret")
    assert [event.step for event in scalars] == table["env_steps"].tolist()
    assert np.allclose([event.value for event in scalars], table["regret"])


def test_wandb_is_offline_and_goes_on_under_one_id(probe, tmp_path, monkeypatch):
    pytest.importorskip("wandb")
    monkeypatch.delenv("WANDB_MODE", raising=False)
    path = tmp_path / "run"
    assert main(["train", "1v1Restricted", "--out", str(path), *SHORT, "--report", "wandb"]) == 0
    assert main(["train", "--resume", str(path), "--total-env-steps", "9000"]) == 0
    name = RunFolder.open(path).about["id"]
    assert len(list((path / "wandb").glob(f"offline-run-*-{name}"))) == 2


def test_a_tracker_that_is_not_installed_is_asked_for_in_a_sentence(probe, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("regista.experiments.run.trackers.find_spec", lambda name: None)
    assert main(["train", "1v1Restricted", "--out", str(tmp_path / "run"), *SHORT, "--report", "wandb"]) == 1
    assert "--report wandb needs an extra: pip install 'regista[wandb]'" in capsys.readouterr().err
    assert main(["train", "1v1Restricted", "--report", "mlflow"]) == 2
    assert "invalid choice: 'mlflow'" in capsys.readouterr().err
