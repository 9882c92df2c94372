"""Files of older runs are read under the present names."""

import numpy as np
import pytest
from numpy.lib.recfunctions import rename_fields
from probes import Landscape

from ued import DR, PPOConfig, read_level
from ued.core import checkpoint
from ued.core.renamed import RENAMED, present_fields, present_names

OLD = {new: old for old, new in RENAMED.items()}
PPO = PPOConfig(num_steps=16, num_minibatches=1, update_epochs=1, hidden_size=8)


def as_it_was(value):
    """Return a state with the old names of its keys and fields."""
    if isinstance(value, dict):
        return {OLD.get(key, key): as_it_was(item) for key, item in value.items()}
    if isinstance(value, list):
        return [as_it_was(item) for item in value]
    if isinstance(value, np.ndarray) and value.dtype.names:
        return rename_fields(value, OLD)
    return value


def test_a_checkpoint_with_old_names_resumes_to_the_same_numbers(tmp_path):
    one, other = (DR(Landscape(4), PPO, seed=3) for _ in range(2))
    for _ in range(3):
        one.update()
    old = as_it_was(one.state_dict())
    assert "turn" in old["queue"]["records"].dtype.names and old["queue"]["next_turn"] > 0
    with pytest.raises(ValueError, match="these level, origin, id, turn, parent"):
        other.load_state_dict(old)
    checkpoint.save(tmp_path / "c.pt", old)
    other.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    metrics = [{name: x for name, x in each.update().items() if not name.startswith("time/")} for each in (one, other)]
    np.testing.assert_equal(metrics[0], metrics[1])
    assert (one.last.records["visit"] == other.last.records["visit"]).all()


def test_a_table_with_the_old_column_has_its_levels(tmp_path):
    (tmp_path / "levels.csv").write_text("update,id,turn,seed,theta/x\n1,5,8,77,0.25\n2,5,9,77,0.25\n")
    level = read_level(tmp_path, 5, 9)
    assert level["seed"].tolist() == [77] and level["theta"].tolist() == [[0.25]]
    with pytest.raises(KeyError, match="no level 5 at visit 10"):
        read_level(tmp_path, 5, 10)


def test_names_that_are_no_old_ones_stay():
    assert present_names(["id", "turn", "seed"]) == ["id", "visit", "seed"]
    records = np.zeros(2, [("id", int), ("visit", int)])
    assert present_fields(records) is records
