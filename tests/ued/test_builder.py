"""Adversaries on level families: one that chooses codes at once, and one that builds levels step by step."""

import dataclasses
import importlib.util
from pathlib import Path

import numpy as np
import pytest
import torch

from regista.envs.maze.config import MazeConfig
from regista.envs.maze.env import Mazes
from tests.ued.words import BothWords, DeclaredWords, TypedWords, Typist, Words, letters_a
from ued import METHODS, LevelBuilder
from ued.config import AdversaryConfig, BuilderConfig, PairedConfig, PPOConfig, TeacherConfig
from ued.core.curriculum import ThetaSpace
from ued.core.seeding import torch_generator
from ued.levels.adversary import Adversary
from ued.levels.builder import Builder
from ued.levels.proposer import CodeAdversary, make_adversary
from ued.levels.record import Origin
from ued.levels.teacher import Teacher
from ued.methods.paired import PairedCurriculum

SMALL = PPOConfig(num_steps=64, hidden_size=8, num_minibatches=2, update_epochs=1, memory="gru")
MAZES = MazeConfig(side=5, num_walls=6, max_steps=20)
TEACHING = ["paired", "repaired", "minimax", "self_regret", "paired_literal"]


def teacher(family, seed=0, **settings):
    config = TeacherConfig(adversary=AdversaryConfig(**settings.pop("adversary", {})), **settings)
    return Teacher(ThetaSpace(family), config, 1, 1, seed)


def lesson(curriculum, count=32, score=letters_a):
    """Let it propose, and learn from the scores; return the records and the metrics."""
    records = curriculum.propose(count)
    records["returns"] = 0.0
    return records, curriculum.learn(records, score(records["level"]["theta"]))


def settings_of(name, builder):
    """Return the settings of a method with this kind of adversary."""
    config = METHODS[name].settings()
    adversary = dataclasses.replace(config.adversary, builder=builder, min_batch=2, hidden_size=8)
    return dataclasses.replace(config, adversary=adversary, episodes_per_level=1)


# ---------------------------------------------------------------- a known answer


@pytest.mark.slow
@pytest.mark.parametrize("family, best", [(DeclaredWords, 4.0), (TypedWords, 3.5)])
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.long
def test_the_best_levels_are_found_within_3200_proposals(family, best, seed):
    curriculum = teacher(family(), seed)
    means = [lesson(curriculum)[0]["score"].mean() for _ in range(100)]
    assert means[0] < 1.5
    assert np.mean(means[-20:]) > best - 0.2  # of typed words, every other one cannot end with an "a"


def test_columns_begin_at_the_weights_that_a_family_declares():
    records = teacher(DeclaredWords()).propose(4000)
    theta = records["level"]["theta"]
    assert set(np.unique(theta)) == {-0.75, -0.25, 0.25, 0.75}  # the centers of equal parts, whatever the weights are
    shares = np.array([(theta == center).mean() for center in (-0.75, -0.25, 0.25, 0.75)])
    assert shares == pytest.approx([1 / 8, 1 / 8, 1 / 8, 5 / 8], abs=0.02)


def test_typed_words_begin_uniform():
    theta = teacher(TypedWords()).propose(4000)["level"]["theta"]
    shares = np.array([(theta[:, :3] == center).mean() for center in (-0.75, -0.25, 0.25, 0.75)])
    assert shares == pytest.approx(np.full(4, 0.25), abs=0.03)


# ---------------------------------------------------------------- delayed scores


@pytest.mark.parametrize("memory", ["none", "gru"])
def test_what_a_proposal_carries_is_enough_to_learn_from_it(memory):
    config = AdversaryConfig(context_size=3, steps=BuilderConfig(memory=memory))
    adversary = Builder(Typist(), config, torch_generator(0))
    built, score = adversary.propose(16), np.arange(16.0)
    rollout = adversary._rollout(built, score)
    memory = adversary.ppo.student.empty_memory(16)
    for step in range(Typist.steps):  # from the observations, which are recomputed, come the same numbers
        policy, value = adversary.ppo.student.infer(rollout.observation[step], memory)
        np.testing.assert_array_equal(policy.log_prob(rollout.action[step]).numpy(), built.log_prob[:, step])
        np.testing.assert_array_equal(value.numpy(), built.value[:, step])
    typed = adversary.theta(built)
    assert len(np.unique(typed, axis=0)) > 8
    np.testing.assert_array_equal(rollout.observation[-1, :, :3].numpy(), typed[:, :3].astype(np.float32))
    assert rollout.reward[:-1].abs().max() == 0 and rollout.reward[-1].tolist() == score.tolist()
    assert rollout.terminated[-1].all() and not rollout.terminated[:-1].any()


def test_levels_finish_in_any_order_and_some_never():
    curriculum = teacher(TypedWords(), adversary={"min_batch": 16})
    waiting = np.concatenate([curriculum.propose(16) for _ in range(3)]).view(curriculum.dtype)
    weights = [weight.clone() for weight in curriculum.adversary.ppo.student.parameters()]
    metrics = curriculum.learn(waiting[[3, 40, 7]], np.ones(3))
    assert metrics["adversary/gradient_steps"] == 0 and len(curriculum.pending_proposals) == 3
    assert all(torch.equal(*pair) for pair in zip(weights, curriculum.adversary.ppo.student.parameters(), strict=True))
    metrics = curriculum.learn(waiting[20:33], np.linspace(0, 1, 13))
    assert metrics["adversary/gradient_steps"] == 5 and not len(curriculum.pending_proposals)
    assert curriculum.adversary.ppo.updates == 1


@pytest.mark.parametrize("family", [TypedWords, DeclaredWords])
def test_a_resumed_teacher_goes_on_as_it_would_have(family):
    one, other = (teacher(family(), seed, adversary={"min_batch": 48}) for seed in (0, 1))
    for _ in range(5):
        lesson(one)
    assert len(one.pending_proposals)
    other.space.load_state_dict(one.space.state_dict())
    other.load_state_dict(one.state_dict())
    for _ in range(4):
        (mine, told), (theirs, heard) = lesson(one), lesson(other)
        assert mine.tobytes() == theirs.tobytes() and told == heard


@pytest.mark.slow
@pytest.mark.parametrize("builder", ["direct", "steps"])
def test_a_resumed_run_on_mazes_goes_on_as_it_would_have(builder):
    def started(seed):
        return METHODS["paired"].load()(Mazes(4, MAZES), SMALL, settings_of("paired", builder), seed)

    one, other = started(0), started(1)
    for _ in range(3):
        one.update()
    other.load_state_dict(one.state_dict())
    for _ in range(3):
        told, heard = ({k: v for k, v in run.update().items() if "time" not in k} for run in (one, other))
        np.testing.assert_equal(told, heard)
        assert one.last.theta.tobytes() == other.last.theta.tobytes()


@pytest.mark.slow
def test_a_buffer_may_replay_all_levels():
    for family in (TypedWords(), DeclaredWords()):
        assert len(teacher(family).propose(0)) == 0
    config = dataclasses.replace(settings_of("repaired", "steps"), replay_prob=1.0, min_fill=0.01)
    method = METHODS["repaired"].load()(Mazes(4, MAZES), SMALL, config, 0)
    replayed = [method.update()["levels/replayed"] for _ in range(4)]
    assert replayed[-1] > 0


@pytest.mark.slow
def test_proposals_that_wait_are_few():
    method = METHODS["paired"].load()(Mazes(4, MAZES), SMALL, settings_of("paired", "steps"), 0)
    for _ in range(12):
        method.update()
        assert len(method.queue.records) <= 4 * method.upomdp.num_envs and len(method.curriculum.pending_proposals) < 2
    assert method.curriculum.adversary.ppo.updates > 4


# ---------------------------------------------------------------- every method


@pytest.mark.slow
@pytest.mark.sample(8)
@pytest.mark.parametrize("builder", ["direct", "steps"])
@pytest.mark.parametrize("name", TEACHING)
def test_every_teacher_runs_on_mazes(name, builder):
    method = METHODS[name].load()(Mazes(4, MAZES), SMALL, settings_of(name, builder), seed=0)
    assert isinstance(method.curriculum.adversary, Builder if builder == "steps" else CodeAdversary)
    learned = [method.update().get("adversary/gradient_steps", 0) for _ in range(2)]
    assert sum(learned) > 0
    theta = method.curriculum.propose(32)["level"]["theta"]
    assert method.upomdp.valid(theta).all()
    for code in theta:  # equal mazes have equal codes
        np.testing.assert_array_equal(method.upomdp.level_family.encode(method.upomdp.level_family.decode(code)), code)


@pytest.mark.slow
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["paired", "repaired", "minimax"])
def test_every_teacher_runs_on_the_mazes_of_the_example(name):
    path = Path(__file__).parent.parent.parent / "examples" / "own_levels.py"
    spec = importlib.util.spec_from_file_location("example_maze", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    ppo = dataclasses.replace(SMALL, memory="none")
    method = METHODS[name].load()(example.make(4), ppo, settings_of(name, "auto"), seed=0)
    method.update()
    method.update()
    proposed = method.curriculum.propose(64)
    mazes = [example.Mazes().decode(code) for code in proposed["level"]["theta"]]
    assert all(maze.start != maze.goal for maze in mazes)
    assert set(np.unique(proposed["level"]["theta"][:, : example.SIDE**2])) == {-1.0, 1.0}  # as `encode` writes them
    assert 0.1 < np.mean([maze.walls.mean() for maze in mazes]) < 0.25


@pytest.mark.slow
def test_invalid_proposals_are_replaced_and_punished():
    class Picky(TypedWords):
        def valid(self, codes):
            return codes[:, 0] < 0.5  # no word begins with "d"

    curriculum = teacher(Picky(), invalid_penalty=3.0)
    first = np.mean([(lesson(curriculum)[0]["origin"] == Origin.REPLACED).mean() for _ in range(5)])
    for _ in range(60):
        records, _ = lesson(curriculum)
    assert (records["level"]["theta"][:, 0] < 0.5).all()
    assert first > 0.15 and (records["origin"] == Origin.REPLACED).mean() < 0.05


# ---------------------------------------------------------------- which adversary, and what is refused


def made(family, builder="auto", **settings):
    space = ThetaSpace(family) if not isinstance(family, ThetaSpace) else family
    return make_adversary(space, AdversaryConfig(builder=builder, **settings), torch_generator(0))


def test_a_family_with_both_is_built_unless_it_is_to_be_chosen():
    assert isinstance(Typist(), LevelBuilder)
    kinds = [type(made(family, kind)) for family, kind in ((BothWords(), "auto"), (BothWords(), "direct"))]
    kinds += [type(made(ThetaSpace(2), kind)) for kind in ("auto", "direct")]
    assert kinds == [Builder, CodeAdversary, Adversary, Adversary]


@pytest.mark.parametrize(
    "family, builder, words",
    [
        (Words(), "auto", "or give Words `parameters`, the columns of its codes, or a `builder`"),
        (Words(), "steps", "can be sampled and mutated, but not chosen by theta; use dr, plr"),
        (DeclaredWords(), "steps", "needs a `builder` of DeclaredWords, which has none; use builder='direct'"),
        (TypedWords(), "direct", "needs a `parameters` of TypedWords, which has none; use builder='steps' .--METHOD"),
        (
            ThetaSpace(2),
            "steps",
            "these are vectors of parameters, so use builder='direct' .--METHOD.adversary.builder direct",
        ),
    ],
)
def test_a_refusal_says_what_would_have_been_right(family, builder, words):
    with pytest.raises(ValueError, match=words):
        made(family, builder)


def test_families_that_contradict_themselves_are_refused():
    short, still, flat, vast = DeclaredWords(), TypedWords(), TypedWords(), TypedWords()
    short.parameters = {"letter": (0, 1)}
    still.builder, flat.builder, vast.builder = Typist(), Typist(), Typist()
    still.builder.steps, vast.builder.steps = 0, 10**8
    flat.builder.observe = lambda levels: np.zeros(len(levels[0]))
    for family, words in (
        (short, "have 4 entries, so its `parameters` must have as many, got 1"),
        (still, "Typist must have at least one step and one action, got 0 steps of 4 actions"),
        (
            vast,
            "a batch of 32 levels of 100_000_000 steps, each observed as 4 numbers, needs .* or use builder='direct'",
        ),
        (flat, r"Typist.observe must return a vector per level, for 2 levels \[2, F\], got \[2\]"),
    ):
        with pytest.raises(ValueError, match=words):
            made(family)


def test_a_builder_does_not_observe_the_first_observation_of_a_level():
    with pytest.raises(
        ValueError, match=r"starts from a random vector; use context='random' \(--METHOD.adversary.context random"
    ):
        PairedCurriculum(Mazes(4, MAZES), PairedConfig(adversary=AdversaryConfig(context="observation")))


def test_the_state_of_the_other_adversary_is_refused():
    direct, steps = made(BothWords(), "direct"), made(BothWords(), "steps")
    for own, other, words in ((direct, steps, "builds levels"), (steps, direct, "chooses levels in one step")):
        with pytest.raises(ValueError, match=f"the saved adversary {words}"):
            own.load_state_dict(other.state_dict())
    wider = made(TypedWords(), hidden_size=9)
    with pytest.raises(ValueError, match=r"its actor.layer.weight is \[4, 9\], this one's \[4, 64\]"):
        steps.load_state_dict(wider.state_dict())
