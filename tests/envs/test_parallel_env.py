"""PettingZoo: a match by agents, of one team or of both."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

from regista import minigames
from regista.envs.football.config import FootballConfig
from regista.envs.football.constants import DURATION, GOAL, OUT_OF_PLAY, POSSESSION
from regista.envs.football.gym_env import FootballEnv
from regista.envs.football.scenic.lineup import NotAMatchError
from regista.envs.football.vector_env import FootballVectorEnv
from regista.minigames.suites import NAMED

pytest.importorskip("pettingzoo", reason="needs pip install 'regista[pettingzoo]'")
from pettingzoo.test import parallel_api_test, parallel_seed_test

from regista.envs.football.parallel_env import FootballParallelEnv

ELEVEN = "academy/counterattack_easy"  # eleven a side
MATCH = """
param game_duration = 40
ego = LeftCM at 5 @ 3
LeftGK at -99 @ 0
LeftCM on get_reg_from_edges(-30, 0, -20, 20)
RightCM at 40 @ 0
RightGK at 99 @ 0
ball = Ball at 5 @ 0
"""
NAMES = frozenset(("theta", "replaced", "ended"))


def walk(env: FootballParallelEnv, steps: int, seed: int = 0, **options: object) -> list[tuple]:
    """Play with random actions; return what came of each step."""
    rng, seen = np.random.default_rng(seed), []
    env.reset(seed=seed, options=options)
    while env.agents and len(seen) < steps:
        seen.append(env.step({agent: int(rng.integers(19)) for agent in env.agents}))
    return seen


@pytest.mark.slow
@pytest.mark.sample(8)
@pytest.mark.parametrize(
    ("control", "right_control", "count"),
    [
        *((f"closest{k}", "none", k) for k in (1, 2, 3)),
        *(("active", "none", 1), ("2", "none", 2), ("all", "none", 3), ("allNonGK", "none", 2)),
        *(("none", "all", 2), ("closest1", "closest1", 2), ("all", "allNonGK", 4)),
    ],
)
def test_pettingzoo_accepts_it_in_every_control_mode(control: str, right_control: str, count: int) -> None:
    def make() -> FootballParallelEnv:
        return FootballParallelEnv(MATCH, control, right_control)

    env = make()
    assert len(env.possible_agents) == count
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(env, num_cycles=60)
    parallel_seed_test(make, num_cycles=20)


@pytest.mark.parametrize("representation", ["simple115", "smm", "smm_stacked", "raw"])
def test_every_representation(representation: str) -> None:
    env = FootballParallelEnv(MATCH, "all", "2", representation=representation)
    observations, _ = env.reset(seed=0)
    assert all(env.observation_space(agent).contains(observations[agent]) for agent in env.agents)
    if representation == "raw":
        assert env.state_space is None
        with pytest.raises(NotImplementedError, match="'raw' has no state"):
            env.state()
    else:
        assert env.state_space.contains(env.state())
        assert env.state().shape[-1] == 5 * env.observation_space("agent_0").shape[-1]


def test_one_agent_is_the_gymnasium_environment_number_for_number() -> None:
    env, single = FootballParallelEnv(MATCH, "closest1"), FootballEnv(MATCH, control="closest1")
    first, _ = single.reset(seed=3)
    np.testing.assert_array_equal(env.reset(seed=3)[0]["agent_0"], first)
    rng = np.random.default_rng(0)
    while env.agents:
        action = int(rng.integers(19))
        ours, theirs = env.step({"agent_0": action}), single.step(action)
        np.testing.assert_array_equal(ours[0]["agent_0"], theirs[0])
        assert [part["agent_0"] for part in ours[1:4]] == list(theirs[1:4])
        np.testing.assert_array_equal(env.state(), theirs[0])
    assert theirs[2] or theirs[3]


def test_more_than_ten_agents_keep_their_order() -> None:
    """By name "agent_10" comes before "agent_2"; what each sees and does is that of its row all the same."""
    env = minigames.parallel_env(ELEVEN, control="all")
    batch = FootballVectorEnv(NAMED[ELEVEN].program, 1, config=FootballConfig(control="all"))
    assert env.possible_agents == [f"agent_{number}" for number in range(11)]
    observations, _ = env.reset(seed=1)
    rows, _ = batch.reset(seed=1)
    rng = np.random.default_rng(0)
    for _ in range(5):
        np.testing.assert_array_equal(np.stack([observations[agent] for agent in env.agents]), rows[0])
        actions = rng.integers(19, size=(1, 11))
        shuffled = rng.permutation(11)
        observations, *_ = env.step({f"agent_{number}": int(actions[0, number]) for number in shuffled})
        rows, *_ = batch.step(actions)


def test_both_teams_play_against_each_other() -> None:
    """A goal of the left team is one against the right team, whose agents see the pitch turned."""
    env = FootballParallelEnv(MATCH.replace("5 @ 0", "99 @ 0").replace("RightGK at 99", "RightGK at 60"), "1", "1")
    assert env.teams == {"agent_0": "left", "agent_1": "right"}
    seen, _ = env.reset(seed=0)
    matches = env.match.batch.matches
    for agent, (player, side) in zip(env.agents, zip(matches["agents"][0, :2], (1, -1), strict=True), strict=True):
        assert seen[agent][0] == pytest.approx(side * matches["players"][0, player]["x"] / 55, abs=1e-6)
    paid = [step[1] for step in walk(env, 40)]
    assert all(rewards["agent_0"] == -rewards["agent_1"] for rewards in paid)


def test_theta_is_an_option() -> None:
    env = FootballParallelEnv(MATCH, "all")
    _, infos = env.reset(options={"theta": [0.5, -0.5]})
    assert env.theta_space.shape == (2,)
    assert all(infos[agent]["theta"].tolist() == [0.5, -0.5] for agent in env.agents)


def test_an_invalid_theta_is_reported() -> None:
    """A match whose players overlap is replaced by a random valid one."""
    program = "ego = LeftCM at Range(-9, 9) @ 3\nLeftCM at 5 @ 3\nRightGK at 99 @ 0\nball = Ball at 0 @ 0\n"
    env = FootballParallelEnv(program, "all")
    for theta, replaced in ((5 / 9, True), (0.0, False)):
        _, infos = env.reset(options={"theta": [theta]})
        assert all(infos[agent]["replaced"] is replaced for agent in env.agents)
        assert (infos["agent_0"]["theta"] != theta) == replaced


def test_infos_are_numbers_under_the_same_names_throughout() -> None:
    env = FootballParallelEnv(MATCH, "all")
    _, infos = env.reset(seed=0)
    steps = [step[4] for step in walk(env, 100)]
    assert {frozenset(info[agent]) for info in [infos, *steps] for agent in info} == {NAMES}
    reasons = [info["agent_2"]["ended"] for info in steps]
    assert not any(reasons[:-1]) and reasons[-1] in (GOAL, OUT_OF_PLAY, POSSESSION, DURATION)


@pytest.mark.slow
def test_a_copy_by_pickle_is_made_with_the_same_arguments() -> None:
    env = minigames.parallel_env("3v2FourBehaviors", control="allNonGK", representation="simple115")
    twin = pickle.loads(pickle.dumps(env))
    for ours, theirs in zip(walk(env, 10), walk(twin, 10), strict=True):
        np.testing.assert_equal(ours, theirs)


def test_what_does_not_fit_is_refused_in_one_sentence() -> None:
    with pytest.raises(NotAMatchError, match="control '5' needs 5 players in the left team, which has 3"):
        FootballParallelEnv(MATCH, "5")
    with pytest.raises(ValueError, match="unknown minigame '4v4'; known are 1v1Restricted"):
        minigames.parallel_env("4v4")
    env = FootballParallelEnv(MATCH, "2")
    with pytest.raises(RuntimeError, match=r"no match is running; call reset\(\) before step\(\)"):
        env.step({"agent_0": 0, "agent_1": 0})
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"needs an action for each of agent_0, agent_1, got agent_0$"):
        env.step({"agent_0": 0})
