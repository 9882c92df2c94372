"""Damaged run folders: one sentence and exit code 1, nothing overwritten."""

import json
from pathlib import Path

import pytest
import torch

from experiments.run.table import Table
from tests.torture.files import REFUSED, Target, attack, contents, make_run, quietly

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
    (tmp_path / "config.json").write_text(json.dumps(settings | {"colour": "blue"}))
    assert "unknown key 'colour'" in quietly(["train", "--resume", str(tmp_path)])[1]


def test_a_table_whose_last_row_was_cut_off_goes_on(tmp_path):
    (tmp_path / "t.csv").write_text("update,score\n1,0.5\n2,0.")
    table = Table(tmp_path / "t.csv")
    table.keep_until(7)
    table.append([{"update": 2, "score": 0.25}])
    assert (tmp_path / "t.csv").read_text() == "update,score\n1,0.5\n2,0.25\n"


@pytest.mark.slow
def test_run_folders_with_something_damaged(folder):
    assert attack(40, 0, folder)[REFUSED] > 10
    assert Target(folder).run.exists()
