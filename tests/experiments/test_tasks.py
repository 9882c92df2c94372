"""A task of one's own gets all that football has: run folder, tests, resuming, comparison, inspection, recording."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import regista
from regista.experiments.__main__ import main
from regista.experiments.commands import compare
from regista.experiments.run import trust
from regista.experiments.run.build import find_game
from regista.experiments.run.errors import CommandError, UsageError
from regista.experiments.run.folder import RunFolder
from ued.core import checkpoint

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent.parent
SHORT = ["--num-envs", "4", "--num-steps", "16", "--hidden-size", "8", "--eval-every", "128", "--eval-episodes", "4"]
TASK = '''
"""A ball that is pushed to one side; how hard it must be pushed is the level."""

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete

import ued


class Push(gymnasium.Env):
    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}
    observation_space = Dict({"at": Box(-9, 9, (1,), np.float32), "ground": Discrete(2)})
    action_space = Discrete(2)

    def __init__(self):
        self.render_mode = "rgb_array"

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at, self.steps = 0.0, 0
        return self.look(), {}

    def step(self, action):
        self.at += (2 * action - 1) * self.force
        self.steps += 1
        return self.look(), float(self.at > 2), bool(self.at > 2), self.steps >= 6, {}

    def look(self):
        return {"at": np.array([self.at], np.float32), "ground": int(self.ground == "ice")}

    def render(self):
        return np.full((8, 8, 3), int(20 * self.steps), np.uint8)


def put(env, values):
    env.unwrapped.force, env.unwrapped.ground = values["force"], values["ground"]


def make(num_envs):
    kinds = {"force": ued.LogRange(0.1, 2.0), "ground": ued.Choice("grass", "ice")}
    return ued.GymUPOMDP(Push, put, kinds, num_envs)


rows = [[-1, 0], [0, 0], [1, 0]]
push = ued.Task(make, tests={"strong": {"force": 1.0, "ground": "ice"}, "three": rows, "other": make})
broken = ued.Task(make, tests={"wrong": {"speed": 1}})


class Right:
    def __init__(self, upomdp):
        self.random = ued.core.baselines.SampledPolicy(upomdp.single_action_space)
        self.empty_memory = self.random.empty_memory

    def play(self, observation, generator, greedy=False, memory=None):
        return np.ones(len(observation), int)


whole = ued.Task(
    make,
    tests={"strong": {"force": 1.0, "ground": "ice"}},
    held_out={"weak": {"force": 0.4, "ground": "grass"}},
    baselines={"right": Right},
    defaults={"total_env_steps": 192, "ppo.gamma": 0.5, "plr.replay_prob": 0.25},
    success_word="pushes",
)
DEFAULTS = {
    "unknown": {"ppo.gama": 0.5}, "text": {"num_envs": "many"}, "half": {"num_envs": 4.5}, "group": {"ppo": {}},
    "deep": {"ppo.gamma.x": 1}, "range": {"ppo.gamma": 7.0}, "number": {3: 4}, "itself": {"minigame": "1v1Free"},
}
globals().update({name: ued.Task(make, defaults=values) for name, values in DEFAULTS.items()})
part = ued.Task(make, defaults={"ppo": ued.PPOConfig(gamma=0.25), "num_envs": np.int64(2)})
raising = ued.Task(make, baselines={"mine": lambda upomdp: 1 / 0})
none = ued.Task(make, baselines={"mine": lambda upomdp: 3})


class Painter:
    bounds = reach = (-1.0, 1.0, -1.0, 1.0)
    background, line_color, markers = (20, 20, 20), (250, 250, 250), [("me", (255, 0, 0), 0.1)]
    classes, focus = np.zeros(1, int), 0

    def __init__(self, upomdp):
        self.lines = lambda: [np.array([[-1.0, -1.0], [1.0, 1.0]])]
        self.positions = lambda theta: theta[:, None]
        self.frame = lambda env: env.levels["theta"][:1]


class Wrong(Painter):
    def __init__(self, upomdp):
        super().__init__(upomdp)
        self.positions = lambda theta: np.zeros((1, 7))


painted = ued.Task(make, painter=Painter)
fails = ued.Task(make, painter=lambda upomdp: {}["nothing"])
lacks = ued.Task(make, painter=lambda upomdp: 3)
wrong = ued.Task(make, painter=Wrong)
'''


@pytest.fixture
def task(tmp_path):
    (tmp_path / "push_task.py").write_text(TASK)
    return f"{tmp_path / 'push_task.py'}:push"


def test_the_class_of_one_environment_is_no_task(task, capsys):
    assert main(["train", task.replace(":push", ":Push")]) == 2
    assert "that returns a UPOMDP, got the class of one environment; make wraps" in capsys.readouterr().err


def named(task, name):
    """Return the game of another task of the file, as if this user had typed its name."""
    trust.allow(task.replace(":push", f":{name}"))
    return find_game(task.replace(":push", f":{name}"))


def rows(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def train(task, out, *more):
    return main(["train", task, *SHORT, "--out", str(out), *more])


def test_a_run_has_all_files_and_its_tests_are_the_tasks(task, tmp_path):
    out = tmp_path / "run"
    assert train(task, out, "--method", "accel", "--total-env-steps", "256", "--record-rollouts", "1") == 0
    files = {"config.json", "task.py", "metrics.csv", "levels.csv", "checkpoint.pt", "curriculum.rrd"}
    assert files <= {path.name for path in out.iterdir()}
    last = rows(out / "metrics.csv")[-1]
    assert all(last[f"eval/{name}"] for name in ("training distribution", "strong", "three", "other"))
    assert "theta/ground" in rows(out / "levels.csv")[0] or len(rows(out / "levels.csv")) == 0
    assert (out / "curriculum.rrd").stat().st_size > 5000  # curves, θ and a film
    assert "env" not in (out / "config.json").read_text().split('"')


def test_a_run_continues_from_its_checkpoint(task, tmp_path):
    out = tmp_path / "run"
    assert train(task, out, "--method", "plr", "--total-env-steps", "128", "--no-record") == 0
    before = rows(out / "metrics.csv")
    assert main(["train", "--resume", str(out), "--total-env-steps", "320"]) == 0
    after = rows(out / "metrics.csv")
    assert after[: len(before)] == before and int(after[-1]["env_steps"]) == 320
    assert main(["train", "--resume", str(out), "--gamma", "0.5"]) == 1


@pytest.mark.drawn
def test_evaluate_and_compare(task, trained_here, tmp_path, capsys):
    settings = ["--total-env-steps", "128", "--episodes", "4", "--levels", "10", "--level-episodes", "2", "--no-record"]
    out = tmp_path / "both"
    command = ["compare", task, "--methods", "dr", "paired", "--seeds", "1", "--processes", "1", *SHORT, *settings]
    assert main([*command, "--out", str(out)]) == 0
    table = (out / "table.txt").read_text()
    assert "strong" in table and "success" in table and "goals" not in table and "random" in table
    assert {"learning_curves.png", "levels.png", "table.md"} <= {path.name for path in out.iterdir()}
    capsys.readouterr()
    assert main(["evaluate", str(out / "dr-0"), "--episodes", "4", "--levels", "0"]) == 0
    assert "three" in capsys.readouterr().out


@pytest.mark.long
def test_a_comparison_begins_with_students_of_the_same_seeds(task, trained_here, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(compare, "draw", lambda comparison, folder, kind: None)
    start, out = tmp_path / "start", tmp_path / "tuned"
    short = [*SHORT, "--seeds", "2", "--levels", "0", "--episodes", "2", "--no-record", "--total-env-steps", "128"]
    assert main(["compare", task, "--methods", "dr", *short, "--hidden-size", "12", "--out", str(start)]) == 0
    short[short.index("--hidden-size") : short.index("--hidden-size") + 2] = []  # the student's, whatever the default
    command = ["compare", task, "--methods", "dr", "sfl", *short, "--out", str(out)]
    assert main([*command, "--from", str(start)]) == 0
    for seed in (0, 1):
        students = [checkpoint.load(out / f"{name}-{seed}" / "origin.pt")["student"] for name in ("dr", "sfl")]
        trained = checkpoint.load(start / f"dr-{seed}" / "checkpoint.pt")["method"]["learners"][0]["ppo"]["student"]
        tensors = {name: value for name, value in trained.items() if hasattr(value, "shape")}
        assert tensors
        for name, weights in tensors.items():
            assert all(np.array_equal(student[name], weights) for student in students)
    assert RunFolder.open(out / "sfl-1").config.ppo.hidden_size == 12
    assert {row["method"] for row in rows(out / "results.csv")} == {"dr", "sfl", "random"}
    capsys.readouterr()
    assert main([*command, "--hidden-size", "12"]) == 1
    assert "cannot continue with a new student" in capsys.readouterr().err
    assert main([*command, "--from", str(out)]) == 1
    assert "holds 2 runs of seed 0: --from takes a run, or a comparison of one method" in capsys.readouterr().err
    assert main([*command, "--kl-to-clone", "1"]) == 2
    assert main([*command, "--from", str(start), "--kl-to-clone", "1"]) == 1
    said = capsys.readouterr().err
    assert "dr-0 started with --kl-to-clone 0.0 --kl-share 0.5; it cannot continue with 1.0 and 0.5" in said


@pytest.mark.long
def test_a_program_that_trained_in_processes_ends(tmp_path):
    script = tmp_path / "push_script.py"
    text = TASK.replace(', "other": make', "")
    text = text.replace("kinds, num_envs)", 'kinds, num_envs, vectorization="async")')
    call = 'regista.train(push, "dr", out="run", total_env_steps=64, num_envs=2, record=False, eval_every=0)'
    script.write_text(f"{text}\nif __name__ == '__main__':\n    import regista\n    {call}\n")
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, script.name], cwd=tmp_path, timeout=60, check=True, env=env)
    assert RunFolder.open(tmp_path / "run").env_steps() >= 64


@pytest.mark.drawn
def test_inspect_tells_kinds_and_draws_first_frames(task, tmp_path, capsys):
    assert main(["inspect", task, "--n", "3", "--png", str(tmp_path / "levels.png")]) == 0
    out = capsys.readouterr().out
    assert "LogRange" in out and "Choice" in out and "grass" in out and "level 2: force = " in out
    assert (tmp_path / "levels.png").stat().st_size > 1000
    assert main(["inspect", task, "--theta", "0", "1"]) == 0
    assert "level 0: force = 0.4472, ground = ice" in capsys.readouterr().out


def test_environments_that_cannot_be_drawn_are_told_what_they_need(tmp_path, capsys):
    (tmp_path / "undrawn.py").write_text(
        "import gymnasium, ued\n"
        "def make(num_envs):\n"
        "    one = lambda: gymnasium.make('CartPole-v1')\n"
        "    return ued.GymUPOMDP(one, lambda env, values: None, {'a': (0, 1)}, num_envs)\n"
    )
    assert main(["inspect", f"{tmp_path / 'undrawn.py'}:make", "--png", str(tmp_path / "levels.png")]) == 1
    error = capsys.readouterr().err
    assert 'render_mode="rgb_array"' in error and "sets self.render_mode and has render()" in error


def test_one_call_from_python_trains_tests_and_loads_a_policy(task, tmp_path):
    out = tmp_path / "run"
    settings = {"num_envs": 4, "ppo": regista.PPOConfig(num_steps=16, hidden_size=8), "record": False, "eval_every": 0}
    assert regista.train(task, method="plr", out=out, total_env_steps=128, **settings) == out
    assert regista.train(task, method="plr", out=out, total_env_steps=192, **settings) == out  # goes on
    assert RunFolder.open(out).env_steps() == 192
    assert "strong" in regista.evaluate(out, episodes=4).text()
    policy = regista.load_policy(out)
    assert policy.act(np.zeros(3, np.float32)) in (0, 1)
    assert policy.act(np.zeros((5, 3), np.float32), greedy=True).shape == (5,)
    with pytest.raises(ValueError, match=r"an observation must have shape \(3,\)"):
        policy.act(np.zeros(4))
    import push_task

    env = push_task.Push()
    policy = regista.load_policy(out, env.observation_space)
    assert policy.act({"at": np.zeros(1, np.float32), "ground": 1}) in (0, 1)


def test_a_student_with_a_memory_is_trained_further_tested_recorded_and_loaded(task, tmp_path):
    out = tmp_path / "run"
    more = ["--method", "paired", "--memory", "gru", "--num-minibatches", "2", "--record-rollouts", "1"]
    assert train(task, out, "--total-env-steps", "256", *more) == 0
    assert main(["train", "--resume", str(out), "--total-env-steps", "384"]) == 0
    assert RunFolder.open(out).config.ppo.memory == "gru" and RunFolder.open(out).env_steps() == 384
    assert "strong" in regista.evaluate(out, episodes=4).text()
    policy, seen = regista.load_policy(out), np.ones((2, 3), np.float32)
    policy.act(seen)
    assert policy.player.memory.any(1).all()
    policy.begin(np.array([True, False]))
    assert policy.player.memory.any(1).tolist() == [False, True]
    policy.act(seen[0])  # another number of environments: all anew
    policy.begin()
    assert policy.player.memory.shape[0] == 1 and not policy.player.memory.any()


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["train", "{}/nowhere.py:push"], "there is no file"),
        (["train", "{}/push_task.py:pusch"], "has no 'pusch' (did you mean 'push'?)"),
        (["train", "{}/push_task.py:put", "--out", "{}/x"], "failed: TypeError: put() missing 1 required positional"),
        (["train", "{}/push_task.py"], "a Python task must be file.py:name"),
        (["inspect", "{}/push_task.py:push", "--engine", "scenic3"], "--engine applies to programs; a task is Python"),
        (["inspect", "{}/push_task.py:push", "--rrd", "{}/x.rrd"], "--rrd and --show are for Scenic programs"),
        (["inspect", "{}/push_task.py:push", "--show", "code"], "--rrd and --show are for Scenic programs"),
        (["train", "no_such_module:make"], "there is no module no_such_module"),
        (["train", "{}/push_task.py:push", "--control", "all"], "unknown flag --control"),
        (["train", "--out", "1v1Free", "{}/push_task.py:push", "--control", "all"], "unknown flag --control"),
        (["compare", "--out", "1v1Free", "{}/push_task.py:push", "--control", "all"], "unknown flag --control"),
        (["train", "{}/push_task.py:broken", "--out", "{}/b", "--eval-every", "0"], "value for each of force, ground"),
    ],
)
def test_what_is_no_task_is_told(command, message, task, tmp_path, capsys):
    words = [word.format(tmp_path) for word in command]
    assert main(words) in (1, 2)
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("import no_such_package\n\nmake = None", "No module named 'no_such_package' ({}, line 1)"),
        ("import ued\n\ndef make(n):\n    return ued.Range(2, 1)", "got 2 and 1 ({}, line 4)"),
        ("import ued\n\nmake = ued.Task(1, ['a'])", "tests must be a mapping by name, got ['a'] ({}, line 3)"),
        ("import ued\n\nmake = ued.Task(print, {'training distribution': 1})", "a test cannot be called 'training"),
        ("def make(:", "SyntaxError"),
    ],
)
def test_what_goes_wrong_in_a_file_of_yours_is_told_with_its_line(source, message, tmp_path, capsys):
    file = tmp_path / "mine.py"
    for text in (source, source + "\n"):  # a file that could not be read leaves nothing behind
        file.write_text(text)
        assert main(["train", f"{file}:make", "--out", str(tmp_path / "x")]) == 1
        told = capsys.readouterr().err
        assert message.format(file) in told and len(told.splitlines()) == 1


def test_inspect_lists_the_values_of_a_choice(tmp_path, capsys):
    file = tmp_path / "grounds.py"
    file.write_text(
        "import gymnasium, ued\nkinds = {'ground': ued.Choice('grass', 'sand', 'ice')}\n"
        "make = lambda n: ued.GymUPOMDP(lambda: gymnasium.make('CartPole-v1'), lambda env, values: None, kinds, n)"
    )
    assert main(["inspect", f"{file}:make"]) == 0
    shown = capsys.readouterr().out
    assert "grass, sand, ice" in shown and "of random θ" not in shown  # the task has no check


def test_a_family_of_levels_is_a_task(tmp_path):
    shutil.copy(ROOT / "examples" / "own_levels.py", tmp_path / "levels_copy.py")
    out = tmp_path / "run"
    assert train(f"{tmp_path / 'levels_copy.py'}:make", out, "--method", "accel", "--total-env-steps", "512") == 0
    assert len(rows(out / "metrics.csv")) == 8


def test_a_task_brings_defaults_baselines_held_out_scenes_and_its_word(task, trained_here, tmp_path, capsys):
    whole, out = task.replace(":push", ":whole"), tmp_path / "both"
    command = ["compare", whole, "--methods", "dr", "plr", "--seeds", "1", *SHORT, "--no-record", "--out", str(out)]
    assert main([*command, "--episodes", "4", "--levels", "0", "--held-out"]) == 0
    config = RunFolder.open(out / "plr-0").config
    assert (config.total_env_steps, config.ppo.gamma, config.plr.replay_prob) == (192, 0.5, 0.25)
    found = rows(out / "results.csv")
    assert {row["scene"] for row in found} == {"training distribution", "weak"}
    assert {row["method"] for row in found} == {"dr", "plr", "right", "random"}
    assert "pushes" in (out / "table.txt").read_text()
    (right,) = [row for row in found if (row["method"], row["scene"]) == ("right", "weak")]
    assert right["goals"] == right["episodes"] == "4"
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main(["train", whole, "--help"])
    assert "(default 192" in capsys.readouterr().out
    assert main(["train", whole, "--gamma", "0.9", *SHORT, "--no-record", "--out", str(tmp_path / "run")]) == 0
    assert RunFolder.open(tmp_path / "run").config.ppo.gamma == 0.9


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("unknown", "there is no setting 'ppo.gama' (did you mean 'ppo.gamma'?)"),
        ("text", "'num_envs' must be int, got \"many\""),
        ("half", "'num_envs' must be int, got 4.5"),
        ("group", "'ppo' is a group of settings; give one, such as 'ppo."),
        ("deep", "there is no setting 'ppo.gamma.x'"),
        ("range", "gamma must be between 0 and 1, got 7.0"),
        ("number", "there is no setting '3'"),
        ("itself", "'minigame' is the task itself"),
    ],
)
def test_defaults_that_are_no_settings_are_refused(name, message, task, tmp_path, capsys):
    assert train(task.replace(":push", f":{name}"), tmp_path / "run") == 1
    said = capsys.readouterr().err
    assert "invalid defaults" in said and message in said


def test_defaults_may_be_a_group_and_numbers_of_numpy(task):
    config = named(task, "part").start("fast")
    assert (config.ppo.gamma, config.num_envs, type(config.num_envs)) == (0.25, 2, int)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("raising", "the baseline 'mine' failed: ZeroDivisionError"),
        ("none", "must be a policy with a method play, got 3"),
    ],
)
def test_a_baseline_that_is_no_policy_is_a_sentence(name, message, task):
    loaded = named(task, name).task(None)
    upomdp = loaded.make(1)
    with pytest.raises(CommandError, match=message):
        loaded.make_baselines(upomdp)
    upomdp.close()


def test_a_painter_that_fails_ends_the_recording_and_not_the_training(task, tmp_path, capsys):
    assert train(task.replace(":push", ":wrong"), tmp_path / "run", "--method", "dr", "--total-env-steps", "128") == 0
    said = capsys.readouterr().err
    assert "no more updates are recorded: the painter's positions() must return an array of shape (" in said


def test_a_painter_that_fails_is_a_sentence(task):
    tasks = {name: named(task, name).task(None) for name in ("painted", "fails", "lacks", "wrong")}
    upomdp = tasks["painted"].make(1)
    painter = tasks["painted"].painter(upomdp)
    assert painter.focus == 0 and len(painter.lines()) == 1
    assert painter.positions(np.zeros((3, 2))).shape == (3, 1, 2)
    with pytest.raises(CommandError, match=r"painter failed: KeyError: 'nothing' \(.*push_task.py, line"):
        tasks["fails"].painter(upomdp)
    with pytest.raises(CommandError, match="the painter must have the attribute bounds"):
        tasks["lacks"].painter(upomdp)
    with pytest.raises(CommandError, match=r"must return an array of shape \(3, 1, 2\), got \(1, 7\)"):
        tasks["wrong"].painter(upomdp).positions(np.zeros((3, 2)))
    upomdp.close()


def test_a_task_without_held_out_scenes_says_so(task, tmp_path, capsys):
    assert main(["compare", task, "--held-out", *SHORT, "--out", str(tmp_path / "out")]) == 2
    assert "push_task-push has no held-out scenes" in capsys.readouterr().err


def test_whatever_is_no_task_is_refused_from_python(task, tmp_path):
    with pytest.raises(UsageError, match=r"a task must be a ued\.Task, a function make\(num_envs\) or a name, got 3"):
        regista.train(3)
    with pytest.raises(UsageError, match="a global name of a Python file"):
        regista.train(lambda num_envs: None)


def test_runs_of_several_tasks_are_not_evaluated_together(task, tmp_path):
    out, other = tmp_path / "run", tmp_path / "other"
    for name, path in (("push", out), ("part", other)):
        assert train(task.replace(":push", f":{name}"), path, "--method", "dr", "--total-env-steps", "64") == 0
    with pytest.raises(CommandError, match="these runs are of different minigames"):
        regista.evaluate([out, other], episodes=2)
    with pytest.raises(UsageError, match="needs at least one run folder"):
        regista.evaluate([])
    with pytest.raises(ValueError, match="levels must be 0 or at least 10"):
        regista.evaluate(out, levels=5)
    with pytest.raises(ValueError, match="episodes must be at least 1, got 0"):
        regista.evaluate(out, episodes=0)
