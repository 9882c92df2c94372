"""The buffer of levels: priorities by hand, what enters and what leaves, ids that outlive their levels."""

import numpy as np
import pytest

from ued.config import BufferConfig
from ued.core.curriculum import ThetaSpace
from ued.core.level_space import level_dtype
from ued.levels.buffer import LevelBuffer
from ued.levels.record import NONE, Origin, level_record_dtype, make_records
from ued.levels.scores import fields


def levels(*values):
    made = np.zeros(len(values), level_dtype(1))
    made["theta"][:, 0] = values
    return made


def buffer(**settings):
    return LevelBuffer(ThetaSpace(1), BufferConfig(**{"capacity": 4, **settings}))


def insert(to, values, scores, parent=NONE):
    records = make_records(level_record_dtype(level_dtype(1)), levels(*values))
    records["score"], records["parent"] = scores, parent
    return to.insert(records, np.array(scores))


def test_rank_weights_by_hand():
    made = buffer(temperature=0.5, staleness_coef=0.0)
    insert(made, [0.1, 0.2, 0.3], [1.0, 5.0, 3.0])
    weights = np.array([1 / 9, 1, 1 / 4])  # ranks 3, 1, 2 to the power of -2
    assert made.weights() == pytest.approx(weights / weights.sum())


def test_power_weights_by_hand_and_negative_scores_weigh_nothing():
    made = buffer(priority="power", temperature=0.5, staleness_coef=0.0)
    insert(made, [0.1, 0.2, 0.3], [1.0, 2.0, -3.0])
    assert made.weights() == pytest.approx([0.2, 0.8, 0.0], abs=1e-6)
    cold = buffer(priority="power", temperature=0.001, staleness_coef=0.0)
    insert(cold, [0.1, 0.2], [100.0, 200.0])
    assert cold.weights() == pytest.approx([0.0, 1.0])


def test_what_was_not_played_for_long_comes_back():
    made = buffer(temperature=0.01, staleness_coef=1.0)
    insert(made, [0.1, 0.2], [1.0, 2.0])
    rng = np.random.default_rng(0)
    made.slots["last_played"][:] = made.now
    made.slots["last_played"][0] = made.now - 10
    assert made.sample(1, rng).tolist() == [0]
    assert made.slots["last_played"][0] == made.now and made.slots["num_replays"].tolist() == [1, 0]


def test_levels_are_drawn_as_their_weights_say():
    made = buffer(temperature=1.0, staleness_coef=0.0)
    insert(made, [0.1, 0.2, 0.3], [1.0, 5.0, 3.0])
    rows = made.sample(30_000, np.random.default_rng(1))
    assert np.bincount(rows) / 30_000 == pytest.approx(made.weights(), abs=0.01)


def test_a_full_buffer_gives_up_what_it_would_replay_least():
    made = buffer(staleness_coef=0.0)
    assert insert(made, [0.1, 0.2, 0.3, 0.4], [1.0, 2.0, 3.0, 4.0]) == 4
    assert insert(made, [0.5, 0.6], [0.5, 2.5]) == 1  # 2.5 takes the place of 1; 0.5 is too weak for 2
    assert sorted(made.slots["score"]) == [2.0, 2.5, 3.0, 4.0]
    assert len(made) == 4 and made.fill_ratio == 1.0
    assert insert(made, [0.7], [2.0]) == 1  # an equal one is let in


def test_a_level_is_kept_once_with_its_better_score():
    made = buffer()
    insert(made, [0.1, 0.1], [1.0, 2.0])
    assert len(made) == 1
    assert insert(made, [0.1], [7.0]) == 0
    assert made.slots["score"].tolist() == [7.0] and made.slots["best"].tolist() == [7.0]
    assert insert(buffer(no_duplicates=False), [0.1, 0.1], [1.0, 2.0]) == 2


def test_the_best_return_of_all_time_is_remembered():
    made = buffer()
    insert(made, [0.1], [2.0])
    made.update_scores(np.array([0]), np.array([-1.0]), np.array([0.5]))
    assert made.slots["score"].tolist() == [-1.0] and made.slots["best"].tolist() == [2.0]


def test_a_success_of_all_time_is_remembered():
    made, dtype = buffer(), level_record_dtype(level_dtype(1), extra=fields("mna", 1))
    records = make_records(dtype, levels(0.1, 0.2, 0.3))
    records["returns"][:, 0, 0], records["success"][:, 0, 0] = [0.0, 0.0, 5.0], [1.0, 0.0, 0.0]
    made.remember(records)
    assert records["ever_solved"].tolist() == [True, False, False]  # the environment's word before the return's
    made.insert(records, records["best"])
    records["origin"], records["success"][:, 0, 0] = Origin.REPLAYED, [0.0, 1.0, 0.0]
    made.remember(records)
    assert records["ever_solved"].tolist() == [True, True, False]
    made.store(records)
    records["success"] = 0.0
    made.remember(records)
    assert records["ever_solved"].tolist() == [True, True, False] == made.slots["solved"].tolist()


def test_states_without_successes_count_a_return_above_zero():
    one, two = buffer(), buffer()
    insert(one, [0.1, 0.2], [1.0, -1.0])
    state = one.state_dict()
    kept = [name for name in state["slots"].dtype.names if name != "solved"]
    older = np.zeros(2, np.dtype([(name, state["slots"].dtype[name]) for name in kept]))
    for name in kept:
        older[name] = state["slots"][name]
    two.load_state_dict(state | {"slots": older})
    assert two.slots["solved"].tolist() == [True, False]
    assert all((two.slots[name] == one.slots[name]).all() for name in kept)


def test_lineage():
    made = buffer()
    insert(made, [0.1], [1.0])
    mother = int(made.slots["id"][0])
    insert(made, [0.2], [2.0], parent=mother)
    insert(made, [0.3], [3.0], parent=made.slots["id"][1])
    assert made.slots["generation"].tolist() == [0, 1, 2]
    assert made.slots["parent"].tolist() == [NONE, mother, made.slots["id"][1]]


def test_ids_outlive_their_levels():
    made = buffer(capacity=2, staleness_coef=0.0)
    insert(made, [0.1, 0.2], [1.0, 2.0])
    first, second = made.slots["id"].tolist()
    insert(made, [0.3], [3.0])
    assert made.find(np.array([second, first, 99])).tolist() == [1, NONE, NONE]
    assert buffer().find(np.array([0])).tolist() == [NONE]


def test_it_resumes_where_it_was():
    one, two = buffer(), buffer()
    insert(one, [0.1, 0.2, 0.3, 0.4], [1.0, 2.0, 3.0, 4.0])
    two.load_state_dict(one.state_dict())
    for made in (one, two):
        insert(made, [0.1, 0.5], [9.0, 2.5])
        made.sample(5, np.random.default_rng(0))
    assert one.slots.tobytes() == two.slots.tobytes() and one.now == two.now


@pytest.mark.parametrize(
    ("setting", "number", "message"),
    [
        ("capacity", 0, "capacity must be at least 1, got 0"),
        ("temperature", 0.0, "temperature must be positive, got 0.0"),
        ("priority", "best", "priority must be rank or power, got 'best'"),
        ("staleness_coef", 2.0, "staleness_coef must be between 0 and 1, got 2.0"),
    ],
)
def test_settings_out_of_range_are_refused(setting, number, message):
    with pytest.raises(ValueError, match=message):
        BufferConfig(**{setting: number})
