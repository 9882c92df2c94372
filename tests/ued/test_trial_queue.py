"""Both students play the same levels, the same number of whole episodes each, whatever the lengths."""

import numpy as np
import pytest

from ued.levels.queue import TrialQueue
from ued.levels.record import make_trials, trial_dtype
from ued.upomdp import level_dtype


def make_queue(num_envs=4, episodes=2, max_lead=None):
    dtype = trial_dtype(level_dtype(1), 2, episodes)
    made = []

    def supply(count):
        trials = make_trials(dtype, np.zeros(count, level_dtype(1)))
        trials["level"]["program"] = np.arange(len(made), len(made) + count)
        made.extend(range(count))
        return trials

    return TrialQueue(supply, dtype, num_envs, max_lead or 2 * num_envs, num_envs), made


class Crowd:
    """Two students of N environments whose episodes last `lengths(student, level)` steps and return `returns(...)`."""

    def __init__(self, queue, lengths, returns):
        self.queue, self.lengths, self.returns = queue, lengths, returns
        self.level = [queue.first(s)["level"]["program"] for s in (0, 1)]
        self.age = np.zeros((2, queue.num_envs), int)
        self.played = [{}, {}]
        self.cut = 0

    def step(self):
        for s in (0, 1):
            self.age[s] += 1
            wanted = np.array([self.lengths(s, level) for level in self.level[s]])
            ended = np.flatnonzero(self.age[s] >= wanted)
            if not len(ended):
                continue
            for env in ended:
                level = int(self.level[s][env])
                self.played[s][level] = self.played[s].get(level, 0) + 1
            returns = np.array([self.returns(s, level) for level in self.level[s][ended]], float)
            where, trials = self.queue.renew(s, ended, returns)
            assert set(where) <= set(ended)  # only an environment between episodes changes its level
            self.level[s][where] = trials["level"]["program"]
            self.age[s][ended] = 0


def test_every_level_is_settled_once_with_the_returns_made_on_it():
    queue, _ = make_queue()
    rng = np.random.default_rng(0)
    length = {(s, level): rng.integers(1, 30) for s in (0, 1) for level in range(2000)}
    crowd = Crowd(queue, lambda s, level: length[s, int(level)], lambda s, level: 10 * level + s)
    settled = []
    for _ in range(60):
        for _ in range(16):
            crowd.step()
        settled.append(queue.take_settled())
        queue.drop_untaken()
    settled = np.concatenate(settled)
    levels = settled["level"]["program"]
    assert len(set(levels)) == len(levels) > 100
    assert (settled["returns"] == (10 * levels[:, None] + [0, 1])[:, :, None]).all()
    assert (settled["played"] == 2).all()


def test_long_episodes_are_not_left_out():
    """Levels alternate between 1 and 40 steps. Taking what ends in a rollout of 16 would see the short ones alone."""
    queue, _ = make_queue(num_envs=16)
    crowd = Crowd(queue, lambda s, level: 40 if level % 2 else 1, lambda s, level: 0)
    settled = []
    for _ in range(200):
        for _ in range(16):
            crowd.step()
        settled.append(queue.take_settled())
    levels = np.concatenate(settled)["level"]["program"]
    assert len(levels) > 300
    assert (levels % 2).mean() == pytest.approx(0.5, abs=0.03)


def test_a_faster_student_stays_near_the_other_and_plays_on_meanwhile():
    queue, _ = make_queue(num_envs=4, max_lead=6)
    crowd = Crowd(queue, lambda s, level: (2, 20)[s], lambda s, level: s)
    for _ in range(400):
        crowd.step()
        assert 0 <= queue.taken[0] - queue.taken[1] <= 6
    settled = queue.take_settled()
    assert len(settled) == 4 * 400 // 20 // 2  # as many as the slower one can play
    assert max(crowd.played[0].values()) > 2 and max(crowd.played[1].values()) == 2
    assert (settled["returns"] == np.array([0, 1])[None, :, None]).all()


def test_what_nobody_has_begun_is_dropped_and_proposed_anew():
    queue, _ = make_queue(num_envs=4, episodes=1)
    queue.first(0)
    assert len(queue.trials) == 4
    queue.renew(0, np.array([1]), np.array([0.0]))  # takes one of a block of four
    assert len(queue.trials) == 8
    queue.drop_untaken()
    assert len(queue.trials) == 5
    queue.first(1)
    assert (queue.trials["level"]["program"] == [0, 1, 2, 3, 4]).all()


def test_it_resumes_where_it_was():
    queues = [make_queue()[0] for _ in range(2)]
    for queue in queues:
        queue.first(0), queue.first(1)
    rng = np.random.default_rng(1)
    one, two = queues
    for _ in range(30):
        s, ended = rng.integers(2), np.flatnonzero(rng.random(4) < 0.5)
        returns = rng.normal(size=len(ended))
        left, right = (queue.renew(s, ended, returns) for queue in (one, two))
        assert (left[0] == right[0]).all() and (left[1]["level"] == right[1]["level"]).all()
        two.load_state_dict(two.state_dict())
    assert one.take_settled().tobytes() == two.take_settled().tobytes()


def test_a_lead_shorter_than_the_environments_is_refused():
    with pytest.raises(ValueError, match=r"max_lead must be at least the number of environments \(4\), got 3"):
        make_queue(max_lead=3)
