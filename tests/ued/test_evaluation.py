"""Whole episodes from a fixed list: none left out for being long, none counted twice."""

import numpy as np
import pytest
from probes import Landscape, TwoStep

from ued import evaluation
from ued.config import PPOConfig
from ued.core.seeding import torch_generator
from ued.core.upomdp import PREFETCH
from ued.evaluation import Schedule, evaluate, play_together
from ued.learning.student import Student


class Lengths(Landscape):
    """A level lasts 1 to 40 steps by θ[0] and returns its own length times 10; pays once, at the end."""

    def outcome(self, actions):
        length = np.round((self.levels["theta"][:, 0] + 1) / 2 * 39 + 1).astype(int)
        last = self.t + 1 >= length
        return np.where(last, 10.0 * length, 0.0), last, np.zeros_like(last)


def student_for(env):
    spaces = env.single_observation_space, env.single_action_space
    return Student(*spaces, PPOConfig(hidden_size=8), torch_generator(0))


@pytest.mark.slow
@pytest.mark.sample(2)
@pytest.mark.parametrize(("num_envs", "episodes"), [(4, 203), (16, 5), (7, 7), (1, 6)])
def test_every_episode_is_played_to_its_end(num_envs, episodes):
    env = Lengths(num_envs)
    found = evaluate(student_for(env), env, episodes, seed=0)
    length = np.round((found.levels["theta"][:, 0] + 1) / 2 * 39 + 1)
    assert found.returns.tolist() == (10 * length).tolist()
    assert found.lengths.tolist() == length.tolist()
    assert found.level.tolist() == list(range(episodes))
    assert found.lengths.sum() <= found.env_steps <= found.lengths.sum() + num_envs * 40


def test_given_levels_are_played_equally_often():
    env = Lengths(8)
    levels = env.make_levels([[-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    found = evaluate(student_for(env), env, 30, seed=1, levels=levels)
    assert np.bincount(found.level).tolist() == [10, 10, 10]
    assert [set(found.lengths[found.level == i]) for i in range(3)] == [{1}, {40}, {20}]
    assert (found.levels == levels).all()


def test_the_same_seed_gives_the_same_episodes():
    env = Landscape(8)
    student = student_for(env)
    one, two, other = (evaluate(student, Landscape(8), 40, seed=s) for s in (0, 0, 1))
    assert (one.returns == two.returns).all() and (one.levels == two.levels).all()
    assert (one.levels != other.levels).any()


class Walks(Lengths):
    """Like `Lengths`; each action pays, more in later steps."""

    def outcome(self, actions):
        return np.asarray(actions) * (1.0 + self.t), *super().outcome(actions)[1:]


@pytest.mark.parametrize("memory", ["none", "gru"])
def test_schedules_that_are_played_together_have_their_own_random_numbers(memory):
    spaces = Walks(4).single_observation_space, Walks(4).single_action_space
    student = Student(*spaces, PPOConfig(hidden_size=8, memory=memory), torch_generator(0))
    apart = [Schedule(Walks(4), episodes, seed).play(student) for episodes, seed in ((50, 1), (3, 2), (20, 3))]
    ended = []
    schedules = [Schedule(Walks(4), episodes, seed) for episodes, seed in ((50, 1), (3, 2), (20, 3))]
    together = play_together(schedules, student, on_end=ended.append)
    for one, other in zip(apart, together, strict=True):
        assert (one.returns == other.returns).all() and (one.lengths == other.lengths).all()
        assert (one.levels == other.levels).all() and one.returns.std() > 0
    assert sum(ended) == 73
    assert not any(schedule.upomdp.idle.any() for schedule in schedules)


def test_greedy_takes_the_likeliest_action():
    env = TwoStep(4)
    student = student_for(env)
    student.actor.layer.bias.data[1] = 0.5
    seen = []
    outcome = env.outcome
    env.outcome = lambda actions: seen.append(actions) or outcome(actions)
    evaluate(student, env, 8, seed=0, greedy=True)
    assert (np.concatenate(seen) == 1).all()


def test_what_cannot_be_evaluated_is_refused(monkeypatch):
    env = TwoStep(4)
    with pytest.raises(ValueError, match="episodes must be at least 1, got 0"):
        evaluate(student_for(env), env, 0, seed=0)
    with pytest.raises(ValueError, match="levels must hold at least one level, got none"):
        evaluate(student_for(env), env, 1, seed=0, levels=env.levels[:0])
    monkeypatch.setattr(evaluation, "LONGEST_EPISODE", 50)
    env.outcome = lambda actions: (np.zeros(4), np.zeros(4, bool), np.zeros(4, bool))
    with pytest.raises(RuntimeError, match="an episode did not end within 50 steps"):
        evaluate(student_for(env), env, 1, seed=0)


@pytest.mark.slow
def test_levels_are_announced_in_the_order_of_play_once_and_before_they_are_played(monkeypatch):
    env, events = Lengths(7), []
    reset_to_levels = env.reset_to_levels
    monkeypatch.setattr(env, "prefetch", lambda levels: events.append(("announced", levels["seed"].tolist())))
    monkeypatch.setattr(
        env,
        "reset_to_levels",
        lambda levels, *args: events.append(("played", levels["seed"].tolist())) or reset_to_levels(levels, *args),
    )
    order = evaluate(student_for(env), env, 500, seed=0).levels["seed"].tolist()
    batches = [seeds for event, seeds in events if event == "announced"]
    assert [len(batch) for batch in batches[:2]] == [PREFETCH, PREFETCH] and not batches[-1]
    announced = [seed for batch in batches for seed in batch]
    assert announced == [seed for seed in order if seed in set(announced)]
    unknown, known = [], set()
    for event, seeds in events:
        if event == "announced":
            known |= set(seeds)
        else:
            unknown += [seed for seed in seeds if seed not in known]
    assert order[:7] == unknown[:7] and len(unknown) <= 7 * len(batches)
