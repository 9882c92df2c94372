"""Teams: several agents in one environment, who are paid together, by one PPO."""

import dataclasses

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete, MultiDiscrete
from probes import Follow, Probe

from ued.adapters.mixture import Mixture
from ued.config import PairedConfig, PPOConfig
from ued.core.seeding import torch_generator
from ued.learning.networks import Categorical, Linears
from ued.learning.ppo import PPO
from ued.learning.rollout import Rollout, gae, negative_advantages
from ued.learning.student import Student
from ued.learning.value_stats import EpisodeValues, scored_agents
from ued.methods import METHODS
from ued.methods.dr import DR
from ued.methods.paired import Paired
from ued.methods.paired_literal import PairedLiteral

QUICK = PPOConfig(num_steps=16, learning_rate=3e-3, num_minibatches=4, hidden_size=32, gamma=0.9, ent_coef=0.0)
ARRANGEMENTS = [(team, critic) for team in ("independent", "shared") for critic in ("own", "central")]


class Roles(Probe):
    """One step: all agents see the same sign; those of even number are to follow it, the others to do the opposite.

    The team is paid the mean over its agents of 1 for right and -1 for wrong. So a policy must know whose it is.
    """

    dim = 1

    def __init__(self, num_envs=16, agents=3):
        super().__init__(num_envs)
        self.num_agents = agents
        space = Box(-np.inf, np.inf, (agents, self.size), np.float32)
        everybody = MultiDiscrete([self.actions] * agents)
        super(Probe, self).__init__(num_envs, space, everybody, self.parameters)

    def look(self):
        return np.repeat(self.sign[:, None, None], self.num_agents, 1).astype(np.float32)

    def outcome(self, actions):
        assert actions.shape == (self.num_envs, self.num_agents)
        wanted = (self.sign[:, None] > 0) ^ (np.arange(self.num_agents) % 2 == 1)
        over = np.ones(self.num_envs, bool)
        return np.where(actions == wanted, 1.0, -1.0).mean(1), over, ~over


class Secret(Roles):
    """One step that pays 1 where the signs that two agents see are equal, else -1, whatever they do."""

    def __init__(self, num_envs=16):
        super().__init__(num_envs, agents=2)
        self.signs = np.ones((num_envs, 2))

    def look(self):
        return self.signs[..., None].astype(np.float32)

    def _start(self, levels, where):
        self.signs[where] = self.stream.choice([-1.0, 1.0], (len(where), 2))
        return super()._start(levels, where)

    def outcome(self, actions):
        over = np.ones(self.num_envs, bool)
        return self.signs.prod(1), over, ~over


def arranged(team, critic, **changes):
    return dataclasses.replace(QUICK, team=team, critic=critic, **changes)


def numbers(metrics):
    return {name: value for name, value in metrics.items() if not name.startswith("time/")}


# ---------------------------------------------------------------- one agent


def by_gumbel_max(policy, generator):
    """Sample as the code did on which the numbers below were taken."""
    exponential = torch.empty_like(policy.log_probs).exponential_(generator=generator)
    return (policy.log_probs - exponential.log()).argmax(-1)


def test_one_agent_learns_as_it_did_before_there_were_teams(monkeypatch):
    """The numbers were taken on the code of single students, which teams must not change."""
    monkeypatch.setattr(Categorical, "sample", by_gumbel_max)
    method = DR(Follow(), dataclasses.replace(QUICK, ent_coef=0.01), seed=7)
    for _ in range(3):
        metrics = method.update()
    wanted = {
        "return/student": 0.90625,
        "student/policy_loss": -0.0437049082,
        "student/value_loss": 0.1526868041,
        "student/entropy": 0.1246187645,
        "student/approx_kl": 0.0156861401,
        "student/grad_norm": 0.3971362386,
    }
    assert {name: metrics[name] for name in wanted} == pytest.approx(wanted, rel=1e-4)
    assert not any("agent" in name for name in metrics)


def test_a_stack_of_one_layer_is_that_layer():
    layer, stack = torch.nn.Linear(5, 3), Linears(5, 3, 1)
    stack.load_state_dict(layer.state_dict())
    rows = torch.randn(7, 5, generator=torch_generator(0))
    torch.testing.assert_close(stack(rows[:, None])[:, 0], layer(rows))


# ---------------------------------------------------------------- several


@pytest.mark.slow
@pytest.mark.parametrize("shared_torso", [False, True])
def test_each_agent_of_an_independent_team_learns_as_if_alone(shared_torso):
    """The same rollout, the same minibatches: the weights of the team are those of three students by themselves."""
    config = dataclasses.replace(QUICK, ent_coef=0.01, shared_torso=shared_torso, max_grad_norm=0.05, clip_vloss=True)
    spaces, draw = (Box(-1, 1, (4,)), Discrete(3)), torch_generator(0)
    team = Student(*spaces, config, torch_generator(1), np.ones(4), agents=3)
    rollout = Rollout.empty(16, 8, *spaces, agents=3)
    for column in (rollout.observation, rollout.reward):
        column.normal_(generator=draw)
    rollout.observation *= torch.tensor([1.0, 2.0, 3.0])[:, None]  # each sees something of his own
    rollout.terminated[7] = rollout.truncated[11] = True
    for t in range(16):
        rollout.action[t], rollout.log_prob[t], rollout.value[t] = team.act(rollout.observation[t], draw)
    singles = [share(team, agent, config, spaces) for agent in range(3)]
    for _ in range(2):
        metrics = PPO(team, config, torch_generator(2)).learn(rollout)
        losses = []
        for agent, single in enumerate(singles):
            mine = [rollout.observation, rollout.action, rollout.log_prob, rollout.value]
            mine = [column[:, :, agent] for column in mine]
            ours = [rollout.reward, rollout.terminated, rollout.truncated]
            last = rollout.last_value[..., agent], rollout.memory
            his = Rollout(*mine, *ours, rollout.final_value[..., agent], rollout.train, *last)
            losses.append(PPO(single, config, torch_generator(2)).learn(his))
    for agent, single in enumerate(singles):
        state = share(team, agent, config, spaces).state_dict()
        for name, value in single.state_dict().items():
            torch.testing.assert_close(state[name], value, atol=2e-5, rtol=2e-4, msg=lambda m, n=name: f"{n}: {m}")
        assert metrics[f"agent_{agent}/entropy"] == pytest.approx(losses[agent]["entropy"], rel=1e-4)
        assert metrics[f"agent_{agent}/approx_kl"] == pytest.approx(losses[agent]["approx_kl"], abs=1e-5)
    for name in ("policy_loss", "value_loss", "entropy", "approx_kl", "clip_fraction", "grad_norm"):
        assert metrics[name] == pytest.approx(np.mean([loss[name] for loss in losses]), rel=1e-3, abs=1e-5)


def share(team, agent, config, spaces):
    """Return a student of one agent with this agent's share of the weights of a team."""
    single = Student(*spaces, config, torch_generator(9), np.ones(4))
    state = {}
    for name, value in single.state_dict().items():
        stacked = team.state_dict()[name]
        state[name] = stacked if stacked.shape == value.shape else stacked.view(3, *value.shape)[agent]
    single.load_state_dict(state)
    return single


@pytest.mark.long
@pytest.mark.parametrize(("team", "critic"), ARRANGEMENTS)
def test_a_team_learns_what_each_of_it_is_to_do(team, critic):
    env = Roles()
    method = DR(env, arranged(team, critic), seed=1)
    for _ in range(30):
        metrics = method.update()
    assert metrics["return/student"] > 0.8
    seen = np.array([[[1.0]] * 3, [[-1.0]] * 3])
    assert method.student.play(seen, torch_generator(0), greedy=True).tolist() == [[1, 0, 1], [0, 1, 0]]


@pytest.mark.long
@pytest.mark.parametrize("team", ["independent", "shared"])
def test_only_a_central_critic_knows_what_no_agent_sees_alone(team):
    for critic in ("own", "central"):
        method = DR(Secret(), arranged(team, critic, shared_torso=True), seed=1)
        for _ in range(25):
            metrics = method.update()
        explained = metrics["student/explained_variance"]
        assert explained > 0.95 if critic == "central" else explained < 0.2
    value = method.student.value(torch.tensor([[[1.0], [-1.0]]]))
    assert value.shape == (1, 2) and value[0, 0] == value[0, 1]


def test_nothing_is_told_of_what_a_script_did_for_a_team():
    env = Roles()
    env.with_scripted_policy = env.copy
    metrics = Paired(env, QUICK, PairedConfig(antagonist="scripted"), seed=1).update()
    told = {name.partition("/")[0] for name in metrics if "/action_" in name}
    assert told == {"protagonist"}  # the rollout of a script holds no actions


def test_what_a_team_did_is_told_by_agent():
    metrics = DR(Roles(), arranged("shared", "own"), seed=1).update()
    by_agent = [[metrics[f"student/agent_{agent}/action_{action}"] for action in range(2)] for agent in range(3)]
    assert np.sum(by_agent, 1) == pytest.approx([1, 1, 1]) and np.ptp(by_agent) > 0
    for name in ("entropy", "approx_kl"):
        means = [metrics[f"student/agent_{agent}/{name}"] for agent in range(3)]
        assert np.mean(means) == pytest.approx(metrics[f"student/{name}"])
    assert all(type(number) is float for number in metrics.values())


@pytest.mark.slow
@pytest.mark.sample(3)
@pytest.mark.parametrize("name", METHODS)
def test_every_method_trains_teams_and_resumes_to_the_same_numbers(name):
    row = METHODS[name]
    config = arranged("independent", "central", num_steps=8)
    method, twin = (row.load()(Roles(8), config, row.settings(), seed=3) for _ in range(2))
    for _ in range(2):
        method.update()
    saved = method.state_dict()
    after = [numbers(method.update()) for _ in range(2)]
    assert after[-1]["env_steps"] == 4 * 8 * 8 * len(method.learners)
    twin.load_state_dict(saved)
    assert repr([numbers(twin.update()) for _ in range(2)]) == repr(after)  # nan is nan


def test_the_regret_of_teams_is_that_of_their_returns():
    method = Paired(Roles(8), arranged("shared", "own"), seed=0)
    levels = method.collect_rollouts()
    assert len(levels) and levels["returns"].shape[1:] == (2, 2)
    thirds = 3 * levels["returns"][levels["num_played"].min(1) == 2]
    np.testing.assert_allclose(thirds, np.round(thirds))  # a mean over three agents


def test_advantages_and_values_of_an_episode():
    """Two agents who expect different things of the same rewards; the level's values are means over them."""
    rollout = Rollout.empty(3, 1, Box(-1, 1, (1,)), Discrete(2), agents=2)
    rollout.reward[:, 0], rollout.terminated[2] = torch.tensor([0.0, 0.0, 1.0]), True
    rollout.value[:, 0] = torch.tensor([[0.0, 0.5], [0.0, 0.5], [0.0, 0.5]])
    advantages = gae(rollout, 1.0, 1.0)
    torch.testing.assert_close(advantages[:, 0], torch.tensor([[1.0, 0.5]] * 3))
    stats = EpisodeValues(1).track(rollout, advantages)
    assert stats["mean_value"].tolist() == [0.25] and stats["positive_advantage"].tolist() == [0.75]


def test_negative_advantages_of_a_team_are_means_over_agents():
    rollout = Rollout.empty(3, 1, Box(-1, 1, (1,)), Discrete(2), agents=2)
    rollout.reward[:, 0], rollout.terminated[2] = torch.tensor([0.0, 0.0, 1.0]), True
    rollout.value[:, 0] = torch.tensor([[0.0, 2.0]] * 3)  # the second one expects more than there is
    negative = negative_advantages(rollout, 1.0, 0.5)
    torch.testing.assert_close(negative[:, 0], torch.tensor([[0.0, -0.25], [0.0, -0.5], [0.0, -1.0]]))
    stats = EpisodeValues(1, negative=True).track(rollout, gae(rollout, 1.0, 0.5), negative)
    assert stats["negative_advantage"].tolist() == [0.875]


@pytest.mark.parametrize(("team", "critic"), ARRANGEMENTS)
def test_teams_see_images(team, critic):
    space = Box(0, 255, (36, 36, 3), np.uint8)
    student = Student(space, Discrete(5), arranged(team, critic), torch_generator(0), agents=2)
    images = torch.full((3, 2, 36, 36, 3), 60, dtype=torch.uint8)
    images[1, 0, 5:15, 5:15] = 255  # another sight for agent 0 in row 1
    policy, value = student(images)
    assert policy.log_probs.shape == (3, 2, 5) and value.shape == (3, 2)
    moved = (policy.log_probs[1] - policy.log_probs[0]).abs().amax(-1)
    assert moved[0] > 0 and moved[1] == 0
    assert (policy.log_probs[0, 0] != policy.log_probs[0, 1]).any()  # the same sight, but another agent
    assert (value[1, 1] != value[0, 1]) == (critic == "central")
    torch.testing.assert_close(policy.log_probs[0], policy.log_probs[2])


def test_continuous_actions_of_a_team():
    space = Box(np.array([0.0, -1.0], np.float32), np.array([10.0, 1.0], np.float32))
    for team in ("independent", "shared"):
        student = Student(Box(-1, 1, (4,)), space, arranged(team, "own"), torch_generator(0), agents=3)
        actions = student.play(np.zeros((50, 3, 4)), torch_generator(1))
        assert actions.shape == (50, 3, 2) and actions[..., 0].max() > 5 and abs(actions[..., 1]).max() <= 1
        assert student.act(torch.zeros(50, 3, 4), torch_generator(1))[1].shape == (50, 3)


# ---------------------------------------------------------------- what is refused


def test_a_checkpoint_of_another_number_of_agents_changes_nothing():
    saved, method = DR(Roles(8), QUICK).state_dict(), DR(Roles(8, agents=2), QUICK)
    before = {name: value.clone() for name, value in method.student.state_dict().items()}
    for load in (method.load_state_dict, method.load_students):
        with pytest.raises(ValueError, match="the checkpoint holds a student of 3 agents, the environments have 2"):
            load(saved)
    assert all((before[name] == value).all() for name, value in method.student.state_dict().items())


def test_spaces_that_are_not_alike_for_all_agents_are_refused():
    env = Roles()
    env.num_agents = 4
    with pytest.raises(ValueError, match=r"4 agents need a Box or a MultiDiscrete with an axis for them, got Box"):
        DR(env, QUICK)


class Contrary(Roles):
    """The same with the sign seen turned round, beside a number that says nothing."""

    size = 2

    def look(self):
        seen = np.zeros((self.num_envs, self.num_agents, 2), np.float32)
        seen[..., 1] = -self.sign[:, None]
        return seen


@pytest.mark.slow
@pytest.mark.parametrize(("team", "critic"), ARRANGEMENTS)
@pytest.mark.long
def test_a_team_learns_several_programs_in_one_batch(team, critic):
    env = Mixture([Roles(64), Contrary(64)], ["roles", "contrary"])
    assert env.num_agents == 3 and env.single_observation_space.shape == (3, 4)
    seen, _ = env.reset(seed=0)
    program = env.levels["program"]
    assert (seen[program == 0, :, 2:] == [1, 0]).all() and (seen[program == 1, :, 2:] == [0, 1]).all()
    assert (np.abs(seen[program == 0, :, 0]) == 1).all() and not seen[program == 0, :, 1].any()
    method = DR(env, dataclasses.replace(QUICK, team=team, critic=critic), seed=1)
    assert max(method.update()["return/student"] for _ in range(40)) > 0.9
    again = DR(Mixture([Roles(64), Contrary(64)], ["roles", "contrary"]), method.ppo, seed=1)
    again.load_state_dict(method.state_dict())
    one, other = method.update(), again.update()
    assert all(one[k] == other[k] or one[k] != one[k] for k in one if not k.startswith("time/"))


def test_programs_of_a_mixture_have_as_many_agents():
    with pytest.raises(ValueError, match="pair has 2 agents, roles 3"):
        Mixture([Roles(4), Roles(4, agents=2)], ["roles", "pair"])


class Opponents(Roles):
    """One step: an agent is paid for following the sign, and what one is paid, the other loses."""

    individual_rewards = True

    def __init__(self, num_envs=16):
        super().__init__(num_envs, agents=2)

    def _advance(self, actions):
        follows = np.where((np.asarray(actions) == 1) == (self.sign[:, None] > 0), 1.0, -1.0)  # [N, A]
        own = follows - follows[:, ::-1]
        observation, _, *over, info = super()._advance(actions)
        return observation, own[:, 0], *over, info | {"agent_rewards": own}


@pytest.mark.long
@pytest.mark.parametrize("team", ["independent", "shared"])
def test_opponents_learn_each_from_what_it_is_paid(team):
    method = DR(Opponents(64), dataclasses.replace(QUICK, team=team), seed=0)
    for _ in range(60):
        metrics = method.update()
    seen = torch.tensor([[[1.0], [1.0]], [[-1.0], [-1.0]]])
    assert (method.student(seen)[0].mode() == torch.tensor([[1, 1], [0, 0]])).all()
    assert abs(metrics["return/student"]) < 0.4  # what one wins the other loses
    rollout = method.learners[0].rollout
    assert rollout.reward.shape == rollout.value.shape and (rollout.reward.sum(-1) == 0).all()
    with pytest.raises(ValueError, match=r"critic='own' \(--critic own"):
        DR(Opponents(), dataclasses.replace(QUICK, team=team, critic="central"))


def test_opponents_do_not_learn_from_regret_which_only_the_first_side_has():
    with pytest.raises(ValueError, match="opponents cannot learn from it: use paired"):
        PairedLiteral(Opponents(), QUICK)
    Paired(Opponents(), QUICK).update()


def test_opponents_score_levels_by_the_critic_of_the_first_side():
    rollout = Rollout.empty(2, 1, Box(-1, 1, (1,)), Discrete(2), agents=3, apart=True)
    rollout.value[..., :] = torch.tensor([0.9, 0.7, -0.9])  # two against one
    rollout.terminated[1] = True
    assert EpisodeValues(1, agents=2).track(rollout, torch.zeros(2, 1, 3))["mean_value"] == pytest.approx([0.8])
    assert scored_agents(Opponents(4)) == 1 and scored_agents(Roles(4)) is None
