"""A stranger's run folder runs none of its Python; a user's own runs need no word of it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import regista
from regista.experiments.__main__ import main
from regista.experiments.run import tasks, trust
from regista.experiments.run.folder import RunFolder
from ued.core import checkpoint

ROOT = Path(__file__).parents[2]
TINY = ["--num-envs", "2", "--num-steps", "8", "--total-env-steps", "16", "--eval-episodes", "1"]
SOURCE = """
import pathlib
import ued
from ued.probes import Frontier

pathlib.Path({marker!r}).touch()

def make(num_envs):
    return Frontier(num_envs, longest=3)
"""
READ = {
    "evaluate": ["evaluate", "{run}", "--episodes", "2", "--levels", "0"],
    "gallery": ["evaluate", "--gallery", "{run}"],
    "resume": ["train", "--resume", "{run}", "--total-env-steps", "32"],
    "from": ["train", "--from", "{run}", *TINY, "--method", "dr", "--out", "{run}-next"],
    "compare from": ["compare", "--from", "{run}", "--seeds", "1", "{run}"],
    "demonstrate": ["demonstrate", "--run", "{run}", "--out", "{run}-demos"],
    "transfer": ["transfer", "{run}"],
}


@pytest.fixture(autouse=True)
def _nobody_named_anything(monkeypatch, tmp_path):
    """Begin as another user: nothing is remembered."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(trust, "_named", set())
    monkeypatch.chdir(tmp_path)


def write(path: Path) -> Path:
    """Write a task; return the file that tells that it was run."""
    path.parent.mkdir(parents=True, exist_ok=True)
    marker = path.with_suffix(".ran")
    path.write_text(SOURCE.format(marker=str(marker)))
    sys.modules.pop(path.stem, None)
    return marker


@pytest.fixture(name="run")
def _run(tmp_path):
    """Return a run of an honest task."""
    write(tmp_path / "honest_task.py")
    assert main(["train", "honest_task.py:make", *TINY, "--out", "runs/run"]) == 0
    return tmp_path / "runs" / "run"


def forged(run: Path, minigame: str) -> Path:
    """Return a copy of a run that names another task, in its settings and in its checkpoint."""
    copy = run.with_name("stranger")
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(run, copy)
    data = json.loads((copy / "config.json").read_text()) | {"minigame": minigame}
    (copy / "config.json").write_text(json.dumps(data))
    state = checkpoint.load(copy / "checkpoint.pt")
    state["config"]["minigame"] = minigame
    checkpoint.save(copy / "checkpoint.pt", state)
    return copy


@pytest.mark.long
@pytest.mark.parametrize("command", READ)
def test_no_command_runs_what_only_a_folder_names(run, command, capsys):
    evil = run.with_name("stranger") / "evil_task.py"
    folder = forged(run, f"{evil}:make")
    marker = write(evil)
    assert main([word.format(run=folder) for word in READ[command]]) in (1, 2)
    said = capsys.readouterr().err
    assert not marker.exists() and "Traceback" not in said
    if command in ("evaluate", "gallery", "resume", "from"):
        assert f"a file names the task {evil}:make, which is Python code" in said and "add --trust" in said


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize("place", ["inside", "beside", "relative", "dots", "link", "module", "package", "other name"])
def test_however_it_is_named(run, place, tmp_path, capsys):
    downloads = tmp_path / "downloads"
    marker = write(downloads / "evil_task.py")
    write(tmp_path / "runs" / "evil_task.py")
    (tmp_path / "link.py").symlink_to(downloads / "evil_task.py")
    (tmp_path / "evil_package").mkdir()
    shutil.copy(downloads / "evil_task.py", tmp_path / "evil_package" / "__init__.py")
    shutil.copy(downloads / "evil_task.py", tmp_path / "evil_package" / "inner.py")
    names = {
        "inside": f"{tmp_path}/runs/stranger/task.py:make",
        "beside": f"{downloads}/evil_task.py:make",
        "relative": "downloads/evil_task.py:make",
        "dots": f"{tmp_path}/runs/../downloads/../downloads/evil_task.py:make",
        "link": f"{tmp_path}/link.py:make",
        "module": "downloads.evil_task:make",
        "package": "evil_package.inner:make",
        "other name": f"{tmp_path}/honest_task.py:pathlib",  # of a file that is trusted
    }
    folder = forged(run, names[place])
    shutil.copy(downloads / "evil_task.py", folder / "task.py")
    assert main(["evaluate", str(folder), "--episodes", "2", "--levels", "0"]) == 1
    assert "add --trust to run it" in capsys.readouterr().err and not marker.exists()


@pytest.mark.slow
def test_a_folder_called_as_its_task_is_not_a_task_that_was_named(run, tmp_path):
    marker = write(tmp_path / "evil_task.py")
    folder = tmp_path / "evil_task.py:make"
    forged(run, "evil_task.py:make").rename(folder)
    assert main(["evaluate", folder.name, "--episodes", "2", "--levels", "0"]) == 1
    assert not marker.exists()


@pytest.mark.slow
def test_trust_is_typed_and_not_remembered(run, capsys):
    evil = run.with_name("stranger") / "evil_task.py"
    folder, marker = forged(run, f"{evil}:make"), write(evil)
    words = ["evaluate", str(folder), "--episodes", "2", "--levels", "0"]
    assert main([*words, "--trust"]) == 0 and marker.exists()
    assert main(words) == 1


@pytest.mark.slow
def test_ones_own_runs_need_no_word(run, tmp_path):
    """In another process, too, and from another folder."""
    (tmp_path / "elsewhere").mkdir()
    words = [sys.executable, "-m", "regista", "evaluate", str(run), "--episodes", "2", "--levels", "0"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, cwd=tmp_path / "elsewhere", env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_a_note_that_others_may_write_is_none(run, tmp_path):
    notes = tmp_path / "state" / "regista" / "tasks"
    assert trust.allows(f"{tmp_path}/honest_task.py:make")
    notes.chmod(0o777)
    assert not trust.allows(f"{tmp_path}/honest_task.py:make")


@pytest.mark.slow
def test_a_link_that_leads_elsewhere_by_now_is_another_task(tmp_path):
    write(tmp_path / "first_task.py")
    marker = write(tmp_path / "second_task.py")
    link = tmp_path / "current_task.py"
    link.symlink_to("first_task.py")
    assert main(["train", "current_task.py:make", *TINY, "--out", "run"]) == 0
    link.unlink()
    link.symlink_to("second_task.py")
    assert not trust.allows(f"{link}:make") and not marker.exists()
    assert trust.allows(f"{tmp_path}/first_task.py:make")


def test_nothing_is_imported_to_find_out(tmp_path):
    marker = write(tmp_path / "evil_package" / "__init__.py")
    (tmp_path / "evil_package" / "inner.py").write_text("")
    assert trust.file_of("evil_package.inner:make") == tmp_path / "evil_package" / "inner.py"
    assert not marker.exists()


@pytest.mark.slow
def test_whoever_trains_for_us_is_told(run):
    words = RunFolder.open(run).argv
    assert words[-1] == "--trust"
    shutil.rmtree(os.environ["XDG_STATE_HOME"])
    assert RunFolder.open(run).argv[-1] != "--trust"


@pytest.mark.slow
def test_a_program_of_ours_names_its_task(run, tmp_path):
    out = regista.train(f"{tmp_path}/honest_task.py:make", total_env_steps=16, num_envs=2, eval_every=0, out="other")
    assert (out / "checkpoint.pt").exists()
    evil = run.with_name("stranger") / "evil_task.py"
    folder, marker = forged(run, f"{evil}:make"), write(evil)
    with pytest.raises(trust.TrustError):
        regista.evaluate(folder, episodes=2)
    assert not marker.exists()
    regista.evaluate(folder, episodes=2, trusted=True)
    assert marker.exists()


@pytest.mark.slow
def test_a_home_that_cannot_be_written_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    write(tmp_path / "honest_task.py")
    assert main(["train", "honest_task.py:make", *TINY, "--out", "run"]) == 0
    assert not trust.allows(tasks.canonical("honest_task.py:make"))


@pytest.mark.slow
def test_demonstrations_are_of_football_alone(run, capsys):
    assert main(["demonstrate", "--run", str(run), "--out", "demos"]) == 2
    assert "is a Python task; this command needs a football game" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize("name", ["config.json", "levels.csv", "checkpoint.pt"])
@pytest.mark.parametrize("what", ["pipe", "device"])
def test_what_can_be_read_without_end_is_refused(run, name, what, capsys):
    (run / name).unlink()
    if what == "pipe":
        os.mkfifo(run / name)
    else:
        (run / name).symlink_to("/dev/zero")
    for words in (["evaluate", "--gallery"], ["evaluate"], ["train", "--resume"]):
        assert main([*words, str(run)]) == 1
        assert f"{name} is damaged: it is not a regular file" in capsys.readouterr().err


@pytest.mark.slow
def test_settings_that_are_too_long_are_refused(run, capsys):
    (run / "config.json").write_text("[" * 10_000_001)
    assert main(["evaluate", str(run)]) == 1
    assert "has more than 10_000_000 bytes" in capsys.readouterr().err


def test_a_device_of_an_absurd_number_is_refused(capsys):
    assert main(["train", "--device", "cuda:99999999999999999999"]) == 2
    assert "device must be auto, cpu, cuda or cuda:N" in capsys.readouterr().err


OWN = """
import pathlib
from torch import nn

pathlib.Path({marker!r}).touch()

def score(records, best):
    return best

class Net(nn.Sequential):
    def __init__(self, space, config):
        super().__init__(nn.Flatten(), nn.LazyLinear(4), nn.Tanh())
"""


def own_parts(path: Path) -> Path:
    """Write a score and a network; return the file that tells that they were imported."""
    write(path)  # makes the folder
    path.write_text(OWN.format(marker=str(path.with_suffix(".ran"))))
    return path.with_suffix(".ran")


@pytest.fixture(name="own_run")
def _own_run(tmp_path):
    """Return a run with a score and a network of its user, named by relative paths."""
    write(tmp_path / "honest_task.py")
    marker = own_parts(tmp_path / "parts.py")
    words = ["--method", "plr", "--plr.score", "parts.py:score", "--network", "parts.py:Net", "--out", "runs/own"]
    assert main(["train", "honest_task.py:make", *TINY, *words]) == 0 and marker.exists()
    return tmp_path / "runs" / "own"


@pytest.mark.slow
def test_own_parts_are_stored_and_need_no_word_of_it_again(own_run, tmp_path, monkeypatch):
    config = RunFolder.open(own_run).config
    assert (config.plr.score, config.ppo.network) == (f"{tmp_path}/parts.py:score", f"{tmp_path}/parts.py:Net")
    monkeypatch.chdir("/")
    monkeypatch.setattr(trust, "_named", set())  # another process
    assert main(["train", "--resume", str(own_run), "--total-env-steps", "48"]) == 0
    assert main(["evaluate", str(own_run), "--episodes", "2", "--levels", "0"]) == 0
    assert RunFolder.open(own_run).argv[-1] == trust.FLAG  # for processes of its own
    assert regista.evaluate(own_run, episodes=2).text()


@pytest.mark.parametrize(
    ("body", "code", "sentence"),
    [
        ("best[:3]", 2, r"regista: plr cannot train on .*: the score .* must be a finite number for each of 8 levels"),
        (
            "best if len(best) == 8 else 1 / 0",
            1,
            r"regista: the score .*parts.py:score failed \(.*parts.py:2\): ZeroDivisionError: division by zero",
        ),
        ("best if len(best) == 8 else exit(3)", 1, r"regista: the score .*parts.py:score failed .*: SystemExit: 3"),
        (
            "best if len(best) == 8 else best * float('nan')",
            1,
            r"regista: the score .* must be a finite number for each of \d+ levels, got nan for level 0 \(theta \[",
        ),
    ],
    ids=["before training", "during training", "leaving", "nan"],
)
def test_a_score_that_fails_is_reported_in_one_sentence(body, code, sentence, tmp_path, capsys):
    write(tmp_path / "honest_task.py")
    (tmp_path / "parts.py").write_text(f"def score(records, best):\n    return {body}\n")
    words = ["--method", "plr", "--plr.score", "parts.py:score", "--num-envs", "4", "--out", "runs/own"]
    assert main(["train", "honest_task.py:make", *TINY, *words]) == code
    said = capsys.readouterr().err
    assert re.match(sentence, said) and len(said.splitlines()) == 1
    assert not (tmp_path / "runs" / "own").exists()


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize("part", ["score", "network"])
@pytest.mark.parametrize("command", ["evaluate", "resume", "from", "demonstrate"])
def test_no_command_imports_a_part_that_only_a_folder_names(own_run, part, command, tmp_path, capsys):
    folder = own_run.with_name("stranger")
    shutil.copytree(own_run, folder)
    evil = tmp_path / "downloads" / "evil_parts.py"
    marker = own_parts(evil)
    data = json.loads((folder / "config.json").read_text())
    section, name = {"score": (data["plr"], "score"), "network": (data["ppo"], "network")}[part]
    section[name] = f"{evil}:{'score' if part == 'score' else 'Net'}"
    (folder / "config.json").write_text(json.dumps(data))
    state = checkpoint.load(folder / "checkpoint.pt")
    state["config"] = data
    checkpoint.save(folder / "checkpoint.pt", state)
    code = main([word.format(run=folder) for word in READ[command]])
    said = capsys.readouterr().err
    assert not marker.exists() and "Traceback" not in said
    if (part, command) in (("network", "evaluate"), ("network", "resume"), ("score", "resume")):
        assert code == 1 and f"a file names the function or class {section[name]}, which is Python code" in said
        assert "add --trust to run it" in said


@pytest.mark.slow
def test_a_policy_with_a_network_of_its_user_needs_trust_in_python(own_run, tmp_path, monkeypatch):
    assert regista.load_policy(own_run).act([0.0] * 5) is not None  # named on a command line before
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another user"))
    monkeypatch.setattr(trust, "_named", set())
    with pytest.raises(trust.TrustError, match=r"a file names the function or class .*parts.py:Net"):
        regista.load_policy(own_run)
    assert regista.load_policy(own_run, trusted=True).act([0.0] * 5) is not None


@pytest.mark.slow
def test_moved_code_is_named_again_on_the_command_line(own_run, tmp_path, capsys):
    evaluated = ["evaluate", str(own_run), "--episodes", "2", "--levels", "0"]
    resumed = ["train", "--resume", str(own_run), "--total-env-steps", "48"]
    (tmp_path / "new").mkdir()
    (tmp_path / "parts.py").rename(tmp_path / "new" / "parts.py")
    for words in (evaluated, resumed):
        assert main(words) == 2
        sentence = rf"no file {tmp_path}/parts.py, .*; if it was moved, change its name in {own_run}/config.json"
        assert re.search(sentence, capsys.readouterr().err)
    assert main([*resumed, "--plr.score", "new/parts.py:score"]) == 2  # the network is missing still
    assert main([*resumed, "--plr.score", "new/parts.py:other", "--network", "new/parts.py:Net"]) == 1
    assert main([*resumed, "--plr.score", "new/parts.py:score", "--network", "new/parts.py:Net"]) == 0
    assert main(evaluated) == 0
    (tmp_path / "parts.py").write_text((tmp_path / "new" / "parts.py").read_text())
    capsys.readouterr()
    assert main([*resumed, "--network", "parts.py:Net"]) == 1  # the code of the run is still where it was
    assert "was trained with ppo.network" in capsys.readouterr().err


@pytest.mark.slow
def test_a_policy_finds_moved_code_by_the_settings_of_its_run(own_run, tmp_path):
    (tmp_path / "new").mkdir()
    (tmp_path / "parts.py").rename(tmp_path / "new" / "parts.py")
    with pytest.raises(checkpoint.CheckpointError, match=r"no file .*parts.py"):
        regista.load_policy(own_run, trusted=True)
    settings = (own_run / "config.json").read_text()
    (own_run / "config.json").write_text(settings.replace("/parts.py:Net", "/new/parts.py:Net"))
    assert regista.load_policy(own_run, trusted=True).act([0.0] * 5) is not None


@pytest.mark.slow
def test_another_file_is_no_moved_one(tmp_path):
    assert trust.is_moved(f"{tmp_path}/old/parts.py:make", f"{tmp_path}/new/parts.py:make")
    assert trust.is_moved("no_such_package.parts:make", f"{tmp_path}/parts.py:make")
    assert not trust.is_moved(f"{tmp_path}/old/first.py:make", f"{tmp_path}/old/second.py:make")
    assert not trust.is_moved(f"{tmp_path}/old/parts.py:make", f"{tmp_path}/new/parts.py:other")


def test_a_moved_task_is_named_again(run, tmp_path, capsys):
    (tmp_path / "new").mkdir()
    (tmp_path / "honest_task.py").rename(tmp_path / "new" / "honest_task.py")
    assert main(["evaluate", str(run), "--episodes", "2"]) == 2
    assert re.search(r"honest_task.py; if it was moved, change its name in .*config.json", capsys.readouterr().err)
    assert main(["train", "new/honest_task.py:make", "--resume", str(run), "--total-env-steps", "48"]) == 0
    assert main(["evaluate", str(run), "--episodes", "2", "--levels", "0"]) == 0


@pytest.mark.slow
def test_a_module_that_is_not_found_is_reported_as_such(own_run, capsys):
    text = (own_run / "config.json").read_text()
    (own_run / "config.json").write_text(re.sub(r'"[^"]*parts.py:score"', '"gone_parts:score"', text))
    assert main(["train", "--resume", str(own_run), "--total-env-steps", "48"]) == 1
    assert "cannot import module gone_parts for the function or class gone_parts:score" in capsys.readouterr().err


@pytest.mark.slow
def test_a_changed_network_is_reported_alike_by_every_command(own_run, tmp_path, capsys):
    parts = tmp_path / "parts.py"
    parts.write_text(parts.read_text().replace("LazyLinear(4)", "LazyLinear(5)"))
    sys.modules.pop("parts", None)  # another process
    for words in (["train", "--resume", str(own_run), "--total-env-steps", "48"], ["evaluate", str(own_run)]):
        assert main(words) == 1
        said = capsys.readouterr().err
        assert re.search(r"parts.py:Net or the observations, .* have changed since training; restore them", said)
        assert "size mismatch" in said and len(said.splitlines()) == 1 and "can be evaluated" not in said
    with pytest.raises(checkpoint.CheckpointError, match=r"or .*parts.py:Net has changed since training"):
        regista.load_policy(own_run, trusted=True)


EDITED = """
import gymnasium
import ued

def put(env, values):
    env.unwrapped.gravity = values["gravity"]

def make(num_envs):
    return ued.GymUPOMDP(lambda: gymnasium.make("CartPole-v1"), put, {"gravity": (LOW, 20.0)}, num_envs)
"""


@pytest.mark.long
def test_an_edited_task_is_warned_of(tmp_path, capsys):
    """Levels are rows of θ, so that other ranges give other levels: without a message, tables would join two tasks."""
    task = tmp_path / "edited.py"
    sizes = ["--total-env-steps", "64", "--num-envs", "4", "--num-steps", "16", "--eval-every", "0", "--no-record"]
    compare = ["compare", f"{task}:make", "--methods", "dr", *sizes, "--episodes", "4", "--levels", "0"]
    task.write_text(EDITED.replace("LOW", "5.0"))
    assert main([*compare, "--out", str(tmp_path / "runs"), "--seeds", "1"]) == 0
    assert "changed" not in capsys.readouterr().err
    task.write_text(EDITED.replace("LOW", "9.0"))
    assert main([*compare, "--out", str(tmp_path / "runs"), "--seeds", "2"]) == 0
    told = capsys.readouterr().err
    assert re.search(r"edited.py:make changed between these runs: compare \S*dr-0/task.py with \S*dr-1/task.py", told)
    more = ["--total-env-steps", "128"]
    assert main(["train", f"{task}:make", "--resume", str(tmp_path / "runs" / "dr-0"), *more]) == 0
    assert "dr-0 was started, see" in capsys.readouterr().err
