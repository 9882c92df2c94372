"""The tape of actions: what was done on a level, however long it took and whatever else went on."""

import numpy as np
import pytest

from ued import PairedConfig, PPOConfig
from ued.learning.tape import ActionTape
from ued.methods.paired import Paired
from ued.probes import Frontier


def test_a_tape_tells_each_levels_actions_apart():
    rng, tape, envs = np.random.default_rng(0), ActionTape(5), np.arange(5)
    done, level, told = {k: [] for k in range(5)}, np.arange(5), {}
    tape.begin(envs, level)
    for _ in range(3000):
        actions = rng.integers(0, 9, 5)
        tape.note(actions)
        for env in envs:
            done[level[env]].append(actions[env])
        over = envs[(rng.random(5) < 0.02) & (envs != 0)]  # the first plays one level all the time
        if len(over):
            ended = level[over].copy()
            level[over] = max(done) + 1 + np.arange(len(over))
            done |= {k: [] for k in level[over]}
            tape.begin(over, level[over])
            told |= tape.pop(ended)
    told |= tape.pop(level)
    assert sorted(told) == sorted(done) and len(told[0]) == 3000
    assert all(np.array_equal(told[k], done[k]) for k in done)
    assert tape.pop(np.array([0])) == {}


def test_a_tape_that_nobody_reads_stays_small():
    tape = ActionTape(2)
    for step in range(10_000):
        tape.begin(np.array([0, 1]), np.array([2 * step, 2 * step + 1]))
        tape.note(np.zeros(2, np.int64))
    assert len(tape._over) <= 4096 and len(tape._actions) <= 128


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("students", [2, 3])
def test_every_level_that_a_method_reports_is_on_the_tapes(students):
    config = PairedConfig(students=students, roles="population")
    method = Paired(Frontier(6, longest=4), PPOConfig(num_steps=32, hidden_size=8), config, seed=1)
    method.keep_tapes()
    for _ in range(4):
        method.update()
        records = method.last.records
        for index, learner in enumerate(method.learners):
            tape = learner.worker.tape.pop(records["visit"])
            assert set(tape) == set(records["visit"].tolist()) and len(tape)
            for record in records:  # played again on its level alone, it pays what it paid
                alone, paid, total = Frontier(1, longest=4), [], 0.0
                alone.reset_to_levels(record["level"].reshape(1))
                for action in tape[int(record["visit"])]:
                    _, reward, terminated, truncated, _ = alone.step(np.array([action]))
                    total += float(reward[0])
                    if terminated[0] or truncated[0]:
                        paid, total = [*paid, total], 0.0
                assert paid[: record["num_played"][index]] == record["returns"][index].tolist()
