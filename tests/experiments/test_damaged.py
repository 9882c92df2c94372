"""Damaged run folders: one sentence and exit code 1, nothing overwritten."""

import json
import shutil
from pathlib import Path

import pytest
import torch

from regista.experiments.run.errors import CommandError
from regista.experiments.run.folder import RunFolder
from regista.experiments.run.launch.owner import owned
from regista.experiments.run.table import Table
from tests.attacks.files import REFUSED, Target, attack, contents, make_run, quietly
from ued.adapters.policy import load_policy
from ued.core import checkpoint
from ued.core.checkpoint import CheckpointError

pytestmark = pytest.mark.slow

DAMAGES = {
    "config.json": (b"", b"[" * 100_000, b"\xff\xfe", b'{"seed": NaN}', b"null", b'{"minigame": 3}'),
    "metrics.csv": (b"\xff\xfe\n\xff\n", b"update,env_steps\nx,y\n", b"update,env_steps\n1\n", b'update,"env\n1,2\n'),
    "checkpoint.pt": (b"", b"PK", b"PK\x05\x06" + b"\0" * 18, b"x" * 5_000),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("damaged")
    make_run(path)
    return path


@pytest.mark.sample(1)
@pytest.mark.parametrize(("name", "number"), [(name, k) for name, each in DAMAGES.items() for k in range(len(each))])
def test_a_file_that_is_something_else(folder, tmp_path, name, number):
    copy = tmp_path / "run"
    copy.mkdir()
    for each, content in contents(folder / "run").items():
        (copy / each).write_bytes(content)
    (copy / name).write_bytes(DAMAGES[name][number])
    before = contents(copy)
    code, said = quietly(["train", "--resume", str(copy)])
    assert code == 1 and said.startswith("regista: ") and said.count("\n") == 1 and str(copy) in said
    assert contents(copy) == before


def test_weights_that_are_no_numbers(folder, tmp_path):
    copy = tmp_path / "run"
    copy.mkdir()
    for each, content in contents(folder / "run").items():
        (copy / each).write_bytes(content)
    state = torch.load(copy / "checkpoint.pt", weights_only=True)
    weights = state["state"]["method"]["learners"][0]["ppo"]["student"]
    next(iter(weights.values())).view(-1)[0] = float("nan")
    torch.save(state, copy / "checkpoint.pt")
    for words in (["train", "--resume", str(copy)], ["evaluate", str(copy), "--episodes", "2"]):
        code, said = quietly(words)
        assert code == 1 and "is not finite" in said.splitlines()[-1]


def test_files_of_another_version(folder, tmp_path):
    state = torch.load(folder / "run" / "checkpoint.pt", weights_only=True)
    (tmp_path / "config.json").write_bytes((folder / "run" / "config.json").read_bytes())
    torch.save(state | {"version": 2}, tmp_path / "checkpoint.pt")
    code, said = quietly(["train", "--resume", str(tmp_path)])
    assert code == 1 and "has version 2 of the checkpoint format; this program reads 3" in said
    settings = json.loads((tmp_path / "config.json").read_text())
    (tmp_path / "config.json").write_text(json.dumps(settings | {"color": "blue"}))
    assert "unknown key 'color'" in quietly(["train", "--resume", str(tmp_path)])[1]


def test_a_table_whose_last_row_was_cut_off_goes_on(tmp_path):
    (tmp_path / "t.csv").write_text("update,score\n1,0.5\n2,0.")
    table = Table(tmp_path / "t.csv")
    table.replace(table.until(7))
    table.append([{"update": 2, "score": 0.25}])
    assert (tmp_path / "t.csv").read_text() == "update,score\n1,0.5\n2,0.25\n"


def altered(path: Path, *keys: object, value: object) -> None:
    """Write a checkpoint of which one entry is another one."""
    state = inside = checkpoint.load(path)
    for key in keys[:-1]:
        inside = inside[key]  # type: ignore[index]
    inside[keys[-1]] = value  # type: ignore[index]
    checkpoint.save(path, state)


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Train a toy task, beginning with a student."""
    return make_run(tmp_path_factory.mktemp("begun"), 200, "begun")


@pytest.mark.long
def test_a_student_that_is_none_is_refused_by_whoever_loads_it(begun, tmp_path):
    for keys, value in (
        (("spaces", "action", "kind"), "Nothing"),
        (("spaces", "agents"), "x"),
        (("config", "ppo", "memory"), "lstm"),
        (("method", "learners", 0, "ppo", "student"), {}),
    ):
        shutil.copy(begun / "checkpoint.pt", tmp_path)
        altered(tmp_path / "checkpoint.pt", *keys, value=value)
        with pytest.raises(CheckpointError, match="is damaged: its student or its spaces are invalid"):
            load_policy(tmp_path)


@pytest.mark.parametrize(
    ("name", "value"), [("kl_coef", "x"), ("kl_coef", float("nan")), ("student", {}), ("source", 3)]
)
def test_what_a_run_began_with_is_refused_if_damaged(begun, tmp_path, name, value):
    copy = shutil.copytree(begun, tmp_path / "run")
    altered(copy / "origin.pt", name, value=value)
    code, said = quietly(["train", "--resume", str(copy)])
    assert code == (0 if name == "source" else 1) and "Traceback" not in said
    assert code == 0 or (said.startswith("regista: ") and said.count("\n") == 1)


def with_text(run, folder, name, old, new):
    """Return a copy of a run, of which one file says something else."""
    copy = shutil.copytree(run, folder / "run")
    text = (copy / name).read_text()
    assert old in text
    (copy / name).write_text(text.replace(old, new))
    return copy


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        *(("checkpoint.pt", lambda whole: b"PK"), ("metrics.csv", lambda whole: whole.replace(b",128,", b",x,"))),
        ("levels.csv", lambda whole: whole.partition(b",theta")[0]),  # in the middle of its columns
    ],
)
def test_a_budget_is_not_kept_by_a_run_that_cannot_go_on(begun, tmp_path, name, damage):
    copy = shutil.copytree(begun, tmp_path / "run")
    (copy / name).write_bytes(damage((copy / name).read_bytes()))
    (copy / "task.py").unlink()  # nor is the program written anew
    before = contents(copy)
    assert quietly(["train", "--resume", str(copy), "--total-env-steps", "500"])[0] == 1
    assert contents(copy) == before


@pytest.mark.parametrize(
    "damage", [("success/student", "x"), ("source,", "sauce,"), ("theta/length1", "theta/length0")]
)
def test_a_gallery_of_damaged_levels_is_refused(begun, tmp_path, damage):
    copy = with_text(begun, tmp_path, "levels.csv", *damage)
    code, said = quietly(["evaluate", "--gallery", str(copy)])
    assert code == 1 and said.startswith("regista: ") and said.count("\n") == 1 and str(copy) in said


@pytest.mark.parametrize("damage", [("env_steps", "steps"), (",128,", ",,"), (",128,", ",inf,")])
def test_a_table_that_does_not_say_how_far_a_run_is(begun, tmp_path, damage):
    copy = with_text(begun, tmp_path, "metrics.csv", *damage)
    code, said = quietly(["train", "--resume", str(copy)])
    assert code in (0, 1) and code == (said.count("regista: ") > 0)
    if damage[0] == "env_steps":
        assert f"{copy / 'metrics.csv'} is damaged: 'env_steps' is missing" in said
    else:
        (copy / "metrics.csv").write_text(f"update,env_steps\n1,{damage[1].strip(',')}\n")
        with pytest.raises(CommandError, match="is damaged: its last env_steps is"):
            RunFolder.open(copy).env_steps()


def test_an_owner_that_is_none_keeps_nobody_out(tmp_path):
    (tmp_path / "owner.json").write_text("[" * 100_000)
    with owned(tmp_path):
        pass


@pytest.mark.parametrize("text", ["", "nan", "-1", "1e300"])
def test_a_table_that_does_not_say_how_long_was_trained(begun, tmp_path, text):
    """A study asks, and one whose table has no row yet was trained for 0 s."""
    run = RunFolder.open(with_text(begun, tmp_path, "metrics.csv", "", ""))
    run.metrics.path.write_text(f"update,time/elapsed\n1,{text}\n")
    with pytest.raises(CommandError, match="is damaged: its last time/elapsed is"):
        run.seconds()
    run.metrics.path.write_text("update,time/elapsed\n")
    assert run.seconds() == 0.0


@pytest.mark.long
def test_run_folders_with_something_damaged(folder):
    assert attack(40, 0, folder)[REFUSED] > 10
    assert Target(folder).run.exists()
