"""Novelty of levels: densities by the plain formula, what is new and what was seen, and how CENIE replays by it."""

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete, MultiDiscrete
from probes import Probe

from ued import CENIE, BufferConfig, CENIEConfig, PPOConfig, ThetaSpace
from ued.config import CoverageConfig
from ued.core.level_space import level_dtype
from ued.learning.networks import choices_of
from ued.learning.rollout import Rollout
from ued.levels.novelty import CLIP, Coverage, EpisodeNovelty, silhouette, state_actions
from ued.levels.novelty_buffer import NoveltyBuffer
from ued.levels.record import level_record_dtype, make_records
from ued.methods.cenie import CENIECurriculum

PPO = PPOConfig(num_steps=16, num_minibatches=2, update_epochs=1, hidden_size=8)


def clusters(*centers, rows=100, columns=3):
    rng = np.random.default_rng(7)
    return np.concatenate([center + 0.1 * rng.standard_normal((rows, columns)) for center in centers])


def coverage(pairs, **settings):
    made = Coverage(pairs.shape[1], CoverageConfig(**settings), seed=0)
    made.remember(pairs)
    made.refit()
    return made


def test_novelty_is_the_density_of_the_fitted_mixture():
    pairs = clusters(0.0, 2.0, 5.0)
    made = coverage(pairs)
    scaled = np.clip((pairs - made.mixture["center"]) / made.mixture["scale"], -CLIP, CLIP).astype(float)
    spread = scaled[:, None] - made.mixture["means"]  # [n, K, D]
    variances = made.mixture["covariances"]
    log = -0.5 * (spread**2 / variances + np.log(2 * np.pi * variances)).sum(2)
    density = (made.mixture["weights"] * np.exp(log)).sum(1)
    assert made.novelty(pairs) == pytest.approx(-np.log(density), abs=1e-3)


def test_what_was_never_seen_is_novel_and_no_longer_when_it_was_seen():
    old, new = clusters(0.0, 1.0), clusters(3.0)
    made = coverage(old, fit_every=1)
    before = made.novelty(new).mean()
    assert before > made.novelty(old).mean() + 5
    made.remember(new)
    made.refit()
    assert made.novelty(new).mean() < before - 5


def test_the_window_forgets_the_oldest_pairs():
    made = coverage(clusters(0.0), window=100, fit_every=1)
    made.remember(clusters(8.0, rows=60))
    assert len(made.pairs) == 100 and (made.pairs[:40] < 4).all() and (made.pairs[40:] > 4).all()


def test_a_mixture_is_fitted_early_and_then_seldom():
    made, fits = Coverage(3, CoverageConfig(fit_every=4), seed=0), []
    for update in range(1, 17):
        made.remember(clusters(float(update), rows=20))
        made.refit()
        fits += [update] if made.fitted == update else []
    assert fits == [1, 2, 4, 8, 12, 16]


def test_silhouettes_by_hand():
    rows = np.array([[0.0], [1.0], [10.0], [12.0]])
    by_hand = [1 - 1 / 11, 1 - 1 / 10, 1 - 2 / 9.5, 1 - 2 / 11.5]
    assert silhouette(rows, np.array([0, 0, 1, 1])) == pytest.approx(np.mean(by_hand))
    assert silhouette(rows, np.array([0, 0, 0, 1])) == pytest.approx(
        np.mean([(12 - 5.5) / 12, (11 - 5) / 11, -7.5 / 9.5, 0])
    )
    assert silhouette(rows, np.zeros(4, int)) == -1


@pytest.mark.parametrize("count", [2, 4, 8])
def test_the_silhouette_tells_how_many(count):
    centers = 4 * np.eye(8)[:count]
    assert coverage(clusters(*centers, columns=8)).components == count


@pytest.mark.parametrize(
    ("space", "actions", "columns"),
    [
        (Discrete(3, start=-1), [[0], [2]], [[1, 0, 0], [0, 0, 1]]),
        (MultiDiscrete([2, 3]), [[1, 2], [0, 0]], [[0, 1, 0, 0, 1], [1, 0, 1, 0, 0]]),
        (Box(-1, 1, (2,)), [[0.5, -3.0], [0.0, 1.0]], [[0.5, -3.0], [0.0, 1.0]]),
    ],
    ids=str,
)
@pytest.mark.parametrize("agents", [1, 2])
def test_a_pair_is_the_observation_and_the_action(space, actions, columns, agents):
    rollout = Rollout.empty(2 if agents == 1 else 1, 1, Box(0, 255, (1, 2, 1), np.uint8), space, agents)
    rollout.observation.view(2, 2)[:] = torch.tensor([[1, 2], [3, 4]])
    rollout.action.view(2, -1)[:] = torch.tensor(actions)
    pairs = state_actions(rollout, choices_of(space))
    assert pairs.tolist() == [[1, 2, *columns[0]], [3, 4, *columns[1]]]
    assert state_actions(rollout, choices_of(space), torch.tensor([1])).tolist() == pairs[1:].tolist()


# ---------------------------------------------------------------- episodes


def rollout(rng, steps, envs, agents=1):
    made = Rollout.empty(steps, envs, Box(-9, 9, (2,)), Discrete(2), agents)
    made.observation[:] = torch.as_tensor(rng.normal(size=made.observation.shape))
    made.action[:] = torch.as_tensor(rng.integers(0, 2, made.action.shape))
    made.terminated[:] = torch.as_tensor(rng.random((steps, envs)) < 0.2)
    made.train[:] = torch.as_tensor(rng.random((steps, envs)) < 0.5)
    return made


@pytest.mark.parametrize("agents", [1, 3])
def test_an_episode_is_as_novel_as_its_mean_step_and_as_any_before_there_is_a_mixture(agents):
    rng, envs, steps = np.random.default_rng(0), 4, 12
    model = Coverage(4, CoverageConfig(), seed=0)
    values, open_ = EpisodeNovelty(envs, model, Discrete(2)), [[] for _ in range(envs)]
    for number in range(4):
        made = rollout(rng, steps, envs, agents)
        per_pair = (
            model.novelty(state_actions(made, np.array([2]))) if number else np.full(steps * envs * agents, np.inf)
        )
        per_step, expected = per_pair.reshape(steps, envs, -1).mean(2), []
        found = values.track(made, torch.zeros(made.value.shape))["novelty"]
        model.refit()
        for t in range(steps):
            for n in range(envs):
                open_[n].append(per_step[t, n])
                if made.terminated[t, n]:
                    expected.append(np.mean(open_[n]))
                    open_[n] = []
        assert found == pytest.approx(expected, abs=1e-3)
        assert np.isinf(found).any() == (number < 2)  # an episode of the first rollout may end in the second


def test_only_pairs_that_students_learn_from_enter_the_window():
    rng = np.random.default_rng(1)
    model = Coverage(4, CoverageConfig(pairs_per_update=10), seed=0)
    values = EpisodeNovelty(4, model, Discrete(2))
    made = rollout(rng, 12, 4)
    made.observation[..., 0] = made.train.float()
    values.track(made, torch.zeros(made.value.shape))
    assert len(model.pairs) == 10 and (model.pairs[:, 0] == 1).all()
    made.train[:] = False
    values.track(made, torch.zeros(made.value.shape))
    assert len(model.pairs) == 10 and model.updates == 1


# ---------------------------------------------------------------- the buffer


RECORD = level_record_dtype(level_dtype(1), extra=[("novelty", np.float64, (1, 1))])


def records(values, scores, novelty):
    levels = np.zeros(len(values), level_dtype(1))
    levels["theta"][:, 0] = values
    made = make_records(RECORD, levels)
    made["score"], made["novelty"][:, 0, 0], made["returns"] = scores, novelty, 0.0
    return made


def buffer(share, **settings):
    config = BufferConfig(**{"capacity": 3, "temperature": 1.0, "staleness_coef": 0.0, **settings})
    return NoveltyBuffer(ThetaSpace(1), config, share)


@pytest.mark.parametrize("share", [0.0, 0.25, 1.0])
def test_priorities_of_score_and_of_novelty_are_mixed(share):
    made = buffer(share)
    made.store(records([0.1, 0.2, 0.3], [5.0, 3.0, 1.0], [-2.0, np.inf, 40.0]))
    by_score, by_novelty = np.array([1, 1 / 2, 1 / 3]), np.array([1 / 3, 1, 1 / 2])
    assert made.weights() == pytest.approx(((1 - share) * by_score + share * by_novelty) / (1 + 1 / 2 + 1 / 3))


@pytest.mark.parametrize(("share", "kept"), [(0.0, [0.1, 0.2, 0.3]), (1.0, [0.2, 0.3, 0.9])])
def test_a_full_buffer_lets_in_what_is_worth_more_by_both(share, kept):
    made = buffer(share)
    made.store(records([0.1, 0.2, 0.3], [5.0, 3.0, 2.0], [1.0, 2.0, 3.0]))
    made.store(records([0.9], [1.0], [9.0]))
    assert sorted(made.slots["level"]["theta"][:, 0].tolist()) == kept


def test_a_level_that_is_played_again_gets_its_new_novelty():
    made = buffer(0.5)
    made.store(records([0.1, 0.2], [1.0, 2.0], [10.0, 20.0]))
    again = made.replay(RECORD, 1, np.random.default_rng(0))
    again["novelty"], again["score"], again["returns"] = 5.0, 1.0, 0.0
    made.store(again)
    row = made.find(again["id"])
    assert made.slots["novelty"][row] == [5.0]
    made.store(records([0.1], [0.5], [7.0]))  # the same level, drawn again
    assert len(made) == 2 and made.slots["novelty"][0] == 7.0 and made.slots["score"][0] == 1.0


# ---------------------------------------------------------------- the method


class Corners(Probe):
    """One step in one of two places, without a reward: one level in twenty is in the second place."""

    dim, size = 2, 2
    seed_is_luck = False

    def look(self):
        rare = self.levels["theta"][:, 0] > 0.9
        return np.stack([rare, ~rare], 1).astype(np.float32)

    def outcome(self, actions):
        return np.zeros(self.num_envs), self.everyone, ~self.everyone


@pytest.mark.long
@pytest.mark.parametrize("base", ["plr", "accel"])
def test_levels_that_lead_to_rare_states_are_replayed_more(base):
    shares = {}
    for share in (0.0, 1.0):
        config = CENIEConfig(base=base, novelty_coef=share, buffer=BufferConfig(capacity=200, staleness_coef=0.1))
        method, replayed = CENIE(Corners(), PPO, config, seed=1), []
        for _ in range(40):
            method.update()
            levels = method.last.records
            replayed += (levels["level"]["theta"][levels["train"], 0] > 0.9).tolist()
        shares[share] = np.mean(replayed[len(replayed) // 4 :])
    assert shares[1.0] > 2 * shares[0.0]


@pytest.mark.slow
def test_plr_edits_nothing():
    method = CENIE(Corners(), PPO, CENIEConfig(base="plr", buffer=BufferConfig(capacity=20)), seed=0)
    assert not any(method.update()["levels/edited"] for _ in range(10)) and method.buffer.replays


def test_images_and_levels_without_parameters_are_refused():
    class Large(Probe):
        size, dim = 32 * 33, 1

    class Fixed(Probe):
        dim = 0

    with pytest.raises(ValueError, match=r"at most 1,024 entries, got 1,056 \(1056\); use accel"):
        CENIE(Large(2), PPO)
    with pytest.raises(ValueError, match=r"the environment has none; use base='plr' \(--cenie\.base plr\)"):
        CENIE(Fixed(2), PPO)
    CENIE(Fixed(2), PPO, CENIEConfig(base="plr"))


def test_a_trainer_that_fills_in_no_novelty_is_told():
    levels = CENIECurriculum(ThetaSpace(2), CENIEConfig(), seed=0)
    played = levels.propose(4)
    played["returns"], played["mean_value"] = 0.0, 0.0
    with pytest.raises(ValueError, match=r'cenie needs records\["novelty"\], which the trainer has not filled in'):
        levels.update(played)
    played["novelty"] = 1.0
    assert levels.update(played)["cenie/novelty"] == 1.0
