"""The GRU of segments is a loop of cells: its states, its gradients, and where truncated gradients stop."""

import dataclasses
from itertools import pairwise

import pytest
import torch
from test_memory import QUICK, Cut
from test_team import ARRANGEMENTS, Roles, arranged
from torch import Tensor

from ued.config import PPOConfig
from ued.core.seeding import torch_generator
from ued.learning.memory import GRU, Past
from ued.learning.minibatches import Batch
from ued.learning.networks import Team
from ued.learning.recurrence import segments, steps_to_learn
from ued.learning.student import Student
from ued.methods.dr import DR

TEAMS = [Team(), Team(3, 1), Team(3, 3)]
EXACT = {torch.float32: 1e-5, torch.float64: 1e-10}


def loop(gru: GRU, features: Tensor, memory: Tensor, past: Past, bptt_steps: int = 0) -> tuple[Tensor, Tensor]:
    """Compute what `GRU.forward` returns one cell after another; gradients stop every `bptt_steps` steps."""
    if past.kept is not None:  # here the others are computed, too
        features, given = features.new_zeros(past.kept.numel(), *features.shape[1:]), features
        features[past.kept.flatten()] = given
    state = memory.view(len(memory), *features.shape[1:])
    size, states = state.shape[-1], []
    for t, seen in enumerate(features.unflatten(0, (-1, len(memory)))):
        if bptt_steps and t and t % bptt_steps == 0:
            state = state.detach()
        if past.episode_starts is not None:
            state = state * (~past.episode_starts[t]).to(state.dtype).view(-1, *[1] * (state.ndim - 1))
        read, recalled = gru.read(seen).split(size, -1), gru.recall(state).split(size, -1)
        reset, keep = torch.sigmoid(read[0] + recalled[0]), torch.sigmoid(read[1] + recalled[1])
        state = (1 - keep) * torch.tanh(read[2] + reset * recalled[2]) + keep * state
        states.append(state)
    remembered = torch.cat(states)
    remembered = remembered if past.kept is None else remembered[past.kept.flatten()]
    return remembered if past.mask is None else remembered[past.mask], state.flatten(1)


@pytest.mark.parametrize("team", TEAMS)
@pytest.mark.parametrize("kind", EXACT)
@pytest.mark.parametrize("starts", [None, 0.0, 0.1, 0.5, 1.0])
def test_states_and_gradients_are_those_of_a_loop_of_cells(team, kind, starts):
    steps, envs, size, draw = 13, 5, 6, torch_generator(3)
    gru = GRU(size, torch_generator(0), team).to(kind)
    for layer in (gru.read, gru.recall):
        torch.nn.init.normal_(layer.bias, generator=draw)
    shape = (steps * envs, size) if team.agents == 1 else (steps * envs, team.agents, size)
    features = torch.randn(shape, generator=draw, dtype=kind, requires_grad=True)
    memory = torch.randn(envs, gru.width, generator=draw, dtype=kind, requires_grad=True)
    begins = None if starts is None else torch.rand(steps, envs, generator=draw) < starts
    mask = torch.rand(steps * envs, generator=draw) < 0.7
    past = Past(memory, begins, mask)
    weights = torch.randn(int(mask.sum()), *shape[1:], generator=draw, dtype=kind)
    found, wanted = [], []
    for into, (states, after) in ((found, gru(features, memory, past)), (wanted, loop(gru, features, memory, past))):
        loss = (states * weights).sum() + after.square().sum()
        into += [states, after, *torch.autograd.grad(loss, [features, memory, *gru.parameters()])]
    for ours, theirs in zip(found, wanted, strict=True):
        torch.testing.assert_close(ours, theirs, atol=EXACT[kind], rtol=EXACT[kind])


@pytest.mark.parametrize("team", TEAMS)
@pytest.mark.parametrize("share", [0.0, 0.02, 0.3])
def test_steps_that_nothing_is_learned_from_are_left_out(team, share):
    steps, envs, size, draw = 13, 5, 6, torch_generator(5)
    gru = GRU(size, torch_generator(0), team)
    shape = (steps * envs, size) if team.agents == 1 else (steps * envs, team.agents, size)
    features, memory = torch.randn(shape, generator=draw), torch.randn(envs, gru.width, generator=draw)
    begins, train = (torch.rand(steps, envs, generator=draw) < rate for rate in (0.2, share))
    train[6, 3] = True
    kept = steps_to_learn(train, begins)
    wanted = torch.zeros_like(kept)
    for t, env in train.nonzero().tolist():
        while True:
            wanted[t, env] = True
            if t == 0 or begins[t, env]:
                break
            t -= 1
    assert kept.equal(wanted) and not kept.all()
    every = gru(features, memory, Past(memory, begins, train.flatten()))[0]
    rows = kept.flatten()
    some, after = gru(features[rows], memory, Past(memory, begins, train.flatten()[rows], kept))
    torch.testing.assert_close(some, every)
    assert after is memory


def test_segments_hold_each_step_once_and_the_longest_come_first():
    begins = torch.rand(9, 4, generator=torch_generator(0)) < 0.3
    packed = segments(begins)
    assert sorted(packed.rows.tolist()) == list(range(36)) and packed.rows[packed.places].equal(torch.arange(36))
    assert packed.counts == sorted(packed.counts, reverse=True) and sum(packed.counts) == 36
    assert packed.rows[: packed.counts[0]].equal(packed.first)
    begins[0] = True
    assert set(packed.first.tolist()) == set(begins.flatten().nonzero()[:, 0].tolist())
    blocks = packed.rows.split(packed.counts)
    for earlier, later in pairwise(blocks):
        assert later.equal(earlier[: len(later)] + 4)  # the next step of the same environment


def filled(agents: int, team: str, critic: str, shared_torso: bool, **settings: int) -> DR:
    """Return a method whose rollout begins in the middle of episodes."""
    config = arranged(team, critic, memory="gru", num_steps=12, hidden_size=8, shared_torso=shared_torso, **settings)
    method = DR(Cut(4) if agents == 1 else Roles(4, agents), config, seed=2)
    for _ in range(2):
        method.update()
    method.fill_rollouts()
    method.learner.rollout.train[:, 1] = False
    method.learner.rollout.train[5:, 2] = False
    return method


def gradients(student: Student, batch: Batch) -> list[Tensor]:
    """Return the gradients of a sum over all steps, whatever the order of its rows."""
    policy, value = student(batch.observation, batch.past)
    loss = (policy.log_prob(batch.action) + (value - batch.target) ** 2).sum()
    return list(torch.autograd.grad(loss, list(student.parameters())))


SEVERAL = [(3, *each) for each in ARRANGEMENTS]


@pytest.mark.slow
@pytest.mark.sample(6)
@pytest.mark.parametrize(("agents", "team", "critic"), [(1, "independent", "own"), *SEVERAL])
@pytest.mark.parametrize("shared_torso", [False, True])
@pytest.mark.parametrize("bptt_steps", [1, 4])
def test_truncated_gradients_are_those_of_a_loop_that_stops_them(
    agents, team, critic, shared_torso, bptt_steps, monkeypatch
):
    method = filled(agents, team, critic, shared_torso, bptt_steps=bptt_steps)
    rollout, student, draw = method.learner.rollout, method.student, torch_generator(4)
    for ended in (rollout.terminated, rollout.truncated):  # the episodes of these environments are short
        ended.copy_(torch.rand(ended.shape, generator=draw) < 0.1)
    rollout.memory.uniform_(-1, 1, generator=draw)
    rollout.observation.normal_(generator=draw)
    batch = Batch.of(rollout, rollout.value, rollout.value + 1)
    batch.add_memories(student, bptt_steps, 3)
    pieces = student.actor_memory.sequences(rollout.train, bptt_steps)
    assert pieces.shape[1] == bptt_steps and len(pieces) < rollout.train.numel() // bptt_steps
    found = gradients(student, next(batch.minibatches(pieces.flip(0), len(pieces))))
    whole = Batch.of(rollout, rollout.value, rollout.value + 1)
    sequences = student.actor_memory.sequences(rollout.train)
    whole = next(whole.minibatches(sequences, len(sequences)))
    untruncated = gradients(student, whole)
    monkeypatch.setattr(GRU, "forward", lambda *given: loop(*given, bptt_steps))
    wanted = gradients(student, whole)
    for ours, theirs in zip(found, wanted, strict=True):
        torch.testing.assert_close(ours, theirs, atol=1e-5, rtol=1e-4)
    assert any(not torch.allclose(one, other, rtol=1e-3) for one, other in zip(found, untruncated, strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("size", [1, 4])
def test_the_memory_at_cuts_is_what_was_played(size):
    method = filled(1, "independent", "own", False)
    rollout, student = method.learner.rollout, method.student
    batch = Batch.of(rollout, rollout.value, rollout.value)
    batch.add_memories(student, 3, size)
    memory = rollout.memory.clone()
    for t in range(12):
        memory[rollout.episode_starts[t]] = 0.0
        if t % 3 == 0:
            expected = memory if t == 0 else torch.where(rollout.episode_starts[t][:, None], 0.0, memory)
            found = torch.where(rollout.episode_starts[t][:, None], 0.0, batch.past.memory[t // 3])
            torch.testing.assert_close(found, expected)
        student.act(rollout.observation[t], torch_generator(0), memory)
    assert batch.past.memory.shape == (4, 4, student.memory_width)


@pytest.mark.parametrize("memory", ["gru", "none"])
def test_pieces_as_long_as_the_rollout_are_whole_rollouts(memory):
    config = dataclasses.replace(QUICK, memory=memory)
    methods = [DR(Cut(4), dataclasses.replace(config, bptt_steps=steps), seed=2) for steps in (0, 16)]
    for method in methods:
        method.update()
    one, other = (method.student.state_dict() for method in methods)
    assert all(torch.equal(one[name], other[name]) for name in one)


def test_pieces_divide_the_rollout():
    with pytest.raises(ValueError, match="bptt_steps must divide num_steps, 64, got 48"):
        PPOConfig(bptt_steps=48)
