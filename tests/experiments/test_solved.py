"""`list --solved`: which shares of random levels are never, sometimes and always solved."""

import numpy as np
import pytest

from regista.experiments.__main__ import main
from regista.experiments.run.solved import solved_shares
from regista.experiments.run.table import read_rows
from tests.experiments.probe import ProbeUPOMDP


def test_levels_are_counted_by_how_often_they_are_solved(monkeypatch):
    from types import SimpleNamespace

    import ued.evaluation

    success = np.array([[1, 0, 1, 0], [1, 0, 0, 0]], float)  # two episodes of four levels
    monkeypatch.setattr(ued.evaluation, "evaluate", lambda *_: SimpleNamespace(success=success.ravel()))
    assert solved_shares(None, None, np.zeros(4), 2) == pytest.approx((3 / 8, 0.5, 0.25, 0.25))


def test_a_table_of_a_random_policy_and_of_a_student(probe, tmp_path, capsys):
    flags = ["--total-env-steps", "4000", "--tests", "2", "--levels", "8", "--episodes", "2"]
    assert main(["list", "--solved", "1v1Free", "--csv", str(tmp_path / "rows.csv"), *flags]) == 0
    rows = read_rows(tmp_path / "rows.csv")
    assert [row["who"] for row in rows] == ["random policy", "dr", "dr"]
    assert [int(row["env_steps"]) for row in rows] == [0, 2000, 4000]
    assert all(float(row["never"]) + float(row["sometimes"]) + float(row["always"]) == 1 for row in rows)
    assert rows[0]["dim"] == str(ProbeUPOMDP(1).theta_dim)
    assert "levels never" in capsys.readouterr().out
    assert main(["list", "--solved"]) == 2
    assert main(["characterise"]) == 2 and "regista list --solved GAME" in capsys.readouterr().err
