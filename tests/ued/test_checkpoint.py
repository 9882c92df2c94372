"""Checkpoints: what they hold comes back, what is wrong with a file is said, and resumed runs give the same numbers."""

import copy
import errno
import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch
from probes import Follow, Landscape

from ued.config import PairedConfig, PPOConfig
from ued.core import checkpoint
from ued.core.checkpoint import CheckpointError
from ued.core.level_space import level_dtype
from ued.methods.dr import DR
from ued.methods.paired import Paired

PPO = PPOConfig(num_steps=10, num_minibatches=2, hidden_size=8)
NESTED = np.dtype([("ball", [("position", np.float64, (2,)), ("owner", np.int8)]), ("clock", np.uint64)], align=True)


def same(left, right):
    assert type(left) is type(right)
    if isinstance(left, dict):
        assert left.keys() == right.keys()
        return all(same(left[key], right[key]) for key in left)
    if isinstance(left, (list, tuple)):
        return len(left) == len(right) and all(map(same, left, right))
    if isinstance(left, np.ndarray):
        return left.dtype == right.dtype and left.shape == right.shape and left.tobytes() == right.tobytes()
    if isinstance(left, torch.Tensor):
        return left.dtype == right.dtype and torch.equal(left, right)
    return left == right or left != left


def test_everything_comes_back(tmp_path):
    records = np.zeros((2, 3), NESTED)
    records["ball"]["position"] = np.random.default_rng(0).normal(size=(2, 3, 2))
    levels = np.zeros(4, level_dtype(3))
    levels["seed"] = 2**64 - 1
    state = {
        "records": records,
        "levels": levels,
        "empty": levels[:0],
        "no columns": np.zeros(2, level_dtype(0)),
        "strings": np.array(["a", "bcd"]),
        "truth": np.array(True),
        "fortran": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "generator": np.random.default_rng(3).bit_generator.state,
        "mt": np.random.Generator(np.random.MT19937(1)).bit_generator.state,
        "torch": torch.Generator().get_state(),
        "weights": {0: torch.ones(2, 2, dtype=torch.float64)},
        "plain": [1, 2.5, True, None, "text", (1, (2, "three")), float("nan"), -(2**80)],
    }
    checkpoint.save(tmp_path / "c.pt", state)
    assert same(checkpoint.load(tmp_path / "c.pt"), state)
    assert os.listdir(tmp_path) == ["c.pt"]


def test_one_entry_is_read_without_the_arrays_of_the_others(tmp_path, monkeypatch):
    path = tmp_path / "checkpoint.pt"
    checkpoint.save(path, {"update": 3, "large": np.arange(1000), "kept": np.arange(5)})
    decoded = []
    decode = checkpoint._decode_array
    monkeypatch.setattr(checkpoint, "_decode_array", lambda value: decoded.append(value["shape"]) or decode(value))
    assert checkpoint.load_entry(path, "update") == 3 and decoded == []
    assert checkpoint.load_entry(path, "kept").tolist() == [0, 1, 2, 3, 4] and decoded == [[5]]
    with pytest.raises(CheckpointError, match="there is no checkpoint at"):
        checkpoint.load_entry(tmp_path / "other.pt", "update")


def test_numpy_numbers_become_plain_ones(tmp_path):
    checkpoint.save(tmp_path / "c.pt", {"a": np.float64(0.1), "b": np.uint64(2**64 - 1), "c": np.bool_(True)})
    assert checkpoint.load(tmp_path / "c.pt") == {"a": 0.1, "b": 2**64 - 1, "c": True}


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"a": [0, {"b": Path("x")}]}, r"state\['a'\]\[1\]\['b'\] is a PosixPath, which a checkpoint cannot hold"),
        ({"a": np.array([None])}, r"state\['a'\] is an array of Python objects, which a checkpoint cannot hold"),
        ({"a": {"__array__": 1}}, "has the key '__array__'; keys must be strings or integers, and not reserved"),
    ],
)
def test_what_it_cannot_hold_is_refused_and_the_old_one_stays(tmp_path, state, message):
    path = tmp_path / "c.pt"
    checkpoint.save(path, {"kept": 1})
    with pytest.raises(CheckpointError, match=message):
        checkpoint.save(path, state)
    assert checkpoint.load(path) == {"kept": 1}


def test_a_full_disk_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "c.pt"
    checkpoint.save(path, {"kept": 1})

    def full(handle):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(CheckpointError) as error:
            checkpoint.save(path, {"kept": 2})
    assert str(error.value) == f"cannot write {path}: No space left on device (the previous checkpoint is kept)"
    assert checkpoint.load(path) == {"kept": 1} and os.listdir(tmp_path) == ["c.pt"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_disk_that_is_full_from_the_first_byte_on(tmp_path, monkeypatch):
    path = tmp_path / "c.pt"
    real = open
    monkeypatch.setattr("builtins.open", lambda name, mode: real("/dev/full", mode))
    with pytest.raises(CheckpointError) as error:
        checkpoint.save(path, {"weights": torch.zeros(100_000)})
    monkeypatch.undo()
    assert str(error.value) == f"cannot write {path}: No space left on device"
    assert os.listdir(tmp_path) == []


def test_a_folder_that_is_a_file(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(CheckpointError, match=r"cannot write .*/file/c.pt: Not a directory$"):
        checkpoint.save(tmp_path / "file" / "c.pt", {})


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(CheckpointError, match=r"cannot write .*: No such file or directory"):
        checkpoint.save(tmp_path / "none" / "c.pt", {})


@pytest.mark.parametrize("keep", [0, 1, 100, 0.5, -1])
def test_a_file_cut_short(tmp_path, keep):
    path = tmp_path / "c.pt"
    checkpoint.save(path, {"weights": torch.arange(1000.0)})
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * keep) if isinstance(keep, float) else keep])
    with pytest.raises(CheckpointError) as error:
        checkpoint.load(path)
    assert str(error.value) == f"{path} is not a checkpoint, or it is truncated or damaged"


def test_files_of_others(tmp_path):
    path = tmp_path / "c.pt"
    with pytest.raises(CheckpointError, match="there is no checkpoint at"):
        checkpoint.load(path)
    with pytest.raises(CheckpointError, match=r"cannot read .*: Is a directory"):
        checkpoint.load(tmp_path)
    for foreign in ("some text\n", "{}", "\x00\x01"):
        path.write_text(foreign)
        with pytest.raises(CheckpointError, match="is not a checkpoint, or it is truncated or damaged"):
            checkpoint.load(path)
    torch.save({"model": torch.ones(2)}, path)
    with pytest.raises(CheckpointError, match="is not a checkpoint of this program"):
        checkpoint.load(path)
    torch.save({"format": checkpoint.FORMAT, "version": 99, "state": {}}, path)
    with pytest.raises(CheckpointError, match="has version 99 of the checkpoint format; this program reads 3"):
        checkpoint.load(path)


class Bomb:
    def __reduce__(self):
        return os.system, ("touch bombed",)


@pytest.mark.parametrize("write", [torch.save, lambda bomb, path: path.write_bytes(pickle.dumps(bomb))])
def test_a_file_from_a_stranger_runs_no_code(tmp_path, monkeypatch, write):
    monkeypatch.chdir(tmp_path)
    write({"format": checkpoint.FORMAT, "version": checkpoint.VERSION, "state": Bomb()}, tmp_path / "c.pt")
    with pytest.raises(CheckpointError):
        checkpoint.load(tmp_path / "c.pt")
    assert os.listdir(tmp_path) == ["c.pt"]


# ---------------------------------------------------------------- runs

MAKE = {
    "dr": lambda seed: DR(Follow(12), PPO, seed=seed),
    "paired": lambda seed: Paired(Landscape(12), PPO, PairedConfig(dr_fraction=0.3), seed=seed),
}


def numbers(metrics):
    return {name: number for name, number in metrics.items() if not name.startswith("time/")}


def equal(left, right):
    return left.keys() == right.keys() and all(left[k] == right[k] or left[k] != left[k] for k in left)


@pytest.mark.slow
@pytest.mark.parametrize("name", MAKE)
def test_a_resumed_run_gives_the_same_numbers(tmp_path, name):
    whole = MAKE[name](1)
    for _ in range(3):
        whole.update()
    checkpoint.save(tmp_path / "c.pt", whole.state_dict())
    resumed = MAKE[name](99)  # whatever it drew before is overwritten
    resumed.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    for _ in range(4):
        assert equal(numbers(whole.update()), numbers(resumed.update()))
        assert all(map(np.array_equal, whole.last.returns.values(), resumed.last.returns.values()))
        assert np.array_equal(whole.last.theta, resumed.last.theta)
    assert same(checkpoint.encode(whole.state_dict()), checkpoint.encode(resumed.state_dict()))


@pytest.mark.slow
@pytest.mark.parametrize("name", MAKE)
def test_a_state_is_a_snapshot(name):
    method = MAKE[name](1)
    method.update()
    state = method.state_dict()
    before = copy.deepcopy(state)
    method.update()
    other = MAKE[name](2)
    other.load_state_dict(state)
    other.update()
    assert same(state, before)


@pytest.mark.slow
def test_a_run_goes_on_from_its_state_after_an_update_that_broke_off(monkeypatch):
    method, untouched = MAKE["paired"](1), MAKE["paired"](2)
    method.update()
    state = method.state_dict()
    untouched.load_state_dict(state)
    step, steps = Landscape.outcome, iter(range(7))

    def broken(self, actions):
        if next(steps, None) is None:
            raise RuntimeError("broken")
        return step(self, actions)

    with monkeypatch.context() as patch, pytest.raises(RuntimeError, match="broken"):
        patch.setattr(Landscape, "outcome", broken)
        method.update()
    method.load_state_dict(state)
    for _ in range(2):
        assert equal(numbers(method.update()), numbers(untouched.update()))
    assert same(checkpoint.encode(method.state_dict()), checkpoint.encode(untouched.state_dict()))


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("queue", "next_id"), None, "next_id is a NoneType and must be an integer"),
        (("queue", "taken"), None, r"taken is a NoneType and must be an array of int64"),
        (("queue", "next_visit"), 10**30, "next_visit is a number of more than 64 bits and must be an integer"),
        (("queue", "next_visit"), 0.5, "next_visit is a number and must be an integer"),
        (("queue", "next_visit"), True, "next_visit is a bool and must be an integer"),
        (("queue", "playing"), np.full((2, 12), 99), r"playing must have shape \[2, 12\] and values from -1 to \d"),
        (("queue", "taken"), np.array([0, -1]), r"taken must have shape \[2\] and values from 0 to \d"),
        (("queue", "taken"), np.zeros(3, np.int64), r"taken must have shape \[2\] and values from 0 to \d"),
        (("updates",), [], "updates is a list and must be an integer"),
    ],
)
def test_what_is_of_another_kind_is_refused(place, value, message):
    method = MAKE["paired"](1)
    state = holder = method.state_dict()
    for name in place[:-1]:
        holder = holder[name]
    holder[place[-1]] = value
    with pytest.raises(ValueError, match=message):
        method.load_state_dict(state)


def go_on(folder, updates):
    """Train from the checkpoint in a folder, if there is one, to so many updates; save after each."""
    torch.set_num_threads(1)
    method = MAKE["paired"](1)
    if (folder / "c.pt").exists():
        method.load_state_dict(checkpoint.load(folder / "c.pt"))
    while method.updates < updates:
        metrics = method.update()
        with open(folder / "log", "a") as log:
            print(method.updates, numbers(metrics), file=log)
        checkpoint.save(folder / "c.pt", method.state_dict())


@pytest.mark.slow
def test_a_killed_run_resumes_to_the_numbers_of_one_never_killed(tmp_path):
    def start(folder):
        code = f"from pathlib import Path; from test_checkpoint import go_on; go_on(Path({str(folder)!r}), 10**9)"
        here = Path(__file__).parent
        environment = os.environ | {"PYTHONPATH": f"{here.parents[1]}:{here}"}
        return subprocess.Popen([sys.executable, "-c", code], env=environment)

    (tmp_path / "whole").mkdir(), (tmp_path / "killed").mkdir()
    go_on(tmp_path / "whole", 12)
    for updates in (3, 7):
        run, log = start(tmp_path / "killed"), tmp_path / "killed" / "log"
        while not log.exists() or len(log.read_text().splitlines()) < updates:
            assert run.poll() is None
            time.sleep(0.01)
        run.send_signal(signal.SIGKILL)
        run.wait()
    whole = (tmp_path / "whole" / "log").read_text().splitlines()
    go_on(tmp_path / "killed", 12)
    killed = (tmp_path / "killed" / "log").read_text().splitlines()
    assert set(whole) <= set(killed)  # an update that was not saved is done again, with the same numbers
    assert len({line.split()[0] for line in killed}) == len(set(killed))
