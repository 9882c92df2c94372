"""Both students play the same levels, the same number of whole episodes each, whatever the lengths."""

import numpy as np
import pytest

from ued import BufferConfig, PPOConfig, Repaired, RepairedConfig
from ued.core.level_space import level_dtype
from ued.levels.queue import LevelQueue
from ued.levels.record import Origin, level_record_dtype, make_records
from ued.probes import Frontier


class Counting:
    """A curriculum whose levels are numbered in the order in which it proposed them."""

    def __init__(self, episodes):
        self.dtype, self.count = level_record_dtype(level_dtype(1), 2, episodes), 0

    def propose(self, count):
        records = make_records(self.dtype, np.zeros(count, level_dtype(1)))
        records["level"]["program"] = np.arange(self.count, self.count + count)
        self.count += count
        return records


def make_queue(num_envs=4, episodes=2, max_lead=None):
    return LevelQueue(Counting(episodes), num_envs, max_lead)


class Crowd:
    """Two students of N environments whose episodes last `lengths(student, level)` steps and return `returns(...)`."""

    def __init__(self, queue, lengths, returns):
        self.queue, self.lengths, self.returns = queue, lengths, returns
        self.level = [queue.first(s)["level"]["program"].copy() for s in (0, 1)]
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
            envs, records = self.queue.on_episode_end(s, ended, returns, returns > 0)
            assert set(envs) <= set(ended)  # only an environment between episodes changes its level
            self.level[s][envs] = records["level"]["program"]
            self.age[s][ended] = 0


def test_every_level_is_finished_once_with_the_returns_made_on_it():
    queue = make_queue()
    rng = np.random.default_rng(0)
    length = {(s, level): rng.integers(1, 30) for s in (0, 1) for level in range(8000)}
    crowd = Crowd(queue, lambda s, level: length[s, int(level)], lambda s, level: 10 * level + s)
    finished = []
    for _ in range(60):
        for _ in range(16):
            crowd.step()
        finished.append(queue.pop_finished())
    finished = np.concatenate(finished)
    levels = finished["level"]["program"]
    assert len(set(levels)) == len(levels) > 100
    assert (finished["returns"] == (10 * levels[:, None] + [0, 1])[:, :, None]).all()
    assert (finished["num_played"] == 2).all()


@pytest.mark.slow
def test_long_episodes_are_not_left_out():
    """Levels alternate between 1 and 40 steps. Taking what ends in a rollout of 16 would see the short ones alone."""
    queue = make_queue(num_envs=16)
    crowd = Crowd(queue, lambda s, level: 40 if level % 2 else 1, lambda s, level: 0)
    finished = []
    for _ in range(200):
        for _ in range(16):
            crowd.step()
        finished.append(queue.pop_finished())
    levels = np.concatenate(finished)["level"]["program"]
    assert len(levels) > 300
    assert (levels % 2).mean() == pytest.approx(0.5, abs=0.03)


def test_a_faster_student_stays_near_the_other_and_plays_on_meanwhile():
    queue = make_queue(num_envs=4, max_lead=6)
    crowd = Crowd(queue, lambda s, level: (2, 20)[s], lambda s, level: s)
    for _ in range(400):
        crowd.step()
        assert 0 <= queue.taken[0] - queue.taken[1] <= 6
    finished = queue.pop_finished()
    assert len(finished) == 4 * 400 // 20 // 2  # as many as the slower one can play
    assert max(crowd.played[0].values()) > 2 and max(crowd.played[1].values()) == 2
    assert (finished["returns"] == np.array([0, 1])[None, :, None]).all()


def test_what_nobody_has_begun_is_dropped_and_proposed_anew():
    queue = make_queue(num_envs=4, episodes=1)
    queue.proposal_batch = 4
    queue.first(0)
    assert len(queue.records) == 4
    queue.on_episode_end(0, np.array([1]), np.array([0.0]), np.array([1.0]))  # takes one of a block of four
    assert len(queue.records) == 8
    assert not len(queue.pop_finished())
    assert len(queue.records) == 5
    queue.first(1)
    assert (queue.records["level"]["program"] == [0, 1, 2, 3, 4]).all()


def test_the_levels_that_a_student_will_begin_next_are_announced_once():
    queue, announced = make_queue(num_envs=4, episodes=1), []
    queue.proposal_batch = 4
    queue.prefetch = [lambda levels, s=s: announced.append((s, levels["program"].tolist())) for s in range(2)]

    def end(student):
        queue.on_episode_end(student, np.array([1]), np.array([0.0]), np.array([1.0]))

    queue.first(0)
    assert announced.pop() == (0, [])  # four were proposed, and all of them begun
    end(0)  # takes one of a block of four
    assert announced.pop() == (0, [5, 6, 7])
    end(0), end(0)
    assert not announced
    queue.first(1)
    assert announced.pop() == (1, [4, 5, 6, 7])
    end(0), end(0)  # takes the last of the block, and the first of the next
    assert announced == [(0, [9, 10, 11])]
    queue.load_state_dict(queue.state_dict())  # its environments may be new ones
    end(0)
    assert announced.pop() == (0, [10, 11])


def test_it_resumes_where_it_was():
    queues = [make_queue() for _ in range(2)]
    for queue in queues:
        queue.first(0), queue.first(1)
    rng = np.random.default_rng(1)
    one, two = queues
    for _ in range(30):
        s, ended = rng.integers(2), np.flatnonzero(rng.random(4) < 0.5)
        returns = rng.normal(size=len(ended))
        left, right = (queue.on_episode_end(s, ended, returns, returns > 0) for queue in (one, two))
        assert (left[0] == right[0]).all() and (left[1]["level"] == right[1]["level"]).all()
        two.load_state_dict(two.state_dict())
    assert one.pop_finished().tobytes() == two.pop_finished().tobytes()


def test_a_lead_shorter_than_the_environments_is_refused():
    with pytest.raises(ValueError, match=r"max_lead must be at least the number of environments \(4\), got 3"):
        make_queue(max_lead=3)


@pytest.mark.parametrize("students", [1, 2])
def test_without_a_lead_a_compiled_rollout_takes_no_level_either(students):
    curriculum = Counting(1)
    curriculum.dtype = level_record_dtype(level_dtype(1), students, 1)
    queue = LevelQueue(curriculum, 4, max_lead=0)
    for student in range(students):
        queue.first(student)
        changing, _ = queue.on_episode_end(student, np.arange(2), np.zeros(2), np.zeros(2))
        assert len(changing) == 0
    assert [queue.of(student).most() for student in range(students)] == [0] * students


@pytest.mark.long
@pytest.mark.parametrize("blocks", [False, True])
def test_repaired_counts_the_replays_that_are_played(blocks):
    settings = RepairedConfig(min_fill=0.004, buffer=BufferConfig(capacity=5000))  # forgets none
    method = Repaired(Frontier(16), PPOConfig(num_steps=16, hidden_size=8), settings, seed=0)
    if blocks:
        method.queue.propose_in_blocks()
    played = 0
    for _ in range(40):
        method.update()
        played += np.count_nonzero(method.last.records["origin"] == Origin.REPLAYED)
    played += np.count_nonzero(method.queue.records["origin"] == Origin.REPLAYED)  # these are open
    assert 0 < played == method.buffer.slots["num_replays"].sum()
