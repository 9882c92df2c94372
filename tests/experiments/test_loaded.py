"""Results as data: `load_run`, `load_comparison`, and `compare` and `inspect` from Python."""

import inspect
import sys
import types

import numpy as np
import pytest

import regista
import ued
from regista.experiments.commands.compare import CompareConfig
from regista.experiments.pictures import keys, plots
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.table import read_columns
from ued import METHODS, PPOConfig

GAME = "ued.probes:frontier"
SMALL = {"num_envs": 4, "ppo": PPOConfig(num_steps=32, num_minibatches=1), "eval_every": 0, "record": False}


@pytest.fixture
def run(tmp_path):
    return regista.train(GAME, method="plr", out=tmp_path / "run", total_env_steps=512, **SMALL)


@pytest.fixture
def comparison(tmp_path, trained_here):
    chosen = {"methods": ["dr", "plr"], "seeds": range(3, 5), "out": tmp_path / "both", "episodes": 4, "levels": 0}
    return regista.compare(GAME, total_env_steps=512, **chosen, **SMALL)


@pytest.mark.slow
def test_columns_need_no_pandas(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    data = regista.load_run(run)
    assert (data.name, data.config.method, data.config.num_envs) == ("plr", "plr", 4)
    metrics, levels = data.columns(), data.columns("levels")
    assert metrics["env_steps"][-1] >= 512 and len(levels["id"]) == len(levels["source"]) > 0
    with pytest.raises(CommandError, match=r"pip install 'regista\[data\]'"):
        data.metrics()
    with pytest.raises(UsageError, match="metrics or levels"):
        data.columns("replays")


@pytest.mark.slow
def test_tables_of_a_run_are_frames(run):
    pytest.importorskip("pandas")
    data = regista.load_run(run)
    for frame, columns in ((data.metrics(), read_columns(run / "metrics.csv")), (data.levels(), ued.read_levels(run))):
        assert list(frame.columns) == list(columns)
        for name, values in columns.items():
            assert np.array_equal(frame[name].to_numpy(), values, equal_nan=values.dtype.kind == "f"), name
    assert list(data.events().columns) == ["update", "env_steps", "event", "text"]
    (run / "events.csv").write_text("update,env_steps,event,text\n3,96,collapse,all levels are alike\n")
    assert data.events().to_dict("records") == [
        {"update": 3, "env_steps": 96, "event": "collapse", "text": "all levels are alike"}
    ]


@pytest.mark.parametrize("load", [regista.load_run, regista.load_comparison])
@pytest.mark.parametrize("path", [3, None, ["runs/plr"]])
def test_another_type_than_a_path_is_refused_with_the_argument(load, path):
    with pytest.raises(ValueError, match="path must be a path, such as 'runs/plr', got"):
        load(path)


@pytest.mark.long
def test_figures_are_drawn(run, comparison):
    assert [axes.get_title() for axes in regista.load_run(run).figure().axes if axes.get_visible()] != []
    labels = {text.get_text() for legend in comparison.figure().legends for text in legend.get_texts()}
    assert labels == {METHODS["dr"].title, METHODS["plr"].title, *keys.RUNS}
    colors = comparison.colors()
    assert set(colors) == {"dr", "plr", *plots.BASELINES} and colors["plr"] == METHODS["plr"].color
    (run / "metrics.csv").unlink()
    with pytest.raises(CommandError, match="no update has finished yet"):
        regista.load_run(run).figure()


@pytest.mark.slow
def test_methods_are_compared_from_python(comparison, tmp_path, capsys):
    folders = {"dr-3", "plr-3", "dr-4", "plr-4"}
    assert {path.name for path in (tmp_path / "both").iterdir() if path.is_dir()} == folders
    assert [(run.name, run.config.seed) for run in comparison.runs] == [("dr", 3), ("dr", 4), ("plr", 3), ("plr", 4)]
    assert repr(comparison) == f"ComparisonData({str(tmp_path / 'both')!r}, dr: 2 runs, plr: 2 runs)"
    assert repr(comparison.runs[0]) == f"RunData({str(tmp_path / 'both' / 'dr-3')!r}, dr, seed 3)"
    with pytest.raises(CommandError, match=r"it has no config\.json; it holds runs, such as .*dr-3"):
        regista.load_run(tmp_path / "both")
    for load in (regista.load_run, regista.load_comparison):
        with pytest.raises(CommandError, match=r"config\.json is not a run folder: .*; give the folder, .*dr-3$"):
            load(tmp_path / "both" / "dr-3" / "config.json")
    assert (tmp_path / "both" / "table.csv").exists()
    assert regista.load_comparison(tmp_path / "both").runs == comparison.runs
    table = tmp_path / "both" / "results.csv"
    table.write_text(table.read_text().replace("dr,", "zz,").replace("plr,", "dr,").replace("zz,", "plr,"))
    assert [run.name for run in regista.load_comparison(tmp_path / "both").runs] == ["plr", "plr", "dr", "dr"]


@pytest.mark.slow
def test_a_run_trained_from_python_is_finished(run):
    """A comparison keeps it, and starts no process for it."""
    assert RunFolder.open(run).finished()


@pytest.mark.long
def test_tables_of_a_comparison_are_frames(comparison):
    pytest.importorskip("pandas")
    results = comparison.results()
    assert set(results["method"]) == {"dr", "plr", "random"} and set(results["episodes"]) == {4}
    assert {"measure", "estimate", "low", "high"} <= set(comparison.table().columns)
    metrics = comparison.metrics()
    assert list(metrics.columns[:2]) == ["method", "run_seed"]
    assert set(metrics.groupby("method")["run_seed"].unique().explode()) == {3, 4}
    assert len(comparison.levels()) == sum(len(run.columns("levels")["id"]) for run in comparison.runs)
    (comparison.path / "results.csv").unlink()
    with pytest.raises(CommandError, match="after all runs are evaluated"):
        comparison.results()


@pytest.mark.parametrize("seeds", [0, range(0), range(0, 6, 2), "x", [0, 1], True])
def test_seeds_are_consecutive(seeds):
    with pytest.raises(ValueError, match="consecutive"):
        regista.compare(GAME, seeds=seeds)


def test_what_is_unknown_is_named():
    with pytest.raises(UsageError, match="unknown method 'plrr'"):
        regista.compare(GAME, ["plrr"])
    with pytest.raises(UsageError, match="unknown setting 'num_env'"):
        regista.compare(GAME, ["plr"], num_env=3)
    with pytest.raises(CommandError, match="holds no run folders"):
        regista.load_comparison("nowhere")


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: regista.train(GAME, total_env_steps="abc"), "total_env_steps must be an integer, got 'abc'"),
        (lambda: regista.train(GAME, ppo={"num_steps": 3}), r"ppo must be PPOConfig\(...\), got \{'num_steps': 3\}"),
        (lambda: regista.train(GAME, report="wandb"), "report must be a tuple or a list, got 'wandb'"),
        (lambda: regista.train(GAME, out=3), "out must be a path, such as 'runs/plr', got 3"),
        (lambda: regista.train(GAME, 3), "a method is a name, such as 'plr', got 3"),
        (lambda: regista.train(GAME, minigame="maze"), "unknown setting 'minigame'"),
        (lambda: regista.compare(GAME, 3), "a method is a name, such as 'plr', got 3"),
        (lambda: regista.compare(GAME, "plrr"), r"unknown method 'plrr' \(did you mean 'plr'\?\)"),
        (lambda: regista.compare(GAME, methds=["dr"]), r"unknown setting 'methds' \(did you mean 'methods'\?\)"),
        (lambda: regista.compare(GAME, method="dr"), r"unknown setting 'method' \(did you mean 'methods'\?\)"),
        (lambda: regista.compare(GAME, episodes="x"), "episodes must be an integer, got 'x'"),
        (lambda: regista.evaluate(3), "a run must be a path, such as 'runs/plr', got 3"),
        (lambda: regista.evaluate("run", episodes="x"), "episodes must be an integer, got 'x'"),
        (lambda: regista.inspect(GAME, n=1.5), "n must be an integer, got 1.5"),
    ],
)
def test_an_argument_of_another_type_is_refused_in_a_sentence(call, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ValueError, UsageError), match=f"^{sentence}"):
        call()
    assert not [*tmp_path.iterdir()]


@pytest.mark.long
def test_a_whole_number_may_be_a_float_and_one_method_a_name(tmp_path, trained_here):
    run = regista.load_run(regista.train(GAME, out=tmp_path / "run", total_env_steps=1e2, **SMALL))
    assert repr(run.config.total_env_steps) == "100"
    chosen = {"seeds": 1, "out": tmp_path / "one", "episodes": 4, "levels": 0, "total_env_steps": np.int64(128)}
    assert [run.name for run in regista.compare(GAME, "dr", **chosen, **SMALL).runs] == ["dr"]


def test_a_task_and_a_program_are_inspected():
    seen = regista.inspect(GAME, n=3, seed=1)
    assert seen.theta.shape == (3, len(seen.parameters)) and np.abs(seen.theta).max() <= 1
    assert [set(values) for values in seen.values] == [{"length0", "length1", "length2", "block"}] * 3
    assert str(seen).startswith("probes-frontier: D = 4 free parameters")
    program = regista.inspect("1v1Free", n=2)
    assert program.theta.shape == (2, 6) and "ego.x" in program.values[0] and ">99.9% of 4096" in program.text
    assert np.array_equal(program.theta, regista.inspect("1v1Free", n=2).theta)
    with pytest.raises(ValueError, match="at least 1"):
        regista.inspect(GAME, n=0)


@pytest.mark.slow
def test_python_and_the_command_line_have_the_same_defaults(tmp_path, monkeypatch):
    usual = {name: value.default for name, value in inspect.signature(regista.compare).parameters.items()}
    typed = CompareConfig()
    for name in ("methods", "seeds", "episodes", "levels"):
        assert usual[name] == getattr(typed, name)
    run = regista.load_run(regista.train(GAME, out=tmp_path / "run", total_env_steps=128, **SMALL))
    assert run.name == TrainConfig().method
    text = (
        "from ued.probes import frontier\nfrom dataclasses import replace\n"
        "own = replace(frontier, defaults={**frontier.defaults, 'method': 'accel'})\n"
    )
    (tmp_path / "own.py").write_text(text)
    run = regista.train(f"{tmp_path / 'own.py'}:own", out=tmp_path / "own", total_env_steps=128, **SMALL)
    assert regista.load_run(run).config.method == "accel"


def test_a_task_from_standard_input_is_to_be_saved(monkeypatch):
    session = types.ModuleType("session")
    session.__file__ = "<stdin>"  # as Python names the module of `python - < session`
    exec("def make(num_envs): ...", vars(session))
    monkeypatch.setitem(sys.modules, "session", session)
    with pytest.raises(UsageError, match=r"save code from standard input, .* in a file, such as task\.py"):
        regista.train(session.make)
