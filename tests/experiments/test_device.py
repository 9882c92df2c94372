"""Where networks are. No GPU is needed here, and what one computes is not tested: only what is said without one."""

import json

import pytest
import torch

from regista.experiments.__main__ import main
from regista.experiments.run import build, config
from regista.experiments.run.config import TrainConfig
from regista.experiments.run.errors import UsageError
from regista.experiments.run.folder import RunFolder


@pytest.fixture
def gpus(monkeypatch):
    """Let torch see so many GPUs."""

    def see(count):
        monkeypatch.setattr(torch.cuda, "is_available", lambda: count > 0)
        monkeypatch.setattr(torch.cuda, "device_count", lambda: count)

    return see


def test_auto_is_a_gpu_if_there_is_one(gpus):
    gpus(0)
    assert build.find_device("auto") == build.find_device("cpu") == torch.device("cpu")
    gpus(2)
    assert build.find_device("auto") == torch.device("cuda") and build.find_device("cpu") == torch.device("cpu")
    assert build.find_device("cuda:1") == torch.device("cuda", 1)


@pytest.mark.parametrize(
    ("count", "name", "seen"), [(0, "cuda", "no GPU"), (1, "cuda:1", "one GPU, cuda:0"), (2, "cuda:2", "2 GPUs")]
)
def test_a_device_that_is_not_there_is_refused(gpus, count, name, seen):
    gpus(count)
    with pytest.raises(UsageError, match=f"there is no device {name}: torch finds {seen}; use --device cpu"):
        build.find_device(name)


@pytest.mark.parametrize("command", ["train", "compare"])
def test_without_a_gpu_nothing_begins(gpus, command, tmp_path, capsys):
    gpus(0)
    out = tmp_path / "run"
    assert main([command, "1v1Free", "--device", "cuda", "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("regista: there is no device cuda") and said.count("\n") == 1 and not out.exists()
    assert main([command, "1v1Free", "--device", "gpu", "--out", str(out)]) == 2
    assert "device must be auto, cpu, cuda or cuda:N, got 'gpu'" in capsys.readouterr().err


def test_a_run_may_change_its_device_and_older_runs_have_the_host(tmp_path):
    run = RunFolder.create(tmp_path / "run", TrainConfig(device="cuda:3"))
    (run.path / "metrics.csv").touch()  # it has begun
    run.extend(TrainConfig(device="cpu"))
    with run.locked():
        run.save_config()
    assert RunFolder.open(run.path).config.device == "cpu"
    kept = json.loads((run.path / "config.json").read_text())
    del kept["device"]
    (run.path / "config.json").write_text(json.dumps(kept))
    assert config.load(None, run.path / "config.json").device == "cpu"
