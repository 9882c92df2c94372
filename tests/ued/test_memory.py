"""Recurrent students: what they remember of an episode, how they look back on it, and what a checkpoint holds of it."""

import copy
import dataclasses

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete
from probes import Landscape, Probe
from test_team import ARRANGEMENTS, Roles, arranged, numbers

from ued.config import CloningConfig, PairedConfig, PPOConfig
from ued.core import checkpoint
from ued.core.seeding import torch_generator
from ued.evaluation import evaluate
from ued.learning.cloning import Cloner
from ued.learning.kl import KLRegularizer
from ued.learning.memory import GRU, Past
from ued.learning.minibatches import Batch
from ued.learning.networks import Team
from ued.learning.student import Player, Student
from ued.methods import METHODS
from ued.methods.dr import DR
from ued.methods.paired import Paired

QUICK = PPOConfig(
    num_steps=16, learning_rate=5e-3, num_minibatches=2, hidden_size=16, hidden_layers=1, gamma=0.9, memory="gru"
)


class Corridor(Probe):
    """A T-maze: the sign at the entrance says which way to turn at the end, `LENGTH` steps later, unseen until then.

    It pays 1 for the right turn and -1 for the wrong one; who does not remember is paid 0 in the mean.
    """

    LENGTH, size, dim = 3, 2, 1

    def look(self):
        return np.stack([self.sign * (self.t == 0), self.t == self.LENGTH], 1).astype(np.float32)

    def outcome(self, actions):
        over = self.t == self.LENGTH
        right = (actions == 1) == (self.sign > 0)
        return np.where(over, np.where(right, 1.0, -1.0), 0.0), over, np.zeros_like(over)


class Cut(Corridor):
    """A corridor that never ends by itself: episodes are cut off, and the last observation is worth something."""

    def outcome(self, actions):
        reward, over, nothing = super().outcome(actions)
        return reward, nothing, over


def trained(memory, updates):
    method = DR(Corridor(32), dataclasses.replace(QUICK, memory=memory), seed=1)
    for _ in range(updates):
        metrics = method.update()
    return method.student, metrics


@pytest.mark.long
def test_a_gru_solves_a_maze_whose_sign_must_be_remembered_and_a_feed_forward_student_cannot():
    student, metrics = trained("gru", 60)
    assert metrics["return_100/student"] > 0.9
    assert evaluate(student, Corridor(8), 64, seed=0, greedy=True).returns.mean() > 0.9  # more than once through each
    student, metrics = trained("none", 60)
    assert abs(metrics["return_100/student"]) < 0.5


def test_it_is_torchs_gru():
    ours, theirs = GRU(6, torch_generator(0), Team()), torch.nn.GRU(6, 6)
    theirs.load_state_dict(
        {
            f"{kind}_{part}_l0": getattr(layer, kind)
            for part, layer in (("ih", ours.read), ("hh", ours.recall))
            for kind in ("weight", "bias")
        }
    )
    draw = torch_generator(1)
    features, memory = torch.randn(5, 3, 6, generator=draw), torch.randn(3, 6, generator=draw)
    wanted, last = theirs(features, memory[None])
    found, after = ours(features.flatten(0, 1), memory, Past(memory))
    torch.testing.assert_close(found, wanted.flatten(0, 1))
    torch.testing.assert_close(after, last[0])


def test_what_was_before_an_episode_is_forgotten():
    gru, draw = GRU(6, torch_generator(0), Team()), torch_generator(1)
    features, memory = torch.randn(5, 2, 6, generator=draw), torch.randn(2, 6, generator=draw)
    begins = torch.zeros(5, 2, dtype=torch.bool)
    begins[3, 1] = True
    whole, _ = gru(features.flatten(0, 1), memory, Past(memory, begins))
    whole = whole.unflatten(0, (5, 2))
    anew, _ = gru(features[3:, 1:].flatten(0, 1), torch.zeros(1, 6), Past(torch.zeros(1, 6)))
    on, _ = gru(features[:, :1].flatten(0, 1), memory[:1], Past(memory[:1]))
    torch.testing.assert_close(whole[3:, 1], anew)
    torch.testing.assert_close(whole[:, 0], on)


SEVERAL = [(3, *each) for each in ARRANGEMENTS]


@pytest.mark.slow
@pytest.mark.sample(4)
@pytest.mark.parametrize(("agents", "team", "critic"), [(1, "independent", "own"), *SEVERAL])
@pytest.mark.parametrize("shared_torso", [False, True])
def test_looking_back_it_thinks_what_it_thought(agents, team, critic, shared_torso):
    """Before anything is learned, sequences give the probabilities and values of when they were played."""
    config = arranged(team, critic, memory="gru", num_steps=10, hidden_size=8, shared_torso=shared_torso)
    env = Cut(4) if agents == 1 else Roles(4, agents)
    method = DR(env, config, seed=2)
    for _ in range(3):
        method.update()
    method.fill_rollouts()  # begins in the middle of episodes, and others begin in it
    rollout, student = method.learner.rollout, method.student
    if agents == 1:
        assert rollout.memory.abs().sum() > 0 and rollout.episode_starts.any() and rollout.final_value.abs().sum() > 0
    rollout.train[:, 1], rollout.train[:9, 2] = False, False
    sequences = student.actor_memory.sequences(rollout.train)
    assert len(sequences) == 3  # one has nothing to be learned from
    batch = next(Batch.of(rollout, rollout.value, rollout.value).minibatches(sequences, len(sequences)))
    policy, value = student(batch.observation, batch.past)
    torch.testing.assert_close(policy.log_prob(batch.action), batch.log_prob, atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(value, batch.value, atol=1e-5, rtol=1e-4)
    assert len(value) == rollout.train.sum()


def test_the_end_that_is_cut_off_is_valued_by_who_remembers():
    method = DR(Cut(4), QUICK, seed=2)
    method.fill_rollouts()
    worker = method.learner.worker
    cut = worker.rollout.truncated
    assert cut.any() and (worker.rollout.final_value != 0).eq(cut).all()
    student, seen = method.student, worker.rollout.observation
    memory = student.empty_memory(4)
    for t in range(Cut.LENGTH + 1):
        student.act(seen[t], torch_generator(0), memory)
    final = torch.zeros(4, 2)  # one step too far
    torch.testing.assert_close(worker.rollout.final_value[Cut.LENGTH], student.value(final, memory))
    assert (student.value(final, memory) != student.value(final)).all()


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("make", [Landscape, Roles])
def test_every_method_trains_them_and_resumes_to_the_same_numbers(name, make, tmp_path):
    row = METHODS[name]
    config = dataclasses.replace(QUICK, num_steps=5, shared_torso=make is Roles)
    method, twin = (row.load()(make(8), config, row.settings(), seed=seed) for seed in (3, 4))
    for _ in range(2):
        method.update()
    checkpoint.save(tmp_path / "c.pt", method.state_dict())
    twin.load_state_dict(checkpoint.load(tmp_path / "c.pt"))
    if make is Landscape and name != "lessons":  # whose first levels take one step; the others one to three of five
        assert any(learner.worker.memory.any() for learner in twin.learners)
    assert repr([numbers(twin.update()) for _ in range(2)]) == repr([numbers(method.update()) for _ in range(2)])


@pytest.mark.slow
def test_a_student_is_kept_close_to_another_that_remembers_in_its_own_way():
    method = DR(Corridor(8), QUICK, seed=0)
    method.fill_rollouts()  # begins with episodes, so that there is nothing that another could not know
    rollout, student = method.learner.rollout, method.student
    sequences = student.actor_memory.sequences(rollout.train)
    batch = next(Batch.of(rollout, rollout.value, rollout.value).minibatches(sequences, len(sequences)))
    policy, _ = student(batch.observation, batch.past)
    assert KLRegularizer(copy.deepcopy(student), 1.0).divergence(batch, policy).item() == pytest.approx(0, abs=1e-6)
    forgetful = Student(Box(-1, 1, (2,)), Discrete(2), dataclasses.replace(QUICK, memory="none"), torch_generator(1))
    assert KLRegularizer(forgetful, 1.0).divergence(batch, policy) > 0
    metrics = Paired(Corridor(8), QUICK, PairedConfig(kl="both_ways", kl_every=1), seed=0).update()
    assert np.isfinite(metrics["antagonist/policy_loss"])


def test_a_player_remembers_each_environment_until_its_episode_ends():
    student = Student(Box(-1, 1, (2,)), Box(-1, 1, (1,)), QUICK, torch_generator(0))
    student.actor.layer.weight.data *= 1000.0  # so that actions tell
    student.actor_memory.read.weight.data *= 3.0
    player, seen = Player(student, torch_generator(0), greedy=True), np.array([[0.5, -0.5], [0.5, -0.5]])
    first, second = player(seen), player(seen)
    assert (first[0] == first[1]).all() and (first != second).all()
    player.begin(np.array([True, False]))
    third = player(seen)
    assert (third[0] == first[0]).all() and (third[1] != second[1]).all()
    player.begin()
    assert (player(seen) == first).all()
    np.testing.assert_allclose(player(seen[:1]), first[:1], rtol=1e-5)


def test_cloning_teaches_feed_forward_students():
    student = Student(Box(-1, 1, (2,)), Discrete(2), QUICK, torch_generator(0))
    with pytest.raises(ValueError, match=r"use a student with memory='none' \(--ppo.memory none"):
        Cloner(student, CloningConfig(), torch_generator(0))
