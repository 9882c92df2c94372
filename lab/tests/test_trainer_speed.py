"""`python -m lab.trainer_speed`: trainers learn the same amount per rollout; whole rounds are measured."""

import csv

import pytest

from lab import trainer_speed, trainers


def test_the_meter_counts_whole_rounds_after_those_that_warm_up(monkeypatch):
    clock = iter([5.0, 10.0, 12.0, 14.0])
    monkeypatch.setattr(trainers.time, "process_time", lambda: next(clock))
    meter = trainers.Meter(batch=8, warm=1, seconds=3.0)
    with pytest.raises(trainers.Enough):
        while True:
            meter.step(4)
            meter.note(0.5, weights=7)
    assert meter.speed == 2 * 8 / 4.0  # two rounds from 10 s to 14 s
    assert (meter.gradient_steps, meter.weights, meter.steps) == (1.0, 7, 3 * 8)


def test_missing_packages_are_reported(monkeypatch, capsys):
    monkeypatch.setitem(trainers.PACKAGES, "pufferlib", ("no_such_package",))
    trainer_speed.main(["--trainers", "pufferlib", "--rounds", "1"])
    assert "| pufferlib | no_such_package not installed |" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.long
def test_trainers_take_the_same_gradient_steps_with_as_many_weights(tmp_path, capsys):
    compared = [name for name in trainers.TRAINERS if not trainers.missing(name)]
    rows = tmp_path / "rows.csv"
    quick = ["--shapes", "16x8", "--rounds", "1", "--seconds", "0.01", "--warm", "2"]
    trainer_speed.main(["--trainers", *compared, *quick, "--csv", str(rows)])
    with rows.open() as file:
        found = list(csv.DictReader(file))
    assert {row["trainer"] for row in found} == set(compared) >= {"regista"}
    for torso, weights in (("shared", 9044), ("separate", 16788)):
        assert {row["weights"] for row in found if row["torso"] == torso} == {str(weights)}
    assert {row["gradient_steps"] for row in found} == {"24.0"}  # 3 epochs of 8 minibatches
    assert all(int(row["steps_per_second"]) > 0 for row in found)
    assert capsys.readouterr().out.count("| regista |") == 2
